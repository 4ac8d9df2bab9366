# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""identifier_node: what it refuses, how a run fails, and what a crash costs."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from sosml_friction.bags.bag import Bag
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.share import share_directory

NAMES = ['shoulder', 'elbow']
REST = [-1.5707963267948966, 0.0]
PERIOD_NS = 2_000_000


class Robot:
    """A robot that does not move: joint_states at 500 Hz by its own stamps, and a description."""

    def __init__(self, ros, names=tuple(NAMES)) -> None:
        self.ros, self.names = ros, list(names)
        self.sent: list[int] = []
        description = ros.node.create_publisher(String, 'robot_description', LATCHED)
        urdf = share_directory() / 'urdf' / 'exoskeleton.urdf'
        description.publish(String(data=urdf.read_text()))
        self.output = ros.node.create_publisher(JointState, 'joint_states', JOINT_STATES)
        self._now_ns = 1_000_000_000
        ros.node.create_timer(0.002, self.step)

    def step(self) -> None:
        state = JointState(name=self.names, position=REST, velocity=[0.0, 0.0], effort=[0.1, 0.2])
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(self._now_ns, 10**9)
        self.sent.append(self._now_ns)
        self._now_ns += PERIOD_NS
        self.output.publish(state)


def phase(ros):
    """Return a function that tells the identifier's phase and sentence."""
    arrays = ros.collect(DiagnosticArray, '/diagnostics', QoSProfile(depth=100))

    def last() -> tuple[str, str]:
        for array in reversed(arrays):
            for status in array.status:
                if status.name == 'identifier_node: run':
                    values = {item.key: item.value for item in status.values}
                    return values['phase'], status.message
        return '', ''

    return last


@pytest.fixture
def bench(ros, start_node, tmp_path):
    """Return a standing robot, observers and identifier, and the phase."""
    robot = Robot(ros)
    tell = phase(ros)
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node('observer_node')
    identifier = start_node(
        'identifier_node', f'output:={tmp_path}', 'run_name:=run', 'centre:=[-1.57, 1.2]'
    )
    ros.spin_until(lambda: configuration and tell()[0] == 'idle')
    ros.spin_until(lambda: robot.output.get_subscription_count() == 2)
    return robot, identifier, tell


def start(ros) -> None:
    """Call ~/start until it agrees: its peers may not have been discovered yet."""
    answers = []

    def decided() -> bool:
        answers.append(ros.call(Trigger, 'identifier_node/start'))
        early = ('does not answer', 'nothing was received')
        return answers[-1].success or not any(words in answers[-1].message for words in early)

    ros.spin_until(decided)
    assert answers[-1].success, answers[-1].message


def test_without_a_driver_start_says_what_to_start(ros, start_node, tmp_path):
    start_node('identifier_node', f'output:={tmp_path}')
    answer = ros.call(Trigger, 'identifier_node/start')
    assert not answer.success
    assert 'start the driver' in answer.message
    assert not ros.call(Trigger, 'identifier_node/fit').success
    assert not ros.call(Trigger, 'identifier_node/abort').success
    assert not any(tmp_path.glob('*/bag'))


def test_a_robot_that_does_not_follow_fails_the_run_and_keeps_the_bag(ros, bench, tmp_path):
    """A driver that is not enabled is the usual reason; the sentence says so."""
    robot, _, tell = bench
    start(ros)
    again = ros.call(Trigger, 'identifier_node/start')
    assert not again.success
    ros.spin_until(lambda: tell()[0] == 'failed')
    assert 'is the driver enabled' in tell()[1]
    log = Bag.open(tmp_path / 'run' / 'bag').joint_log()
    first = robot.sent.index(int(log.t_ns[0]))
    assert log.t_ns.tolist() == robot.sent[first : first + len(log)]
    assert not (tmp_path / 'run' / 'model').exists()


def test_abort_closes_the_bag(ros, bench, tmp_path):
    _, _, tell = bench
    start(ros)
    ros.spin_until(lambda: tell()[0] == 'moving')
    assert ros.call(Trigger, 'identifier_node/abort').success
    assert not Bag.open(tmp_path / 'run' / 'bag').recovered


def test_a_killed_identifier_leaves_a_bag_with_all_but_the_last_half_second(ros, bench, tmp_path):
    """kill -9 while it records: what was sent up to 0.5 s before is in the bag."""
    robot, identifier, tell = bench
    start(ros)
    ros.spin_until(lambda: tell()[0] == 'moving')
    begun = len(robot.sent)
    ros.spin_until(lambda: len(robot.sent) > begun + 350)
    # Acknowledged by the identifier's DDS, so that it is the recorder that is judged.
    killed_at = robot.sent[-1]
    identifier.stop(signal.SIGKILL)
    bag = Bag.open(tmp_path / 'run' / 'bag')
    assert bag.recovered
    log = bag.joint_log()
    first = robot.sent.index(int(log.t_ns[0]))
    assert log.t_ns.tolist() == robot.sent[first : first + len(log)]
    assert killed_at - int(log.t_ns[-1]) <= 500_000_000
    assert bag.text('robot_description')
    assert bag.text('model_description')
    assert bag.text('observer_configuration')


def test_a_robot_of_other_joints_ends_the_node_with_one_sentence(ros, start_node, tmp_path):
    urdf = (share_directory() / 'urdf' / 'exoskeleton.urdf').read_text()
    description = ros.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf.replace('name="elbow"', 'name="wrist"')))
    node = start_node('identifier_node', f'output:={tmp_path}')
    ros.spin_until(lambda: node.process.poll() is not None)
    assert node.wait() == 2
    lines = [line for line in node.output.splitlines() if '[INFO]' not in line]
    assert len(lines) == 1, node.output
    assert 'the URDF moves the joints shoulder, wrist' in lines[0]


@pytest.mark.parametrize(
    ('parameters', 'sentence'),
    [
        (['model:=/nonexistent'], 'model /nonexistent cannot be read'),
        (['centre:=[0.0]'], 'parameter centre has 1 values'),
        (['method:=magic'], 'use one of auto'),
        (['trajectory:=zigzag'], 'use one of speed_ladder, symmetric_reversals'),
    ],
)
def test_a_configuration_that_cannot_work_is_refused(start_node, parameters, sentence):
    node = start_node('identifier_node', *parameters)
    assert node.wait() == 2
    lines = [line for line in node.output.splitlines() if '[INFO]' not in line]
    assert len(lines) == 1, node.output
    assert sentence in lines[0]


def test_a_trajectory_beyond_the_limits_is_refused_before_anything_moves(
    ros, start_node, tmp_path: Path
):
    Robot(ros)
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    trajectories = ros.collect(JointTrajectory, 'joint_trajectory', 10)
    start_node('observer_node')
    start_node('identifier_node', f'output:={tmp_path}', 'speeds:=[2.9]')
    ros.spin_until(lambda: configuration)
    answer = ros.call(Trigger, 'identifier_node/start')
    ros.spin_until(
        lambda: 'beyond its limit' in ros.call(Trigger, 'identifier_node/start').message
    )
    assert not answer.success
    assert not trajectories
    assert not any(tmp_path.glob('*/bag'))


def test_another_trajectory_is_run_with_the_options_under_its_name(ros, start_node, tmp_path):
    """The shoulder: 0.1 rad, 2 cycles at 0.5 Hz between ramps of 1 s; the elbow stays."""
    Robot(ros)
    trajectories = ros.collect(JointTrajectory, 'joint_trajectory', 10)
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node('observer_node')
    options = ('amplitude:=0.1', 'cycles:=2.0', 'ramp:=1.0')
    start_node(
        'identifier_node',
        f'output:={tmp_path}',
        'run_name:=run',
        'trajectory:=reversal',
        'scale:=[1.0, 0.0]',
        *(f'reversal.{option}' for option in options),
    )
    ros.spin_until(lambda: configuration)
    start(ros)
    ros.spin_until(lambda: trajectories)
    points = trajectories[0].points
    away = np.array([point.positions for point in points]) - REST
    assert np.abs(away[:, 0]).max() == pytest.approx(0.1, rel=0.01)
    np.testing.assert_array_equal(away[:, 1], 0.0)
    end = points[-1].time_from_start
    # The move to the centre, where the robot is already, takes 0.4 s.
    assert end.sec + 1e-9 * end.nanosec == pytest.approx(0.4 + 4.0 + 2.0)
