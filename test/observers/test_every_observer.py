# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What holds for every observer of the registry, on two joints and on seven."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers import kinds
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.recipe import gains_for_conditions, recipe_gains
from sosml_friction.observers.registry import OBSERVERS, make_observer, refuse_offline
from sosml_friction.report.common.labels import observer_label

ENCODER_NOISE = 5e-5
H_NS = 1_000_000


def make(name: str, n: int, effort_unit: float = 1.0):
    """
    Return an observer of n equal joints; gains in Nm scaled to a unit that many times less.

    Gains by recipe for a friction of 1 Nm either way: it settles within a second.
    """
    stated = (ENCODER_NOISE, 0.004, 1e-4, 2.0, 1.0, 1.0)
    conditions = Conditions(tuple(f'j{i}' for i in range(n)), *(np.full(n, x) for x in stated))
    gains = {}
    for gain, values in gains_for_conditions(conditions)[name].items():
        scale = effort_unit ** effort_power(OBSERVERS[name].gain_units[gain])
        gains[gain] = [value * scale for value in values]
    return make_observer(name, gains)


def steady_error(name: str) -> float:
    """Return the relative error of a constant friction that may remain."""
    # Prior knowledge: a friction that does not follow its law is believed but slowly.
    return 0.03 if OBSERVERS[name].carries_law else 1e-3


def pace(name: str) -> float:
    """Return how fast the motion is in which an observer is to find a constant friction."""
    return 0.01 if OBSERVERS[name].slow_motion_only else 1.0


def effort_power(unit: str) -> float:
    """Return the power of Nm in a unit such as Nm/s, sqrt(Nm/s), Nm^2/s or rad/Nm."""
    match = re.search(r'(sqrt\(|/\s*)?Nm(?:\^(\d))?', unit)
    if match is None:
        return 0.0
    power = float(match[2] or 1)
    return {'sqrt(': 0.5 * power, None: power}.get(match[1], -power)


def test_the_power_of_effort_in_a_unit_is_read_right():
    units = {
        'Nm': 1.0,
        'Nm/sqrt(s)': 1.0,
        'sqrt(Nm/s)': 0.5,
        'Nm^2/s': 2.0,
        'rad/Nm': -1.0,
        '1/s^2': 0.0,
        'rad': 0.0,
        'Nm s/rad': 1.0,
    }
    assert {unit: effort_power(unit) for unit in units} == units


@pytest.fixture(params=['two_joints', 'seven_joints'])
def robot(request) -> Robot:
    return request.getfixturevalue(request.param)


def recording(
    robot: Robot, count: int, friction: np.ndarray, seed: int = -1, pace: float = 1.0
) -> JointLog:
    """
    Return a motion of all joints at 1 kHz that never reverses, under constant friction.

    The effort is the mean over the interval that ends at its sample, to second order. A seed >= 0
    gives encoder noise and differenced velocity.
    """
    rng = np.random.default_rng(5)
    t = np.arange(count)[:, None] * 1e-3
    start, phase = rng.uniform(-1.0, 1.0, size=(2, robot.n))
    drift = pace * rng.uniform(0.1, 0.2, size=robot.n)
    rate = pace * rng.uniform(2.0, 4.0, size=robot.n)
    swing = 0.5 * drift / rate
    q = start + drift * t + swing * np.sin(rate * t + phase)
    v = drift + swing * rate * np.cos(rate * t + phase)
    a = -swing * rate**2 * np.sin(rate * t + phase)
    rows = zip(q, v, a, strict=True)
    tau = np.array([robot.inverse_dynamics(*row) for row in rows]) + friction
    if seed >= 0:
        q = q + ENCODER_NOISE * np.random.default_rng(seed).normal(size=q.shape)
        v[1:] = np.diff(q, axis=0) / 1e-3
    return JointLog(robot.names, np.arange(count, dtype=np.int64) * H_NS, q, v, tau)


def batch(robot: Robot, name: str, log: JointLog) -> np.ndarray:
    return FrictionEstimator(robot, [make(name, robot.n)], 'mean').batch(log)[name]


every = pytest.mark.parametrize('name', OBSERVERS)


@every
def test_a_constant_friction_is_found_without_error(robot, name):
    """
    The last 200 ms of 2.5 s. Nothing is held but the friction: all joints move and accelerate.

    What may remain is of the sampling: the effort is sampled where the equations want its mean,
    which is h^2 / 12 of its second derivative, 1e-6 Nm.
    """
    friction = np.linspace(0.8, 1.2, robot.n)
    tau_f = batch(robot, name, recording(robot, 2500, friction, pace=pace(name)))
    error = np.abs(tau_f[-200:] - friction) / friction
    assert error.max() < steady_error(name)


@every
def test_a_disturbance_against_no_motion_is_found_without_error(drive, name):
    """A joint at constant velocity whose effort is all friction."""
    estimate = drive(make(name, 1), np.full(4000, 0.2), np.full(4000, -0.7), 1e-3)
    np.testing.assert_allclose(estimate[-200:], 0.7, rtol=steady_error(name))


@pytest.mark.parametrize('name', [name for name in OBSERVERS if OBSERVERS[name].causal])
def test_batch_is_the_steps_to_the_last_bit(robot, name):
    """With a missing effort, a gap, a repeated stamp and a missing position on the way."""
    log = recording(robot, 160, np.full(robot.n, 1.0), seed=1)
    log.tau[30:33, 0] = np.nan
    log.t_ns[70:] += 200_000_000
    log.t_ns[100:] -= H_NS
    log.q[130] = np.nan
    whole = batch(robot, name, log)
    live = FrictionEstimator(robot, [make(name, robot.n)], 'mean')
    for k in range(len(log)):
        step = live.update(int(log.t_ns[k]), log.q[k], log.v[k], log.tau[k])
        if step is None:
            assert np.isnan(whole[k]).all()
        else:
            np.testing.assert_array_equal(step[name], whole[k])
    assert np.isfinite(whole[10:30]).all()


@every
def test_another_unit_of_effort_changes_nothing(robot, name):
    """
    Efforts in a unit 1024 times smaller, gains by their units: the estimate by 1024.

    1024 and its root are powers of two, so this is so to the last bit.
    """
    log = recording(robot, 300, np.full(robot.n, 1.0), seed=2)
    estimator = FrictionEstimator(robot, [make(name, robot.n)], 'mean')
    (stretch,) = estimator.stretches(log)
    s, k = stretch.samples, 1024.0
    scaled = MomentumSamples(s.h, k * s.p, k * s.integral, k * s.forcing, k * s.inertia)
    one, other = make(name, robot.n), make(name, robot.n, k)
    one.start(stretch.p_start)
    other.start(k * stretch.p_start)
    np.testing.assert_array_equal(other.run(scaled), k * one.run(s))


@every
def test_a_missing_effort_concerns_its_joint_only_and_heals(robot, name):
    """
    NaN over the intervals without effort, finite after; the other joints go on.

    To the last bit, or, where they are coupled, within a tenth of the friction.
    """
    log = recording(robot, 1200, np.full(robot.n, 1.0), pace=pace(name))
    plain = batch(robot, name, log)
    tau = log.tau.copy()
    tau[500:503, 0] = np.nan
    hole = batch(robot, name, replace(log, tau=tau))
    # Mean of two efforts: the interval after the last missing one lacks it too.
    assert np.flatnonzero(np.isnan(hole[:, 0])).tolist() == [0, 500, 501, 502, 503]
    if OBSERVERS[name].coupled:
        np.testing.assert_allclose(hole[100:, 1:], plain[100:, 1:], atol=0.1)
    else:
        np.testing.assert_array_equal(hole[:, 1:], plain[:, 1:])
        np.testing.assert_array_equal(hole[:500, 0], plain[:500, 0])
    np.testing.assert_allclose(hole[-50:, 0], 1.0, atol=10.0 * steady_error(name))


@every
def test_a_joint_that_never_has_effort_leaves_the_others_their_estimates(robot, name):
    log = recording(robot, 1200, np.full(robot.n, 1.0), pace=pace(name))
    plain = batch(robot, name, log)
    tau = log.tau.copy()
    tau[:, -1] = np.nan
    without = batch(robot, name, replace(log, tau=tau))
    assert np.isnan(without[:, -1]).all()
    tolerance = 0.1 if OBSERVERS[name].coupled else 0.0
    np.testing.assert_allclose(without[300:, :-1], plain[300:, :-1], rtol=0.0, atol=tolerance)


@every
def test_after_a_long_gap_it_starts_afresh(robot, name):
    """What follows the gap is the estimate of that part alone."""
    log = recording(robot, 240, np.full(robot.n, 1.0), seed=3)
    log.t_ns[120:] += 10_000_000_000
    whole = batch(robot, name, log)
    assert np.isnan(whole[[0, 120]]).all()
    for part in (slice(120), slice(120, None)):
        alone = JointLog(log.names, log.t_ns[part], log.q[part], log.v[part], log.tau[part])
        np.testing.assert_array_equal(whole[part], batch(robot, name, alone))


@every
def test_its_lag_filter_is_stable_with_gain_one_at_rest(robot, name):
    observer = make(name, robot.n)
    for joint in (0, robot.n - 1):
        b, a = observer.lag_filter(1e-3, joint)
        assert b.sum() == pytest.approx(a.sum(), rel=1e-6)
        assert np.abs(np.roots(a)).max(initial=0.0) < 1.0 or b.tolist() == a.tolist()


@every
def test_an_empty_run_gives_no_estimates(name):
    observer = make(name, 2)
    observer.start(np.zeros(2))
    nothing = MomentumSamples(
        np.empty(0), *(np.empty((0, 2)) for _ in range(3)), np.empty((0, 2, 2))
    )
    assert observer.run(nothing).shape == (0, 2)


@every
@pytest.mark.parametrize(('momentum', 'forcing'), [(1e200, -0.7), (0.2, 1e300), (1e308, 1e308)])
def test_signals_beyond_all_bounds_are_survived(drive, name, momentum, forcing):
    """One sample of one joint: no infinity, no exception, and the other joint goes on."""
    p, u = np.full((400, 2), 0.2), np.full((400, 2), -0.7)
    plain = drive(make(name, 2), p, u, 1e-3)
    p[150, 0], u[150, 0] = momentum, forcing
    estimate = drive(make(name, 2), p, u, 1e-3)
    assert not np.isinf(estimate).any()
    assert np.isfinite(estimate[:, 1]).all()
    if not OBSERVERS[name].coupled:
        np.testing.assert_array_equal(estimate[:, 1], plain[:, 1])


@every
def test_it_says_what_it_is(name):
    """Label, place, gains with units, and a search of each gain that is not told or fixed."""
    observer = OBSERVERS[name]
    assert observer.identifier == name
    assert observer_label(name) == observer.label
    assert [other.label for other in OBSERVERS.values()].count(observer.label) == 1
    assert all(observer.gain_units.values())
    assert set(observer.positive_gains) <= set(observer.gain_units)
    assert observer.study
    for variant, space in observer.study.items():
        assert observer_label(variant) == (space.label or observer.label)
        searched = {*space.ranges, *space.fixed}
        assert searched | {'position_noise'} >= set(observer.gain_units) >= searched
        assert space.sweep[0] in space.ranges


@every
def test_its_recipes_are_gains_that_it_takes(name, two_joints):
    """From conditions always; from a bandwidth only where it has one. Each gain has its unit."""
    stated = {'friction_jump': [2.0, 1.0], 'reversal_time': [1.0, 2.0]}
    noise = {'position_noise': [5e-5, 5e-5], 'velocity_noise': [1e-3, 2e-3]}
    full = recipe_gains(two_joints, 40.0, **stated, **noise)
    assert make_observer(name, full[name]).n == 2
    by_bandwidth = recipe_gains(two_joints, 40.0)
    if name in by_bandwidth:
        assert make_observer(name, by_bandwidth[name]).n == 2
    k = 1024.0
    friction = {**stated, 'friction_jump': [k * x for x in stated['friction_jump']]}
    heavy = Conditions.of(two_joints, np.zeros(2), **noise, **friction)
    heavy = replace(
        heavy, momentum_noise=k * heavy.momentum_noise, integral_noise=k * heavy.integral_noise
    )
    for gain, values in gains_for_conditions(heavy)[name].items():
        power = effort_power(OBSERVERS[name].gain_units[gain])
        np.testing.assert_allclose(values, np.array(full[name][gain]) * k**power, rtol=1e-12)


def test_the_folder_names_them_without_loading_them():
    """A file is called as its observer, so that ``--help`` can name it."""
    assert set(kinds.NAMES) == set(OBSERVERS)


def test_an_observer_that_needs_the_whole_recording_is_refused_on_line():
    refuse_offline([name for name in OBSERVERS if OBSERVERS[name].causal])
    with pytest.raises(ConfigurationError, match='smoother needs the whole recording') as caught:
        refuse_offline(['sosml', 'smoother'])
    assert '\n' not in str(caught.value)
