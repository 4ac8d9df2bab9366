# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Gains by recipe: their formulas, that they are the optimum they claim, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.recipe import (
    gains_for_bandwidth,
    gains_for_conditions,
    recipe_gains,
)
from sosml_friction.observers.registry import OBSERVERS, make_observer

STATED = ('position_noise', 'velocity_noise', 'friction_jump', 'reversal_time')


def conditions(**changes):
    """Return one joint of inertia 0.37 kg m2 with the study's encoder and reversals."""
    values = {
        'position_noise': [5.5e-5],
        'momentum_noise': [0.029],
        'integral_noise': [2.0e-5],
        'friction_jump': [2.2],
        'reversal_time': [1.0],
        'top_speed': [1.1],
        **changes,
    }
    return Conditions(('joint',), **{k: np.array(v, dtype=float) for k, v in values.items()})


def test_the_recipe_is_its_formula():
    """c0 = w; S2 = w^2, T2 = w (zeta 0.5); S1 = 0.1 S2 s_p; T1 = 1.6 sqrt(S1)."""
    gains = gains_for_bandwidth(40.0, [0.01, 0.0])
    assert gains['first_order'] == {'cutoff': [40.0, 40.0]}
    assert gains['sosml']['linear'] == [1600.0, 1600.0]
    assert gains['sosml']['linear_damping'] == [40.0, 40.0]
    assert gains['sosml']['sliding'] == pytest.approx([1.6, 0.0])
    assert gains['sosml']['sliding_root'] == pytest.approx([1.6 * 1.6**0.5, 0.0])
    for name, values in gains.items():
        assert make_observer(name, values).n == 2


@pytest.mark.parametrize(
    ('bandwidth', 'noise'),
    [(x, [0.1]) for x in (0.0, -1.0, np.nan, np.inf)]
    + [(40.0, [x]) for x in (-1.0, np.nan, np.inf)],
)
def test_a_recipe_from_numbers_out_of_range_is_refused(bandwidth, noise):
    with pytest.raises(ConfigurationError, match='must be positive'):
        gains_for_bandwidth(bandwidth, noise)


def test_every_observer_has_a_recipe_and_its_gains_are_taken():
    recipe = gains_for_conditions(conditions())
    assert set(recipe) == set(OBSERVERS)
    for name, gains in recipe.items():
        assert make_observer(name, gains).n == 1


def test_observers_of_one_bandwidth_have_one_delay():
    """The delay of a slow disturbance is -d(phase)/d(omega) at 0, that is 1/w for each of them."""
    h, w = 1e-4, 40.0
    for name, gains in gains_for_bandwidth(w, [0.0]).items():
        b, a = make_observer(name, gains).lag_filter(h, 0)
        ramp = lfilter(b, a, np.arange(20_000) * h)
        # The first-order hold of the samples is good for half an interval.
        assert 19_999 * h - ramp[-1] == pytest.approx(1.0 / w, abs=1.01 * h), name


def mean_square(name, gains, c, h=1e-3):
    """Return noise^2 + D^2 (mean square error of the step response) by the observer's filter."""
    observer = make_observer(name, gains)
    b, a = observer.lag_filter(h, 0)
    n = round(float(c.reversal_time[0]) / h)
    step = 1.0 - lfilter(b, a, np.ones(n))
    # Noise of the integral of p reaches the estimate through b/a and two differences over h^2;
    # in an observer of differences it is white noise of X, differenced twice.
    impulse = np.zeros(n)
    impulse[0] = 1.0
    response = np.diff(lfilter(b, a, impulse), n=2, prepend=[0.0, 0.0]) / h**2
    noise = float(c.integral_noise[0]) ** 2 * np.sum(response**2)
    return noise + float(c.friction_jump[0]) ** 2 * np.sum(step**2) * h / float(c.reversal_time[0])


@pytest.mark.parametrize(
    ('name', 'scaled'),
    [
        ('first_order', ['cutoff']),
        ('linear_second_order', ['natural_frequency']),
        ('first_order_prefiltered', ['cutoff', 'prefilter_cutoff']),
    ],
)
def test_a_recipe_is_the_minimum_of_what_it_minimises(name, scaled):
    """
    Over the bandwidth, with the observer's exact filter instead of the recipe's integrals.

    The recipe leaves out h w, here up to 0.1, and the tail after T: the mean square at its gain is
    within 7 % of the best. The noise of p is that of a backward difference, sqrt(2) s_X / h.
    """
    c = conditions(momentum_noise=[np.sqrt(2.0) * 2.0e-5 / 1e-3])
    gains = gains_for_conditions(c)[name]

    def cost(log_factor):
        factor = np.exp(log_factor)
        changed = {k: [factor * x for x in v] if k in scaled else v for k, v in gains.items()}
        return np.log(mean_square(name, changed, c))

    best = minimize_scalar(cost, bounds=(-2.0, 2.0), method='bounded')
    assert cost(0.0) - best.fun < 0.07
    assert abs(best.x) < 1.0


def test_what_is_not_positive_is_refused_by_name():
    for name in ('position_noise', 'integral_noise', 'friction_jump', 'reversal_time'):
        for value in ([0.0], [-1.0], [np.nan], [np.inf], [1.0, 1.0]):
            with pytest.raises(ConfigurationError, match=f'^{name} is .* for the joints joint'):
                conditions(**{name: value})


def test_noise_of_all_joints_enters_the_momentum_of_each(two_joints):
    q, sigma = np.array([0.3, 1.0]), np.array([1e-4, 3e-4])
    c = Conditions.of(two_joints, q, sigma, 10.0 * sigma, [2.0, 1.0], [1.0, 2.0])
    noise = np.random.default_rng(0).normal(size=(200_000, 2)) * sigma
    # 200 000 samples: standard deviation to 0.16 %, four of them.
    expected = (noise @ two_joints.inertia(q)).std(axis=0)
    np.testing.assert_allclose(c.integral_noise, expected, rtol=0.007)
    np.testing.assert_allclose(c.momentum_noise, 10.0 * c.integral_noise, rtol=1e-12)


def test_a_robot_gets_gains_by_bandwidth_until_its_friction_is_stated(two_joints):
    by_bandwidth = recipe_gains(two_joints, 30.0)
    assert by_bandwidth['first_order']['cutoff'] == [30.0, 30.0]
    assert by_bandwidth['sosml']['sliding'] == [0.0, 0.0]
    assert 'kalman' not in by_bandwidth
    sliding = recipe_gains(two_joints, 30.0, velocity_noise=[1e-3, 2e-3])['sosml']['sliding']
    noise = np.sqrt(two_joints.inertia(np.zeros(2)) ** 2 @ np.array([1e-3, 2e-3]) ** 2)
    np.testing.assert_allclose(sliding, 0.1 * 900.0 * noise, rtol=1e-12)
    stated = {'friction_jump': [2.0, 1.0], 'reversal_time': [1.0, 1.0]}
    noises = {'position_noise': [5e-5] * 2, 'velocity_noise': [2e-3] * 2}
    full = recipe_gains(two_joints, 30.0, **stated, **noises)
    assert full['kalman']['disturbance_rate'] == [2.0, 1.0]


@pytest.mark.parametrize('missing', STATED[:2] + STATED[3:])
def test_friction_without_the_rest_is_refused_by_the_name_of_what_is_missing(two_joints, missing):
    values = {name: [1e-3, 1e-3] for name in STATED if name != missing}
    with pytest.raises(ConfigurationError, match=f'^{missing} is'):
        recipe_gains(two_joints, 40.0, **values)


def test_velocity_noise_of_another_robot_is_refused(two_joints):
    with pytest.raises(ConfigurationError, match='velocity_noise has 1 values for the 2 joints'):
        recipe_gains(two_joints, 40.0, velocity_noise=[1e-3])
