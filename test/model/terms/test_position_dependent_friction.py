# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction over position, of a period that nobody knows beforehand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from full_runs import in_full
from known_robots import SLIDER_MASS, recording, sines, slider_model, smooth_sign

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.terms.position_dependent_friction import PositionDependentFriction
from sosml_friction.regression.settings import DiagnosisSettings


@pytest.mark.parametrize('periods', [0.8, in_full(1.25), 2.7])
def test_friction_over_a_linear_axis_is_found_whatever_its_period(periods):
    """Nothing else makes up for it: multiples of half a period in the range make any course."""
    t = np.arange(0.0, 40.0, 4e-3)
    q, v, a = sines(t, ((0.08, 0.9), (0.02, 2.1)))
    w = 2.0 * np.pi * periods / float(np.ptp(q))
    s = smooth_sign(q, v)
    hidden = 5.0 * s * np.sin(w * q + 0.6)
    tau = SLIDER_MASS * a + 20.0 * s + 200.0 * v + hidden
    tau += np.random.default_rng(8).normal(0.0, 1.0, len(t))
    found = diagnose(
        [recording(('slider',), t, q, tau)],
        slider_model(20.0, 200.0),
        settings=DiagnosisSettings(),
    )
    assert found.verdict == 'named'
    (cause,) = found.causes
    assert cause.effect == 'position_dependent_friction'
    # One wave, not several of a grid: its period and size are what was hidden. Intervals of 95 %
    # miss by chance, by 3 / 1.96 of their half only in one of 370.
    size = {'frequency': w, 'cosine': 5.0 * np.sin(0.6), 'sine': 5.0 * np.cos(0.6)}
    for name, true in size.items():
        assert abs(cause.parameters[name].value - true) < 3.0 * cause.parameters[name].std_error
    assert found.gain.inverse_after[0] < 0.3 * found.gain.inverse_before[0]


def test_friction_that_is_tight_in_the_middle_is_the_slowest_wave():
    """A parabola: its wave is at the end of its range, from where it can only be faster."""
    t = np.arange(0.0, 40.0, 4e-3)
    q, v, a = sines(t, ((0.08, 0.9), (0.02, 2.1)))
    s = smooth_sign(q, v)
    middle, half = 0.5 * (q.min() + q.max()), 0.5 * float(np.ptp(q))
    tau = SLIDER_MASS * a + 20.0 * s + 200.0 * v + 3.0 * s * (1.0 - ((q - middle) / half) ** 2)
    tau += np.random.default_rng(8).normal(0.0, 1.0, len(t))
    found = diagnose([recording(('slider',), t, q, tau)], slider_model(20.0, 200.0))
    assert found.verdict == 'named'
    (cause,) = (x for x in found.causes if x.effect == 'position_dependent_friction')
    frequency = cause.parameters['frequency']
    assert frequency.value == pytest.approx(np.pi / float(np.ptp(q)), rel=0.02)
    low, high = frequency.interval
    assert low == 0.0
    assert frequency.value < high < 4.0 * frequency.value


def test_once_per_turn_is_looked_for_over_any_number_of_turns():
    """A shaft that turns for long has no half period of its range that is a turn."""
    signals = SimpleNamespace(
        length_unit=lambda joint: 'rad', scales=SimpleNamespace(span=np.array([80.0]))
    )
    tried = {inner['frequency'] for inner in PositionDependentFriction().grid(signals, 0)}
    assert {1.0, 2.0} <= tried
