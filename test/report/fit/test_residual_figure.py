# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the law leaves: a structure that was put in is seen where it belongs."""

import dataclasses

import numpy as np
import pytest

from sosml_friction.identification.law.law_curve import fitted_law
from sosml_friction.identification.law_residual import (
    Residual,
    autocorrelation,
    binned_mean,
)
from sosml_friction.report.figures.fit.residual import LawResidual
from sosml_friction.report.fit.joint_view import joint_views


@pytest.fixture(scope='module')
def view(analysis):
    return joint_views(analysis)[0]


def with_estimate(view, tau_f):
    return dataclasses.replace(view, estimates={**view.estimates, 'sosml': tau_f})


def test_the_residual_is_estimate_less_law_in_the_windows_used(view):
    residual = view.residual()
    law = fitted_law(view.fits['sosml'].fit)
    k = residual.samples
    assert np.allclose(residual.value, view.estimates['sosml'][k] - law.torque(view.speed[k]))
    for number, segment in enumerate(view.segments):
        inside = (residual.samples >= segment.first) & (residual.samples <= segment.last)
        assert inside.any() == (not segment.rejected)
        assert set(residual.runs[inside]) <= {number}


def test_a_force_that_depends_on_position_is_seen_over_position(view):
    law = fitted_law(view.fits['sosml'].fit)
    wave = 0.1 * np.sin(2.0 * np.pi * view.q / 0.5)
    made = with_estimate(view, law.torque(np.nan_to_num(view.speed)) + wave)
    residual = made.residual()
    middle, mean = binned_mean(view.q[residual.samples], residual.value)
    known = np.isfinite(mean)
    # A bin is a fortieth of the range: the wave turns by 0.1 rad or so within it.
    expected = 0.1 * np.sin(2.0 * np.pi * middle[known] / 0.5)
    assert np.allclose(mean[known], expected, atol=0.02)


def test_white_noise_has_no_autocorrelation_and_a_constant_has_one():
    rng = np.random.default_rng(0)
    runs = np.repeat(np.arange(10), 1000)
    samples = np.arange(len(runs))
    white, pairs = autocorrelation(Residual(samples, rng.normal(size=len(runs)), runs), 100)
    assert white[0] == pytest.approx(1.0)
    assert np.abs(white[1:]).max() < 5.0 / np.sqrt(pairs[1:].min())
    assert pairs[100] == 10 * 900
    constant, _ = autocorrelation(Residual(samples, np.full(len(runs), 0.3), runs), 100)
    assert np.allclose(constant, 1.0)


def test_the_autocorrelation_is_that_of_the_definition_and_never_crosses_windows():
    rng = np.random.default_rng(1)
    value, runs = rng.normal(size=30), np.repeat([3, 4, 9], [15, 5, 10])
    found, pairs = autocorrelation(Residual(np.arange(30), value, runs), 12)
    for lag in range(13):
        both = [(value[k], value[k + lag]) for k in range(30 - lag) if runs[k] == runs[k + lag]]
        one, two = np.array(both).reshape(-1, 2).T
        assert pairs[lag] == len(both)
        assert found[lag] == pytest.approx((one @ two) / np.sqrt((one @ one) * (two @ two)))


def test_without_a_window_the_samples_in_motion_are_shown(view):
    fits = {
        observer: dataclasses.replace(
            fit, segments=tuple(dataclasses.replace(s, rejected='no') for s in fit.segments)
        )
        for observer, fit in view.fits.items()
    }
    moving = dataclasses.replace(view, fits=fits).residual()
    assert len(moving.samples) > len(view.residual().samples)
    assert (np.abs(view.speed[moving.samples]) > view.zero_band).all()


def test_the_figure_names_what_it_shows_and_a_joint_without_fit_has_none(view, one_joint_analysis):
    labels = [axes.get_xlabel() for axes in LawResidual().draw(view).axes]
    assert labels == ['velocity [rad/s]', 'position [rad]', 'time [s]', 'lag [s]']
    assert not LawResidual().applies(joint_views(one_joint_analysis)[1])


def test_the_levels_shown_are_what_the_law_leaves_of_each_window(view):
    panel = LawResidual().draw(view).axes[0]
    for observer, marker in (('sosml', 's'), ('first_order', 'o')):
        fit = view.fits[observer]
        law = fitted_law(fit.fit)
        expected = [
            (s.velocity, level - law.torque(np.array([s.velocity]))[0])
            for s, level in zip(fit.segments, fit.levels, strict=True)
            if not s.rejected
        ]
        (line,) = [line for line in panel.lines if line.get_marker() == marker]
        assert np.allclose(np.column_stack(line.get_data()), expected)
