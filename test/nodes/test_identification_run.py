# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How far a run is, and whether the robot follows."""

from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('rclpy')

from sensor_msgs.msg import JointState

from sosml_friction.model.robot import JointLimits
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.nodes.identification_run import IdentificationRun


def a_run(tmp_path, way, heard_s=0.0):
    """Return a run whose elbow goes evenly a ``way`` in 10 s, sent at 0 and heard at a time."""
    q = np.array([[0.0], [way]])
    trajectory = Trajectory(('elbow',), np.array([0.0, 10.0]), q, np.full((2, 1), way / 10.0))
    run = IdentificationRun(tmp_path, trajectory, recorder=None, reset=None)
    run.heard_ns, run.is_heard = round(heard_s * 1e9), True
    return run


def at(t, position):
    state = JointState(name=['elbow'], position=[position])
    state.header.stamp.sec, state.header.stamp.nanosec = divmod(round(t * 1e9), 10**9)
    return state


@pytest.mark.parametrize('upper', [0.62, 10.0])
@pytest.mark.parametrize('speed', [-0.4, 0.4, None])
def test_a_run_is_braked_from_where_it_is_as_fast_as_it_accelerates(tmp_path, speed, upper):
    """To and fro by 0.5 rad with at most 2 rad/s2."""
    t = np.linspace(0.0, 10.0, 101)
    q, v = 0.5 * np.sin(2.0 * t)[:, None], np.cos(2.0 * t)[:, None]
    run = a_run(tmp_path, 0.0)
    run.trajectory = Trajectory(('elbow',), t, q, v)
    state = at(1.0, 0.6)
    state.velocity = [] if speed is None else [speed]
    now = np.cos(2.0) if speed is None else speed
    limits = JointLimits(-2.0, upper, 1.0, 1.0)
    brake = run.brake(state, SimpleNamespace(names=('elbow',), limits=(limits,)))
    spline = brake.spline()
    assert (spline(0.0), spline(0.0, 1)) == (pytest.approx(0.6), pytest.approx(now))
    assert brake.duration == pytest.approx(abs(now) / 2.0, rel=0.05)
    assert spline(brake.duration, 1) == pytest.approx(0.0, abs=1e-12)
    # Evenly, unless a limit is nearer.
    assert spline(brake.duration) == pytest.approx(min(0.6 + now * brake.duration / 2.0, upper))


def test_a_joint_is_off_its_way_for_a_second_of_samples_and_not_of_a_machine_that_stands_still(
    tmp_path,
):
    """The last sample before a stop stays the last, for however long; it says nothing new."""
    run = a_run(tmp_path, way=0.0)
    looks = [(1.0, 0.5), *[(1.1, 0.5)] * 50, (2.0, 0.1), (2.1, 0.5), (3.0, 0.5)]
    assert not any(run.off_track(at(t, position), 0.2) for t, position in looks)
    assert run.off_track(at(3.2, 0.5), 0.2) == ('elbow', 0.5)


@pytest.mark.parametrize('begun', [0.0, 1.5, 3.0])
def test_a_motion_may_have_begun_whenever_the_trajectory_can_have_arrived(tmp_path, begun):
    """A way of 10 rad at 1 rad/s, sent at 0 s, heard by 3 s; within .02 rad of it."""
    run = a_run(tmp_path, way=10.0, heard_s=3.0)
    for t in np.arange(3.0, 14.0, 0.1):
        assert run.off_track(at(t, np.clip(t - begun, 0.0, 10.0)), 0.02) is None
    assert run.end_ns == 13_500_000_000


@pytest.mark.parametrize('heard', [0.0, 1.5, 2.9])
def test_a_joint_that_never_moves_is_off_its_way_however_late_the_trajectory_came(tmp_path, heard):
    """To and fro by 0.5 rad in 4 s: where it stands, some beginning is at any time."""
    run = a_run(tmp_path, way=0.0, heard_s=heard)
    t = np.linspace(0.0, 30.0, 301)
    q = 0.5 * np.sin(2.0 * np.pi * t / 4.0)[:, None]
    run.trajectory = Trajectory(('elbow',), t, q, np.gradient(q, t, axis=0))
    found = [run.off_track(at(x, 0.0), 0.2) for x in np.arange(heard, heard + 6.0, 0.05)]
    assert found[0] is None
    assert found[-1][0] == 'elbow'


@pytest.mark.parametrize(
    ('t', 'now', 'has_it', 'heard', 'is_heard'),
    [
        (0.5, 0.5, True, 0.5, True),
        (0.5, 0.9, True, 0.9, True),
        (0.5, 1e9, True, 0.5, True),
        (9.0, 9.0, False, 9.0, False),
        (10.5, 10.5, False, 10.5, True),
    ],
    ids=['taken', 'late machine', 'another clock', 'not yet', 'somebody else is stuck'],
)
def test_a_run_counts_from_when_the_driver_has_the_trajectory(
    tmp_path, t, now, has_it, heard, is_heard
):
    run = a_run(tmp_path, way=1.0)
    run.hear(round(t * 1e9), round(now * 1e9), has_it)
    assert run.heard_ns == round(heard * 1e9)
    assert run.is_heard == is_heard


def test_progress_never_goes_back_while_the_driver_is_waited_for(tmp_path):
    """A sample 0.6 s after the one at which the trajectory was sent tells nothing yet."""
    run = a_run(tmp_path, way=1.0)
    run.is_heard = False
    told = [run.progress(600_000_000)]
    for t, has_it in [(0.7, False), (0.8, False), (0.9, True)]:
        run.hear(round(t * 1e9), round(t * 1e9), has_it)
        told.append(run.progress(round(t * 1e9)))
    told += [run.progress(round(t * 1e9)) for t in (1.9, 10.8, 12.0)]
    assert told == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.1, 0.99, 1.0])
