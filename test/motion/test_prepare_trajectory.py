# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory is checked as a whole and then followed exactly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.robot import JointLimits
from sosml_friction.motion.trajectory import Trajectory, prepare_trajectory
from sosml_friction.motion.trajectory_follower import TrajectoryFollower

NAMES = ('shoulder', 'elbow')
LIMITS = (JointLimits(-2.3, 0.7, 3.0, 8.0), JointLimits(-0.05, 2.5, 3.0, 5.0))
HERE = np.array([-1.57, 0.0])
TOLERANCE = np.full(2, 0.05)
GOOD = Trajectory(
    NAMES,
    np.array([0.0, 1.0, 2.5]),
    np.array([[-1.57, 0.0], [-1.0, 0.5], [-1.2, 0.2]]),
    np.array([[0.0, 0.0], [0.2, -0.1], [0.0, 0.0]]),
)


def prepare(trajectory):
    return prepare_trajectory(trajectory, NAMES, LIMITS, HERE, TOLERANCE)


def changed(array, index, value):
    result = np.array(array, dtype=float)
    result[index] = value
    return result


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        (dict(names=('shoulder', 'wrist')), 'must name shoulder, elbow'),
        (dict(names=('shoulder', 'shoulder')), 'must name shoulder, elbow'),
        (dict(t=np.zeros(0)), 'no points'),
        (dict(t=np.array([0.0, 1.0, 1.0])), 'point 2 .* let the times increase'),
        (dict(t=np.array([-0.1, 1.0, 2.0])), 'not negative'),
        (dict(t=np.array([0.0, np.nan, 2.0])), 'finite'),
        (dict(q=GOOD.q[:, :1]), 'positions .* shape'),
        (dict(v=GOOD.v[:2]), 'velocities .* shape'),
        (dict(q=changed(GOOD.q, (1, 0), np.nan)), 'point 1 .* finite'),
        (dict(v=changed(GOOD.v, (1, 1), np.inf)), 'point 1 .* finite'),
        (dict(q=changed(GOOD.q, (1, 0), 0.71)), 'outside its limits'),
        (dict(q=changed(GOOD.q, (2, 1), -0.06)), 'outside its limits'),
        (dict(v=changed(GOOD.v, (1, 0), 3.1)), 'make it slower'),
        (dict(v=changed(GOOD.v, (1, 0), 1e308)), 'too large to be followed'),
        (dict(v=changed(GOOD.v, (1, 1), -1e308)), 'too large to be followed'),
        (dict(t=np.array([0.0, 0.1, 1.0])), 'make it slower'),
        (dict(q=changed(GOOD.q, (0, 0), -1.51)), 'start within 0.05'),
        (dict(v=changed(GOOD.v, (2, 1), 0.1)), 'let it end at rest'),
        (
            dict(v=None, t=np.array([0.0, 0.1, 1.0])),
            'moves joint shoulder at 5.7',
        ),
    ],
)
def test_a_trajectory_that_does_not_fit_is_refused_in_one_sentence(changes, sentence):
    with pytest.raises(TrajectoryError, match=sentence) as caught:
        prepare(replace(GOOD, **changes))
    assert '\n' not in str(caught.value)


def test_an_overshoot_between_points_counts():
    """Both points are inside the limits, the cubic between them is not."""
    trajectory = Trajectory(
        NAMES,
        np.array([0.0, 1.0, 2.0]),
        np.array([[-1.57, 0.0], [-1.57, 0.0], [-1.57, 0.0]]),
        np.array([[0.0, 0.0], [0.0, 2.0], [0.0, 0.0]]),
    )
    with pytest.raises(TrajectoryError, match=r'takes joint elbow to -0\.29'):
        prepare(trajectory)


def test_the_extremes_are_those_of_a_fine_sampling():
    rng = np.random.default_rng(0)
    for _ in range(20):
        times = np.cumsum(rng.uniform(0.2, 1.0, 6))
        q, v = rng.standard_normal((6, 2)), rng.standard_normal((6, 2))
        low, high, fastest = Trajectory(NAMES, times, q, v).extremes()
        spline = CubicHermiteSpline(times, q, v)
        fine = np.linspace(times[0], times[-1], 20_001)
        np.testing.assert_allclose(low, spline(fine).min(axis=0), atol=1e-5)
        np.testing.assert_allclose(high, spline(fine).max(axis=0), atol=1e-5)
        np.testing.assert_allclose(fastest, np.abs(spline(fine, 1)).max(axis=0), atol=1e-4)


def test_joints_may_come_in_another_order():
    swapped = Trajectory(NAMES[::-1], GOOD.t, GOOD.q[:, ::-1], GOOD.v[:, ::-1])
    np.testing.assert_array_equal(prepare(swapped).q, GOOD.q)
    np.testing.assert_array_equal(prepare(swapped).v, GOOD.v)


def test_a_first_time_above_zero_means_going_there_from_where_the_joints_are():
    prepared = prepare(
        Trajectory(NAMES, np.array([2.0]), np.array([[-1.0, 0.4]]), np.zeros((1, 2)))
    )
    np.testing.assert_array_equal(prepared.t, [0.0, 2.0])
    np.testing.assert_array_equal(prepared.q[0], HERE)
    np.testing.assert_array_equal(prepared.v[0], 0.0)


def test_the_follower_is_the_cubic_hermite_spline():
    follower = TrajectoryFollower(HERE)
    follower.follow(prepare(GOOD))
    start = 7_000_000_000
    spline = CubicHermiteSpline(GOOD.t, GOOD.q, GOOD.v)
    for t in np.arange(0.0, 2.5, 0.002):
        reference = follower.sample(start + round(t * 1e9))
        np.testing.assert_allclose(reference.q, spline(t), atol=1e-12)
        np.testing.assert_allclose(reference.v, spline(t, 1), atol=1e-12)
        np.testing.assert_allclose(reference.a, spline(t, 2), atol=1e-9)
    assert follower.running
    last = follower.sample(start + 2_500_000_000)
    np.testing.assert_array_equal(last.q, GOOD.q[-1])
    np.testing.assert_array_equal(last.v, 0.0)
    assert not follower.running


def test_without_velocities_the_follower_goes_straight():
    follower = TrajectoryFollower(HERE)
    follower.follow(prepare(replace(GOOD, v=None)))
    follower.sample(0)
    reference = follower.sample(500_000_000)
    np.testing.assert_allclose(reference.q, [-1.285, 0.25])
    np.testing.assert_allclose(reference.v, [0.57, 0.5])


def test_a_single_point_where_the_joints_are_ends_at_once():
    follower = TrajectoryFollower(HERE)
    follower.follow(prepare(Trajectory(NAMES, np.zeros(1), HERE[None, :])))
    np.testing.assert_array_equal(follower.sample(5).q, HERE)
    assert not follower.running


def sampled(follower, seconds):
    """Return reference positions and velocities every 2 ms."""
    references = [follower.sample(round(t * 1e9)) for t in np.arange(0.0, seconds, 0.002)]
    return np.array([r.q for r in references]), np.array([r.v for r in references]), references


def test_the_reference_does_not_jump_onto_a_trajectory_that_starts_beside_it():
    follower = TrajectoryFollower(HERE + np.array([0.04, -0.03]))
    follower.follow(prepare(GOOD))
    q, v, references = sampled(follower, 3.0)
    np.testing.assert_allclose(q[0], HERE + np.array([0.04, -0.03]), atol=1e-12)
    # The velocity is the derivative of the position all along, and so is the acceleration.
    np.testing.assert_allclose(np.diff(q, axis=0) / 0.002, 0.5 * (v[1:] + v[:-1]), atol=2e-3)
    a = np.array([r.a for r in references])
    inner = slice(0, 240)
    np.testing.assert_allclose(
        np.diff(v, axis=0)[inner] / 0.002, 0.5 * (a[1:] + a[:-1])[inner], atol=1e-2
    )
    spline = CubicHermiteSpline(GOOD.t, GOOD.q, GOOD.v)
    np.testing.assert_allclose(
        q[250:1250], spline(np.arange(0.0, 3.0, 0.002)[250:1250]), atol=1e-9
    )


def test_a_trajectory_shorter_than_the_blend_still_ends_where_it_says():
    follower = TrajectoryFollower(HERE + 0.04)
    follower.follow(prepare(Trajectory(NAMES, np.zeros(1), HERE[None, :])))
    q, _, _ = sampled(follower, 0.6)
    np.testing.assert_array_equal(q[-1], HERE)
    assert np.abs(np.diff(q, axis=0)).max() < 0.04 * 1.5 / 0.5 * 0.002 + 1e-9


def test_braking_is_a_parabola_with_the_deceleration_asked_for():
    follower = TrajectoryFollower(HERE)
    v0 = np.array([1.0, -0.4])
    lower, upper = np.full(2, -3.0), np.full(2, 3.0)
    follower.brake(HERE, v0, 5.0, lower, upper)
    assert not follower.running
    np.testing.assert_array_equal(follower.last.q, HERE)
    for t in np.arange(0.0, 0.2, 0.002):
        reference = follower.sample(round(t * 1e9))
        np.testing.assert_allclose(reference.q, HERE + v0 * (t - 2.5 * t * t), atol=1e-9)
        np.testing.assert_allclose(reference.a, -5.0 * v0, atol=1e-9)
    end = follower.sample(300_000_000)
    np.testing.assert_allclose(end.q, HERE + 0.1 * v0, atol=1e-12)
    np.testing.assert_array_equal(end.v, 0.0)


def test_braking_ends_inside_the_limits():
    follower = TrajectoryFollower(HERE)
    q, v = np.array([0.68, 0.0]), np.array([1.0, 0.0])
    lower, upper = (np.array([getattr(x, k) for x in LIMITS]) for k in ('lower', 'upper'))
    follower.brake(q, v, 5.0, lower, upper)
    positions, _, _ = sampled(follower, 0.4)
    assert positions[-1][0] == 0.7


def test_a_trajectory_that_follows_braking_starts_from_where_that_began():
    """No sample may lie between enable and the trajectory: the reference must know its place."""
    follower = TrajectoryFollower(np.zeros(2))
    follower.brake(HERE, np.array([1e-3, 0.0]), 5.0, np.full(2, -3.0), np.full(2, 3.0))
    follower.follow(prepare(GOOD))
    np.testing.assert_allclose(follower.sample(0).q, HERE, atol=1e-12)
