# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""All figures of a joint: units on axes, legends beside the data, nothing shown unknown."""

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
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import figures
from sosml_friction.report.figures.fit.overview import Overview
from sosml_friction.report.fit.joint_view import joint_views

FIGURES = {figure.identifier: figure for figure in figures('fit')}


@pytest.fixture(scope='module')
def view(analysis, truth):
    return joint_views(analysis, truth)[0]


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


@pytest.mark.parametrize('name', FIGURES)
def test_a_figure_is_whole_in_type_of_one_size_and_its_legend_covers_nothing(view, name):
    figure = FIGURES[name].draw(view)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    assert figure.bbox.width in (600, 1000)
    (legend,) = figure.legends
    box = legend.get_window_extent(renderer)
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.x1
    tight = [axes.get_tightbbox(renderer) for axes in figure.axes]
    assert not any(box.overlaps(each) for each in tight)
    for k, one in enumerate(tight):
        # Half a point is rounding.
        assert one.x0 >= -0.5
        assert one.x1 <= figure.bbox.x1 + 0.5
        for other in tight[:k]:
            inner = (min(one.x1, other.x1) - max(one.x0, other.x0),
                     min(one.y1, other.y1) - max(one.y0, other.y0))  # fmt: skip
            assert min(inner) < 1.0, 'two panels are over one another'
    sizes = {
        text.get_fontsize()
        for text in figure.findobj(Text)
        if text.get_visible() and text.get_text()
    }
    assert len(sizes) == 1 or name == 'profile'  # powers of ten are smaller


@pytest.mark.parametrize('name', FIGURES)
def test_every_labelled_axis_has_its_unit(view, name):
    labels = [
        label
        for axes in FIGURES[name].draw(view).axes
        for label in (axes.get_xlabel(), axes.get_ylabel())
    ]
    assert any(labels)
    assert all(label.endswith(']') for label in labels if label)


def test_the_legend_stays_off_the_axes_with_hundreds_of_windows_not_used(view):
    figure = Overview().draw(with_rejected(view, 300))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    box = figure.legends[0].get_window_extent(canvas.get_renderer())
    assert box.x1 <= figure.bbox.x1
    for axes in figure.axes:
        assert not box.overlaps(axes.get_tightbbox(canvas.get_renderer()))


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
    assert np.isnan(y).any()


def test_pyplot_and_its_global_state_stay_out():
    code = (
        'import sys, sosml_friction.report.fit.html as _\n'
        'from sosml_friction.report.common.figure import REPORTS, figures\n'
        'print(all(map(figures, REPORTS)), "matplotlib.pyplot" in sys.modules)'
    )
    answer = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True
    )
    assert answer.stdout.split() == ['True', 'False']
