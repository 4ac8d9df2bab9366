# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters with intervals: a bar where there is a number, a range where there is none."""

import math

import numpy as np
import pytest

from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.common.drawing import style_of
from sosml_friction.report.common.labels import SYMBOLS
from sosml_friction.report.common.parameter_bars import ParameterRow, draw_parameters
from sosml_friction.report.figures.fit.parameters import parameter_rows
from sosml_friction.report.fit.joint_view import joint_views

KNOWN = {name: Parameter(0.5, 'Nm', 0.02, (0.46, 0.54)) for name in SYMBOLS}


def drawn(parameter, known=True):
    """Return the panel of S with one row as usual, where ``known``, and one with ``parameter``."""
    rows = [
        ParameterRow('usual', KNOWN if known else {}, style_of('sosml', 0)),
        ParameterRow('other', {**KNOWN, 'stribeck': parameter}, style_of('first_order', 1)),
    ]
    panel = draw_parameters(rows).axes[2]
    mine = [line for line in panel.lines if np.allclose(line.get_ydata(), 1.0, atol=0.2)]
    return panel, mine


def test_a_joint_has_a_row_for_each_observer_and_method(analysis):
    view = joint_views(analysis)[0]
    rows = parameter_rows(view)
    fits = [*view.fits.values(), *view.alternatives.values()]
    assert sorted(row.label for row in rows) == sorted(
        f'{"FO" if fit.observer == "first_order" else "SOSML"}, {fit.method}' for fit in fits
    )
    assert [row.label for row in rows if row.is_model] == [f'SOSML, {view.fits["sosml"].method}']
    figure = draw_parameters(rows)
    assert [axes.get_xlabel() for axes in figure.axes] == [
        'C [Nm]', 'B [Nm s/rad]', 'S [Nm]', 'v_s [rad/s]', 'bias [Nm]',
    ]  # fmt: skip
    labels = [tick.get_text() for tick in figure.axes[0].get_yticklabels()]
    assert labels == [row.label for row in rows]


def test_a_number_has_its_marker_and_its_interval():
    _, lines = drawn(Parameter(0.52, 'Nm', 0.03, (0.45, 0.59)))
    markers = [line for line in lines if line.get_marker() == 'o']
    assert [float(line.get_xdata()[0]) for line in markers] == [0.52]
    ends = {float(x) for line in lines for x in line.get_xdata()}
    assert {0.45, 0.59} <= ends


@pytest.mark.parametrize('interval', [(0.4, 0.6), (0.45, math.inf), (0.0, 0.6), (0.0, 40.0)])
def test_what_is_not_identifiable_is_a_range_with_an_arrow_where_it_leaves_the_panel(interval):
    unknown = Parameter(math.nan, 'Nm', interval=interval, flags=(NOT_IDENTIFIABLE,))
    panel, lines = drawn(unknown)
    arrows = sum(not panel.get_xlim()[0] <= end <= panel.get_xlim()[1] for end in interval)
    assert arrows == (interval[1] > 1.5)
    assert sum(line.get_gid() == 'open end' for line in lines) == arrows
    ranges = [line for line in lines if line.get_linewidth() == 7]
    assert len(ranges) == 1
    left, right = panel.get_xlim()
    assert np.allclose(ranges[0].get_xdata(), np.clip(interval, left, right))
    assert all(line.get_marker() in ('None', '<', '>') for line in lines)


@pytest.mark.parametrize('interval', [None, (0.0, math.inf), (math.nan, math.nan)])
@pytest.mark.parametrize('known', [True, False])
def test_what_the_data_say_nothing_of_is_in_words(interval, known):
    unknown = Parameter(math.nan, 'Nm', interval=interval, flags=(NOT_IDENTIFIABLE,))
    panel, lines = drawn(unknown, known)
    assert 'not identifiable' in [text.get_text() for text in panel.texts]
    assert not lines


def test_a_number_far_from_all_others_is_written_at_the_edge_and_flattens_nothing():
    rows = [ParameterRow(str(k), KNOWN, style_of('sosml', 0)) for k in range(3)]
    far = {**KNOWN, 'coulomb': Parameter(50.0, 'Nm', 1.0, (48.0, 52.0))}
    panel = draw_parameters([*rows, ParameterRow('far', far, style_of('sosml', 0))]).axes[0]
    left, right = panel.get_xlim()
    assert right - left < 2.0
    assert [text.get_text() for text in panel.texts] == ['50.0']


def test_a_value_at_its_bound_says_so_and_the_truth_is_a_line():
    zero = Parameter(0.0, 'Nm', interval=(0.0, 0.1), flags=(AT_BOUND,))
    rows = [ParameterRow('one', {**KNOWN, 'viscous': zero}, style_of('sosml', 0))]
    figure = draw_parameters(rows, {'viscous': Parameter(0.02, 'Nm')})
    panel = figure.axes[1]
    assert [text.get_text() for text in panel.texts] == ['at bound']
    assert any(np.allclose(line.get_xdata(), 0.02) for line in panel.lines)
    assert 'truth' in [text.get_text() for text in figure.legends[0].get_texts()]


def test_a_law_by_direction_has_panels_of_its_own():
    row = {**KNOWN, 'viscous_asymmetry': Parameter(-37.0, 'N s/m', 2.0, (-41.0, -33.0))}
    figure = draw_parameters([ParameterRow('one', row, style_of('sosml', 0))])
    assert figure.axes[-1].get_xlabel() == 'D_B [N s/m]'


def test_of_ranges_alone_the_narrowest_is_seen_and_the_widest_runs_out():
    rows = [
        ParameterRow(
            str(high),
            {
                'stribeck': Parameter(
                    math.nan, 'N', interval=(0.0, high), flags=(NOT_IDENTIFIABLE,)
                )
            },
            style_of('sosml', 0),
        )
        for high in (12.0, 3e6)
    ]
    panel = draw_parameters(rows).axes[2]
    assert 12.0 < panel.get_xlim()[1] < 100.0
    open_ends = [line for line in panel.lines if line.get_gid() == 'open end']
    assert [float(line.get_ydata()[0]) for line in open_ends] == [1.0]
