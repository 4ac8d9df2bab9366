# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Figures: units on axes, legends beside the data, nothing shown that is not known."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from sosml_friction.identification.segments import Segment
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report import drawing, figures
from sosml_friction.report.joint_view import joint_views

DRAWINGS = (figures.s_curve, figures.time_traces, figures.parameter_bars, figures.residuals)


@pytest.fixture(scope='module')
def views(analysis, truth):
    return joint_views(analysis, truth)


def with_rejected(view, count):
    """Return the view with many more windows that were not used."""
    extra = tuple(
        Segment(k, k + 5, 0.02 * k, 0.02 * k + 0.01, 0.1, f'steady for only 0.{k % 9} s')
        for k in range(count)
    )
    fits = {
        observer: dataclasses.replace(
            fit,
            segments=fit.segments + extra,
            levels=np.append(fit.levels, np.full(count, np.nan)),
        )
        for observer, fit in view.fits.items()
    }
    return dataclasses.replace(view, fits=fits)


def flagged(view, name, interval):
    """Return the view with one parameter of every fit made not identifiable."""
    unknown = Parameter(0.5, 'Nm', interval=interval, flags=(NOT_IDENTIFIABLE,))

    def change(fits):
        result = {}
        for observer, fit in fits.items():
            parameters = {**fit.fit.parameters, name: unknown}
            law = dataclasses.replace(fit.fit, law='coulomb_viscous', parameters=parameters)
            result[observer] = dataclasses.replace(fit, fit=law)
        return result

    return dataclasses.replace(
        view, fits=change(view.fits), alternatives=change(view.alternatives), truth=None
    )


@pytest.mark.parametrize('draw', DRAWINGS)
def test_a_figure_is_a_png_a_thousand_dots_wide(views, draw):
    png = drawing.to_png(draw(views[0]))
    assert png.startswith(b'\x89PNG')
    assert int.from_bytes(png[16:20], 'big') == 1000


@pytest.mark.parametrize('many', [0, 300])
@pytest.mark.parametrize('draw', DRAWINGS)
def test_the_legend_is_inside_the_picture_and_off_the_axes(views, draw, many):
    figure = draw(with_rejected(views[0], many))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    (legend,) = figure.legends
    box = legend.get_window_extent(canvas.get_renderer())
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.x1
    for axes in figure.axes:
        assert not box.overlaps(axes.get_tightbbox(canvas.get_renderer()))


@pytest.mark.parametrize('draw', DRAWINGS)
def test_every_text_has_the_same_size(views, draw):
    figure = draw(views[1])
    FigureCanvasAgg(figure).draw()
    sizes = {
        text.get_fontsize()
        for text in figure.findobj(Text)
        if text.get_visible() and text.get_text()
    }
    assert len(sizes) == 1


@pytest.mark.parametrize('draw', [figures.s_curve, figures.time_traces, figures.residuals])
def test_every_labelled_axis_has_its_unit(views, draw):
    labels = [
        label for axes in draw(views[0]).axes for label in (axes.get_xlabel(), axes.get_ylabel())
    ]
    assert any(labels)
    assert all(label.endswith(']') for label in labels if label)


def test_the_bars_show_each_parameter_with_its_unit(views):
    titles = [axes.get_title() for axes in figures.parameter_bars(views[0]).axes]
    assert titles == ['C [Nm]', 'B [Nm s/rad]', 'S [Nm]', 'v_s [rad/s]', 'bias [Nm]']


@pytest.mark.parametrize('interval', [None, (0.0, 1.5)])
def test_what_is_not_identifiable_has_no_marker(views, interval):
    panel = figures.parameter_bars(flagged(views[0], 'stribeck', interval)).axes[2]
    markers = [line.get_marker() for line in panel.lines]
    assert all(marker in ('None', '') for marker in markers)
    words = [text.get_text() for text in panel.texts]
    assert ('not identifiable' in words) == (interval is None)
    assert bool(panel.lines) == (interval is not None)


def test_a_range_that_is_hardly_bounded_does_not_flatten_the_numbers(views):
    view = flagged(views[0], 'stribeck', (0.0, 1e6))
    mixed = dataclasses.replace(view, truth=views[0].truth)
    low, high = figures.parameter_bars(mixed).axes[2].get_ylim()
    assert high - low < 10.0


def test_the_law_is_not_drawn_across_zero_velocity(views):
    for line in figures.s_curve(dataclasses.replace(views[0], truth=None)).axes[0].lines:
        v = np.asarray(line.get_xdata(), dtype=float)
        if line.get_linestyle() != 'None' and len(v) > 2:
            assert (v > 0.0).all() or (v < 0.0).all()


def test_the_medians_drawn_are_those_of_the_used_windows(views):
    view = views[0]
    axes = figures.s_curve(view).axes[0]
    fit = view.fits['sosml']
    used = [k for k, segment in enumerate(fit.segments) if not segment.rejected]
    expected = [(fit.segments[k].velocity, fit.levels[k]) for k in used]
    filled = [
        line
        for line in axes.lines
        if line.get_marker() == 's' and line.get_markerfacecolor() != 'none'
    ]
    assert len(filled) == 1
    assert np.allclose(np.column_stack(filled[0].get_data()), expected)


def test_windows_not_used_are_explained_and_counted(views):
    figure = figures.time_traces(with_rejected(views[0], 27))
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any('not used, steady for only 0' in label and '(' in label for label in labels)
    used = sum(not segment.rejected for segment in views[0].segments)
    assert f'steady window used ({used})' in labels


def test_a_joint_without_effort_is_drawn_as_unknown(one_joint_analysis):
    elbow = joint_views(one_joint_analysis)[1]
    axes = figures.time_traces(elbow).axes
    assert [t.get_text() for t in axes[2].texts] == ['unknown']
    assert drawing.to_png(figures.time_traces(elbow)).startswith(b'\x89PNG')


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 3), st.randoms(use_true_random=False))
def test_the_envelope_keeps_extremes_and_the_order_of_time(size, random):
    count = size * 5000
    values = np.array([random.gauss(0.0, 1.0) for _ in range(50)])[np.arange(count) % 50]
    values[random.randrange(count)] = 99.0
    values[random.randrange(count)] = -99.0
    first = random.randrange(count)
    values[first : first + 700] = np.nan
    time = np.arange(count, dtype=float)
    t, y = drawing.envelope(time, values)
    assert len(t) <= 5000
    assert (np.diff(t) > 0).all()
    assert np.nanmax(y) == np.nanmax(values)
    assert np.nanmin(y) == np.nanmin(values)


def test_pyplot_and_its_global_state_stay_out():
    code = 'import sys, sosml_friction.report.html; print("matplotlib.pyplot" in sys.modules)'
    answer = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.strip() == 'False'
