# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is promised of gains, against closed forms of noise and settling."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.log_conditions import LogConditions
from sosml_friction.observers.recipe import gains_for_bandwidth, gains_for_conditions
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.study.expected_performance import expected_performance

STEP, NOISE, INERTIA = 1e-3, 5e-6, 0.4


def expect(gains, span=2, jump=2.0, velocity_noise=0.07, inertia=INERTIA):
    numbers = (np.array([x]) for x in (1.0, jump, 1.0))
    noise = np.array([NOISE]), np.array([velocity_noise])
    measured = LogConditions(('j',), np.zeros(1), STEP, *noise, span, *numbers)
    return expected_performance(gains, np.array([[inertia]]), measured)


def test_noise_and_settling_of_a_first_order_observer_are_its_closed_forms():
    """
    Noise of the integral of p is white; that of p is its difference, of the estimate another.

    The latter by the impulse response of (1 - a) / (1 - a z^-1) twice differenced, over h^2.
    Settling from D to D / 10: ln(10) / c0. Noise to 5 %; the mean error is known to 0.025 D, which
    at the slope c0 D / 10 is 0.25 / c0, 8 ms.
    """
    c0 = 30.0
    found = expect({'first_order': {'cutoff': [c0]}})['first_order']
    a = np.exp(-c0 * STEP)
    impulse = (1.0 - a) * a ** np.arange(4000)
    response = np.convolve(impulse, [1.0, -2.0, 1.0]) / STEP**2
    expected = INERTIA * NOISE * np.sqrt(np.sum(response**2))
    assert found.noise[0] == pytest.approx(expected, rel=0.05)
    assert found.settle_s[0] == pytest.approx(np.log(10.0) / c0, abs=0.016)


def test_noise_of_a_second_order_observer_is_its_bandwidth_squared_times_that_of_x():
    """wn^2 s_X for h wn << 1, here 0.04; to 10 %."""
    wn = 40.0
    gains = {'linear_second_order': {'natural_frequency': [wn], 'damping_ratio': [0.5]}}
    found = expect(gains)['linear_second_order']
    assert found.noise[0] == pytest.approx(wn**2 * INERTIA * NOISE, rel=0.1)


def test_a_velocity_over_more_positions_has_less_noise():
    gains = {'first_order': {'cutoff': [100.0]}}
    two, eleven = (expect(gains, span)['first_order'] for span in (2, 11))
    assert eleven.noise[0] < 0.3 * two.noise[0]


def test_a_velocity_of_its_own_brings_its_own_noise():
    """White p of standard deviation s: (1 - a) / h sqrt(2 / (1 + a)) s, here c0 s to 2 %."""
    found = expect({'first_order': {'cutoff': [30.0]}}, span=0, velocity_noise=2e-3)
    assert found['first_order'].noise[0] == pytest.approx(30.0 * INERTIA * 2e-3, rel=0.05)


def test_faster_gains_settle_sooner_and_are_noisier():
    slow, fast = (expect(gains_for_bandwidth(w, [0.0])) for w in (20.0, 60.0))
    for name in slow:
        if name == 'quasi_static':
            continue
        assert fast[name].noise[0] > slow[name].noise[0], name
        assert fast[name].settle_s[0] < slow[name].settle_s[0], name


def test_settling_that_noise_hides_is_not_told():
    assert np.isnan(expect({'first_order': {'cutoff': [5e4]}})['first_order'].settle_s[0])


def test_an_observer_that_is_too_slow_does_not_settle():
    found = expect({'first_order': {'cutoff': [0.5]}})['first_order']
    assert np.isnan(found.settle_s[0])


def test_every_observer_can_be_asked(study_arm):
    q = np.zeros(2)
    noise, jump, time, speed = [5e-5] * 2, [2.0, 1.0], [0.4, 0.6], [1.0, 0.5]
    conditions = Conditions.of(study_arm, q, noise, [0.07] * 2, jump, time, speed)
    numbers = (np.array(x) for x in (speed, jump, time))
    measured = LogConditions(
        study_arm.names, q, STEP, np.array(noise), np.array([0.07] * 2), 2, *numbers
    )
    found = expected_performance(gains_for_conditions(conditions), study_arm.inertia(q), measured)
    assert set(found) == set(OBSERVERS)
    for name, expectation in found.items():
        assert (expectation.noise > 0.0).all() or name == 'quasi_static'
        assert (expectation.settle_s >= 0.0).all() or name == 'quasi_static'
