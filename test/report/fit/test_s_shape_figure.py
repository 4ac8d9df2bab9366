# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction against velocity: what is drawn is what was fitted."""

import dataclasses

import numpy as np
import pytest

from sosml_friction.identification.law.law_curve import band, fitted_law
from sosml_friction.report.figures.fit.s_shape import SShape
from sosml_friction.report.fit.joint_view import joint_views


@pytest.fixture(scope='module')
def view(rejecting_analysis):
    return joint_views(rejecting_analysis)[0]


@pytest.fixture(scope='module')
def figure(view):
    return SShape().draw(view)


def points(axes, marker):
    """Return the points drawn with a marker whose face is that of a level in use."""
    return [
        np.column_stack(line.get_data())
        for line in axes.lines
        if line.get_marker() == marker and line.get_markerfacecolor() not in ('none', 'white')
    ]


def test_each_observer_has_a_panel_over_velocity_and_one_over_the_logarithm_of_speed(view, figure):
    whole, knee = figure.axes[: len(view.fits)], figure.axes[len(view.fits) :]
    assert [axes.get_xscale() for axes in whole] == ['linear'] * len(view.fits)
    assert [axes.get_xscale() for axes in knee] == ['log'] * len(view.fits)
    titles = [axes.get_title() for axes in whole]
    assert titles == ['FO', 'SOSML (the model)']


def test_the_levels_drawn_are_those_of_the_used_windows(view, figure):
    fit = view.fits['sosml']
    used = [k for k, segment in enumerate(fit.segments) if not segment.rejected]
    expected = [(fit.segments[k].velocity, fit.levels[k]) for k in used]
    (drawn,) = points(figure.axes[1], 's')
    assert np.allclose(drawn, expected)


def test_the_knee_has_friction_that_opposes_motion_both_ways(view, figure):
    fit = view.fits['sosml']
    bias = fit.fit.parameters['bias'].value
    for way, marker in ((1.0, '^'), (-1.0, 'v')):
        expected = [
            (way * s.velocity, way * (level - bias))
            for s, level in zip(fit.segments, fit.levels, strict=True)
            if not s.rejected and way * s.velocity > 0.0
        ]
        (drawn,) = points(figure.axes[3], marker)
        assert np.allclose(drawn, expected)
        assert (drawn > 0.0).all()


def test_the_law_is_drawn_with_its_band_on_one_side_of_zero_at_a_time(view, figure):
    law = fitted_law(view.fits['first_order'].fit)
    axes = figure.axes[0]
    lines = [
        line
        for line in axes.lines
        if line.get_linestyle() in ('-', ':') and len(line.get_xdata()) > 100
    ]
    assert lines
    for line in lines:
        v, y = (np.asarray(x, dtype=float) for x in line.get_data())
        assert (v > 0.0).all() or (v < 0.0).all()
        known = np.isfinite(y)
        assert np.allclose(y[known], law.torque(v[known]))
    v = np.array([0.3])
    half = band(view.fits['first_order'].fit, v)[0]
    middle = law.torque(v)[0]
    inside = [
        path.contains_point((0.3, middle + share * half))
        for share in (0.9, -0.9, 1.1, -1.1)
        for path in [_band_path(axes, 0.3)]
    ]
    assert inside == [True, True, False, False]


def _band_path(axes, v):
    for collection in axes.collections:
        for path in collection.get_paths():
            box = path.get_extents()
            if len(path.vertices) > 300 and box.x0 <= v <= box.x1:
                return path
    raise AssertionError('no band')


def test_the_law_is_dotted_below_the_slowest_speed_of_the_data(view, figure):
    slowest = view.fits['sosml'].fit.slowest
    lines = {
        line.get_linestyle(): np.asarray(line.get_xdata())[np.isfinite(line.get_ydata())]
        for line in figure.axes[3].lines
        if line.get_linestyle() in ('-', ':') and len(line.get_xdata()) > 100
    }
    assert lines['-'].min() >= slowest
    assert lines[':'].max() < slowest


@pytest.mark.parametrize('count', [1, 4, 7])
def test_any_number_of_observers_has_its_panels(view, count):
    names = ['sosml', *(f'observer_{k}' for k in range(count - 1))]
    many = dataclasses.replace(
        view,
        estimates=dict.fromkeys(names, view.estimates['sosml']),
        fits=dict.fromkeys(names, view.fits['sosml']),
    )
    shown = [axes for axes in SShape().draw(many).axes if axes.get_visible()]
    assert len(shown) == 2 * count


def test_windows_not_used_are_pale_and_there(view, figure):
    fit = view.fits['sosml']
    expected = sorted(s.velocity for s in fit.segments if s.rejected)
    drawn = [
        line.get_xdata()
        for line in figure.axes[1].lines
        if line.get_marker() == 's' and line.get_markerfacecolor() == 'white'
    ]
    assert len(expected) >= 3
    assert np.allclose(sorted(drawn[0]), expected)
