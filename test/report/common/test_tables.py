# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The terminal's table: every number with its unit, complete on 80 columns."""

import dataclasses
import io
import math

import pytest
from rich.console import Console

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.common.tables import parameter_table


def printed(table, width=100):
    stream = io.StringIO()
    Console(file=stream, width=width).print(table)
    return stream.getvalue()


def rows(text):
    """Return the cells of each row that has a parameter, by joint and parameter."""
    result, joint = {}, ''
    for line in text.splitlines():
        cells = line.split()
        if cells and cells[0] in ('shoulder', 'elbow'):
            joint, cells = cells[0], cells[1:]
        if cells and cells[0] in ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'bias'):
            result[joint, cells[0]] = cells[1:]
    return result


def without_stribeck(analysis):
    """Return the analysis as if the shoulder's Stribeck term had not been identifiable."""
    fits = {}
    for observer, fit in analysis.fit.joints['shoulder'].items():
        parameters = dict(fit.fit.parameters)
        parameters['stribeck'] = Parameter(
            0.77, 'Nm', interval=(-0.1, 1.234), flags=(NOT_IDENTIFIABLE,)
        )
        parameters['stribeck_velocity'] = Parameter(math.nan, 'rad/s', flags=(NOT_IDENTIFIABLE,))
        law = dataclasses.replace(fit.fit, law='coulomb_viscous', parameters=parameters)
        fits[observer] = dataclasses.replace(fit, fit=law)
    joints = {**analysis.fit.joints, 'shoulder': fits}
    return dataclasses.replace(analysis, fit=dataclasses.replace(analysis.fit, joints=joints))


def test_each_parameter_has_unit_truth_both_observers_and_standard_error(analysis, truth):
    table = rows(printed(parameter_table(analysis, truth)))
    assert len(table) == 10
    unit, known, fo, sosml, error = table['shoulder', 'coulomb']
    assert (unit, known) == ('Nm', '0.8')
    fits = analysis.fit.joints['shoulder']
    for text, observer in ((fo, 'first_order'), (sosml, 'sosml')):
        parameter = fits[observer].fit.parameters['coulomb']
        assert float(text) == pytest.approx(parameter.value, abs=0.06 * parameter.std_error)
    expected = fits['sosml'].fit.parameters['coulomb'].std_error
    assert float(error) == pytest.approx(expected, rel=0.05)
    assert table['elbow', 'viscous'][:2] == ['Nm', 's/rad']


def test_without_truth_there_is_no_truth_column(analysis):
    text = printed(parameter_table(analysis))
    assert 'truth' not in text
    assert len(rows(text)['elbow', 'bias']) == 4


@pytest.mark.parametrize('width', [80, 100])
def test_the_table_of_the_usual_analysis_fits_into_the_terminal(one_joint_analysis, truth, width):
    text = printed(parameter_table(one_joint_analysis, truth), width)
    assert '…' not in text
    assert max(map(len, text.splitlines())) <= width
    fits = one_joint_analysis.fit.joints['shoulder']
    found = rows(text)['shoulder', 'bias']
    assert len(found) == 1 + 1 + len(fits) + 1
    coulomb = fits['weak_form'].fit.parameters['coulomb']
    shown = float(rows(text)['shoulder', 'coulomb'][4])
    assert shown == pytest.approx(coulomb.value, abs=0.06 * coulomb.std_error)


@pytest.mark.parametrize('width', [80, 100])
def test_the_table_fits_into_the_terminal_without_losing_a_character(analysis, truth, width):
    for variant in (analysis, without_stribeck(analysis)):
        text = printed(parameter_table(variant, truth), width)
        assert '…' not in text
        for word in ('stribeck_velocity', 'rad/s', 'shoulder', 'elbow', 'SOSML'):
            assert word in text
        assert max(map(len, text.splitlines())) <= width


def test_what_is_not_identifiable_is_a_range_or_a_dash(analysis, truth):
    table = rows(printed(parameter_table(without_stribeck(analysis), truth)))
    assert table['shoulder', 'stribeck'][2:] == ['0', 'to', '1.23', '0', 'to', '1.23', '-']
    words = table['shoulder', 'stribeck_velocity'][2:]
    assert words == ['-', '-', '-']


def test_a_joint_without_fit_says_why(one_joint_analysis):
    text = printed(parameter_table(one_joint_analysis))
    assert 'elbow' in text
    assert 'unavailable' in text
    assert 'has no effort of it' in text
    assert ('elbow', 'coulomb') not in rows(text)


def test_a_truth_of_other_joints_is_refused(analysis, truth):
    other = dataclasses.replace(truth, joints={'wrist': truth.joints['elbow']})
    with pytest.raises(ConfigurationError, match=r'wrist.*shoulder, elbow'):
        parameter_table(analysis, other)


def test_a_law_by_direction_has_rows_of_its_own(analysis):
    fit = analysis.fit.joints['shoulder']['sosml']
    extra = Parameter(-37.2, 'Nm s/rad', 2.0, (-41.0, -33.4))
    law = dataclasses.replace(
        fit.fit, parameters={**fit.fit.parameters, 'viscous_asymmetry': extra}
    )
    joints = {
        **analysis.fit.joints,
        'shoulder': {
            **analysis.fit.joints['shoulder'],
            'sosml': dataclasses.replace(fit, fit=law),
        },
    }
    changed = dataclasses.replace(analysis, fit=dataclasses.replace(analysis.fit, joints=joints))
    lines = printed(parameter_table(changed)).splitlines()
    (row,) = [line.split() for line in lines if 'viscous_asymmetry' in line]
    assert row == ['viscous_asymmetry', 'Nm', 's/rad', '-', '-37.2', '2.0']
