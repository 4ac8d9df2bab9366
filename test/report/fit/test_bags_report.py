# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Several recordings in one report: together first, then each."""

import dataclasses
import io
import math
import re

import numpy as np
import pytest
from rich.console import Console

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.law.law_curve import fitted_law
from sosml_friction.identification.number_text import interval_text, value_text
from sosml_friction.identification.several.bag_points import bag_points
from sosml_friction.identification.several.consolidation import BY_RULE, JOINT
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.common import figure
from sosml_friction.report.figures.bags.law import BagsLaw
from sosml_friction.report.fit import html
from sosml_friction.report.fit.consolidation_view import (
    WAYS,
    bags_joints,
    bags_table,
    consolidated_remarks,
    consolidated_rows,
    consolidated_table,
)


@pytest.fixture(scope='module')
def text(bags, truth):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figure, 'to_svg', lambda *drawn: '<svg></svg>')
        return html.render_bags_report(bags, truth, {'command': 'sosml fit <a> b'})


def test_what_all_say_together_comes_first_and_each_recording_after_it(text):
    headings = re.findall(r'<h2>(.*?)</h2>', text)
    assert headings == [
        'Joint shoulder, all recordings',
        'Joint elbow, all recordings',
        'Recording ladder (T1)',
        'Recording slow (T3)',
        'How it was done',
    ]
    beginning = text[: text.index('<h2>')]
    for joint in ('shoulder', 'elbow'):
        assert re.search(rf'<strong>{joint}</strong>: \d', beginning)
    assert 'the recording has no effort of it' in text
    assert '&lt;a&gt;' in text


def test_the_provenance_has_both_recordings(text, analysis):
    assert text.count(analysis.model.provenance['sha256']) == 2


def test_no_unknown_number_is_printed_as_such(text):
    visible = re.sub(r'<style>.*?</style>|<[^>]*>', ' ', text, flags=re.DOTALL)
    assert not re.search(r'\b(nan|inf|None)\b', visible)


def test_each_recording_the_rule_and_the_joint_fit_have_a_row_with_their_numbers(bags):
    view = bags_joints(bags)['shoulder']
    entry, rows = view.entry, consolidated_rows(view)
    assert [row.label for row in rows] == ['ladder (T1)', 'slow (T3)', WAYS[BY_RULE], WAYS[JOINT]]
    assert [row.label for row in rows if row.is_model] == [WAYS[entry.preferred]]
    assert rows[-1].parameters['coulomb'] == entry.joint_fit.parameters['coulomb']
    assert rows[-2].parameters == entry.rule.parameters
    table = consolidated_table(view)
    for row in rows:
        for name, parameter in row.parameters.items():
            assert re.search(rf'>{re.escape(value_text(name, parameter))}( \(|</td>)', table)


def test_what_is_not_identifiable_is_a_range_in_every_table(bags):
    view = bags_joints(bags)['shoulder']
    entry = view.entry
    unknown = Parameter(math.nan, 'Nm', interval=(0.2, math.inf), flags=(NOT_IDENTIFIABLE,))
    fit = dataclasses.replace(
        entry.joint_fit, parameters={**entry.joint_fit.parameters, 'stribeck': unknown}
    )
    changed = dataclasses.replace(entry, joint_fit=fit)
    assert '>above 0.200</td>' in consolidated_table(view._replace(entry=changed))
    joints = {**bags.consolidation.joints, 'shoulder': {'sosml': changed}}
    consolidation = dataclasses.replace(bags.consolidation, joints=joints)
    assert 'above 0.200' in printed(dataclasses.replace(bags, consolidation=consolidation))


def printed(bags, truth=None):
    stream = io.StringIO()
    Console(file=stream, width=120).print(bags_table(bags, truth))
    return stream.getvalue()


def test_the_terminal_has_units_intervals_the_truth_and_the_reason(bags, truth):
    shown = printed(bags, truth)
    for word in ('[rad/s]', '[Nm s/rad]', 'ladder (T1)', 'slow (T3)', 'truth', '* joint fit'):
        assert word in shown
    entry = bags_joints(bags)['shoulder'].entry
    for end in interval_text(entry.parameters['coulomb']).split(' to '):
        assert end in shown
    assert entry.reason.split(':')[0] in ' '.join(shown.split())


def test_the_figure_has_the_rows_of_each_recording_less_the_law(bags):
    view = bags_joints(bags)['shoulder']
    points = bag_points(view.fits['ladder'], 'shoulder', 'sosml')
    figure = BagsLaw().draw(view)
    whole, _, residual, _ = figure.axes
    for axes in (whole, residual):
        lines = [line for line in axes.lines if line.get_marker() == 'o']
        assert np.allclose(lines[0].get_xdata(), points.velocity)
    (drawn,) = [line for line in whole.lines if line.get_marker() == 'o']
    assert np.allclose(drawn.get_ydata(), points.friction)
    (left,) = [line for line in residual.lines if line.get_marker() == 'o']
    law = fitted_law(view.entry.joint_fit)
    assert np.allclose(left.get_ydata(), points.friction - law.torque(points.velocity))


def test_many_rows_are_means_in_bins_of_speed_by_direction(bags):
    rows = bags.bags['ladder'].fit.rows['shoulder']['sosml']
    v = np.tile(np.linspace(-0.5, 0.5, 1000), 5)
    law = np.sign(v) * 0.8 + 0.3 * v
    many = dataclasses.replace(
        rows, v=v, y=law, mean_v=v, keep=np.ones(len(v), dtype=bool),
        clusters=np.arange(len(v)),
    )  # fmt: skip
    fit = dataclasses.replace(bags.bags['ladder'].fit, rows={'shoulder': {'sosml': many}})
    points = bag_points(fit, 'shoulder', 'sosml')
    assert len(points.velocity) <= 48
    expected = np.sign(points.velocity) * 0.8 + 0.3 * points.velocity
    assert np.allclose(points.friction, expected)
    assert bag_points(fit, 'shoulder', 'kalman') is None


def test_a_truth_of_other_joints_is_refused(bags, truth):
    other = dataclasses.replace(truth, joints={'wrist': truth.joints['elbow']})
    with pytest.raises(ConfigurationError, match=r'none of shoulder, elbow'):
        html.render_bags_report(bags, other)


def test_a_truth_outside_of_what_all_say_together_is_noted(bags, truth):
    view = bags_joints(bags)['shoulder']
    friction = truth.joints['shoulder'].friction
    wrong = dataclasses.replace(friction.parameters['viscous'], value=99.0)
    moved = dataclasses.replace(friction, parameters={**friction.parameters, 'viscous': wrong})
    told = consolidated_remarks(view._replace(truth=moved))
    assert any('truth is outside' in remark and 'viscous' in remark for remark in told)
    assert not any('truth' in remark for remark in consolidated_remarks(view))
