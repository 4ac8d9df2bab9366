# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories of identification: smooth, at rest at both ends, inside the limits."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.robot import Robot
from sosml_friction.motion.building_blocks import TrajectoryBuilder, check_limits
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder

REPOSITORY = Path(__file__).resolve().parents[2]
SPEEDS = (0.05, 0.1, 0.3)
START = {'shoulder': -1.5, 'elbow': 0.2}
CENTRE = {'shoulder': -1.3, 'elbow': 0.6}


@pytest.fixture(scope='module')
def ladder():
    return speed_ladder(START, CENTRE, SPEEDS, plateau_s=0.8, ramp_s=0.3, top_speed=0.5)


@pytest.fixture(scope='module')
def robot():
    urdf = (REPOSITORY / 'urdf/exoskeleton.urdf').read_text(encoding='utf-8')
    return Robot(urdf, ('shoulder', 'elbow'), (0.0054, 0.004))


def test_the_ladder_goes_from_start_to_centre_at_rest_at_both_ends(ladder):
    assert ladder.names == ('shoulder', 'elbow')
    np.testing.assert_array_equal(ladder.q[0], [-1.5, 0.2])
    np.testing.assert_allclose(ladder.q[-1], [-1.3, 0.6], atol=1e-12)
    np.testing.assert_array_equal(ladder.v[[0, -1]], np.zeros((2, 2)))
    assert ladder.t[0] == 0.0


def test_each_speed_lasts_its_plateau_both_ways_on_the_way_up_and_down(ladder):
    """Knots at exactly the plateau's speed: 80 steps of 10 ms, in order, for both joints."""
    runs = []
    at = 0
    while at < len(ladder.t):
        end = at
        while end < len(ladder.t) and np.array_equal(ladder.v[end], ladder.v[at]):
            end += 1
        if ladder.t[end - 1] - ladder.t[at] > 0.7 and ladder.v[at, 0] != 0.0:
            runs.append((ladder.v[at], ladder.t[end - 1] - ladder.t[at]))
        at = end
    expected = [s * x for x in (*SPEEDS, *SPEEDS[::-1]) for s in (1, -1)]
    np.testing.assert_allclose([v[0] for v, _ in runs], expected, rtol=1e-12)
    np.testing.assert_allclose([v[1] for v, _ in runs], expected, rtol=1e-12)
    # The knots next to a plateau belong to the ramps.
    np.testing.assert_allclose([length for _, length in runs], 0.8, atol=1e-9)


def test_the_middle_of_every_plateau_is_the_centre_in_both_directions(ladder):
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, 0.002)
    v = spline(t, 1)[:, 0]
    q = spline(t)[:, 0]
    for speed in SPEEDS:
        for way in (1.0, -1.0):
            on = np.abs(v - way * speed) < 1e-9
            begins = np.flatnonzero(on & ~np.roll(on, 1))
            ends = np.flatnonzero(on & ~np.roll(on, -1))
            long = ends - begins > 300
            middle = 0.5 * (q[begins] + q[ends])[long]
            assert len(middle) == 2
            np.testing.assert_allclose(middle, -1.3, atol=2e-3 * speed + 1e-9)


def test_position_velocity_and_acceleration_have_no_jumps(ladder):
    """
    Between samples of 1 ms velocity moves by at most the largest acceleration times 1 ms.

    Ramp: 15/8 of 0.3 / 0.3; move: 10 / sqrt(3) way / T^2, less than 5. The spline's own
    acceleration breaks by the error of its third derivative, a few percent of the largest.
    """
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, 1e-3)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    assert np.abs(a).max() < 5.0
    assert np.abs(np.diff(v, axis=0)).max() <= 1.01e-3 * np.abs(a).max()
    assert np.abs(np.diff(a, axis=0)).max() < 0.1 * np.abs(a).max()
    # The trapezoidal rule leaves h^3 / 12 of a jerk that stays below 200.
    np.testing.assert_allclose(np.diff(q, axis=0), 5e-4 * (v[1:] + v[:-1]), atol=1.7e-8)
    assert np.abs(v).max() <= 0.5 + 1e-9
    np.testing.assert_allclose(a[[0, -1]], 0.0, atol=0.05)


def test_the_ladder_lasts_about_what_its_docstring_says(ladder):
    assert ladder.duration == pytest.approx(3 * 2 * (1.6 + 1.2 + 0.5), rel=0.25)


def test_a_ramp_covers_its_mean_velocity_and_peaks_at_15_8_of_the_mean_acceleration():
    built = TrajectoryBuilder(('a',), np.zeros(1), dt=1e-3).ramp(np.ones(1), 0.4).build()
    assert built.q[-1, 0] == pytest.approx(0.5 * 0.4, rel=1e-12)
    acceleration = np.gradient(built.v[:, 0], built.t)
    assert acceleration.max() == pytest.approx(15.0 / 8.0 / 0.4, rel=1e-3)
    np.testing.assert_allclose(acceleration[[0, -1]], 0.0, atol=0.01)


def test_a_move_keeps_its_top_speed_and_ends_at_rest():
    built = (
        TrajectoryBuilder(('a', 'b'), np.zeros(2))
        .move(np.array([1.0, -0.2]), top_speed=0.5)
        .build()
    )
    assert np.abs(built.spline()(np.linspace(0, built.duration, 999), 1)).max() <= 0.5 + 1e-9
    assert built.duration == pytest.approx(15.0 / 8.0 / 0.5)
    np.testing.assert_allclose(built.q[-1], [1.0, -0.2], atol=1e-15)
    np.testing.assert_allclose(built.v[-1], 0.0, atol=1e-15)


def test_what_cannot_be_planned_is_refused():
    with pytest.raises(TrajectoryError, match='ramp to rest first'):
        TrajectoryBuilder(('a',), np.zeros(1)).ramp(np.ones(1), 0.1).move(np.ones(1), 1.0)
    with pytest.raises(TrajectoryError, match=r'lasts 0\.0 s'):
        TrajectoryBuilder(('a',), np.zeros(1)).hold(0.0)
    with pytest.raises(TrajectoryError, match='name the same joints'):
        speed_ladder(START, {'shoulder': 0.0}, SPEEDS)
    with pytest.raises(TrajectoryError, match=r'lasts 0\.0 s'):
        speed_ladder(START, CENTRE, SPEEDS, ramp_s=0.0)


def test_a_trajectory_inside_the_limits_passes(ladder, robot):
    check_limits(ladder, robot)


@pytest.mark.parametrize(
    ('centre', 'speeds', 'margin', 'words'),
    [
        ({'shoulder': -2.4, 'elbow': 1.0}, SPEEDS, 1.0, 'joint shoulder to a position of -2'),
        ({'shoulder': -0.9, 'elbow': 2.6}, SPEEDS, 1.0, 'joint elbow to a position of 2'),
        (CENTRE, (3.1,), 1.0, 'joint shoulder to a (position|speed) of'),
        ({'shoulder': 0.0, 'elbow': 0.3}, SPEEDS, 0.5, 'joint shoulder to a rigid-body effort'),
    ],
)
def test_a_trajectory_beyond_a_limit_is_refused_with_joint_value_and_time(
    robot, centre, speeds, margin, words
):
    trajectory = speed_ladder(START, centre, speeds, top_speed=1.0)
    with pytest.raises(TrajectoryError, match=words + r'.* at \d+\.\d\d s, .* beyond') as caught:
        check_limits(trajectory, robot, margin)
    assert '\n' not in str(caught.value)


def test_too_fast_is_refused_as_too_fast():
    t = np.array([0.0, 0.1, 0.2])
    q = np.array([[-1.0, 1.0], [-0.7, 1.0], [-1.0, 1.0]])
    fast = Trajectory(('shoulder', 'elbow'), t, q, np.zeros((3, 2)))
    urdf = (REPOSITORY / 'urdf/exoskeleton.urdf').read_text(encoding='utf-8')
    strong = Robot(urdf.replace('effort="', 'effort="99999'), ('shoulder', 'elbow'), (0.0, 0.0))
    with pytest.raises(TrajectoryError, match=r'joint shoulder to a speed of -?4\.5 '):
        check_limits(fast, strong)


def test_the_last_instant_is_checked_as_well(robot):
    t = np.array([0.0, 1.005])
    q = np.array([[-1.0, 2.0], [-1.0, 2.5001]])
    late = Trajectory(('shoulder', 'elbow'), t, q, np.zeros((2, 2)))
    with pytest.raises(TrajectoryError, match=r'joint elbow to a position of 2\.5 at 1\.00 s'):
        check_limits(late, robot)


def test_a_joint_that_the_trajectory_lacks_is_named(robot):
    lacking = speed_ladder({'shoulder': 0.0}, {'shoulder': 0.0}, SPEEDS)
    with pytest.raises(TrajectoryError, match='does not move joint elbow'):
        check_limits(lacking, robot)


@pytest.mark.parametrize('limit', ['velocity', 'effort'])
def test_a_limit_that_the_urdf_does_not_state_is_asked_for(limit):
    urdf = (REPOSITORY / 'urdf/exoskeleton.urdf').read_text(encoding='utf-8')
    robot = Robot(re.sub(f'{limit}="[^"]*"', '', urdf), ('shoulder', 'elbow'), (0.0, 0.0))
    rest = Trajectory(('shoulder', 'elbow'), np.array([0.0, 1.0]), np.zeros((2, 2)), None)
    with pytest.raises(TrajectoryError, match=f'joint shoulder no {limit} limit'):
        check_limits(rest, robot)
