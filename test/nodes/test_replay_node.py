# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""replay_node: a bag played is the bag recorded, and gives the estimates it gave."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.model.model_folder import read_model
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.share import share_directory

SAMPLES = 1000


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a bag of 2 s of motion at 500 Hz with its model and URDF."""
    model = read_model(share_directory() / 'config' / 'exoskeleton')
    t = np.arange(SAMPLES) / 500.0
    phase = np.column_stack([3.0 * t, 5.0 * t])
    log = JointLog(
        model.joint_names,
        1_700_000_000_000_000_000 + np.arange(SAMPLES) * 2_000_000,
        0.5 + 0.4 * np.sin(phase),
        0.4 * np.array([3.0, 5.0]) * np.cos(phase),
        np.cos(2.0 * phase),
    )
    folder = tmp_path_factory.mktemp('bags') / 'motion'
    return write_joint_log(log, folder, model.urdf, model.to_yaml())


def stamp(state: JointState) -> int:
    return state.header.stamp.sec * 10**9 + state.header.stamp.nanosec


@pytest.mark.parametrize('rate', [1.0, 10.0])
def test_replay_and_observer_give_the_batch_estimates_at_any_speed(ros, start_node, bag, rate):
    """Each sample is played once, in order, and estimated exactly as the batch path does."""
    played = ros.collect(JointState, 'joint_states', JOINT_STATES)
    estimates = ros.collect(JointState, 'friction_estimate/sosml', JOINT_STATES)
    clocks = ros.collect(Clock, '/clock', 100)
    descriptions = ros.collect(String, 'robot_description', LATCHED)
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node('observer_node', f'urdf_path:={share_directory() / "urdf" / "exoskeleton.urdf"}')
    ros.spin_until(lambda: configuration)
    replay = start_node('replay_node', f'bag:={bag}', f'rate:={rate}', 'subscribers:=2')
    ros.spin_until(lambda: replay.process.poll() is not None)
    assert replay.wait() == 0, replay.output
    ros.spin_until(lambda: len(estimates) >= SAMPLES and len(played) >= SAMPLES)

    log = Bag.open(bag).joint_log()
    assert [stamp(state) for state in played] == log.t_ns.tolist()
    np.testing.assert_array_equal(np.array([state.position for state in played]), log.q)
    assert descriptions
    assert clocks

    from sosml_friction.observers.configuration import parse_configuration

    robot = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
    estimator = parse_configuration(configuration[0].data, 'test').make_estimator(robot)
    expected = dict(zip(log.t_ns.tolist(), estimator.batch(log)['sosml'], strict=True))
    assert len(estimates) == SAMPLES
    for state in estimates:
        np.testing.assert_array_equal(state.effort, expected[stamp(state)])


def test_pause_holds_the_bag_and_resume_goes_on(ros, start_node, bag):
    played = ros.collect(JointState, 'joint_states', JOINT_STATES)
    replay = start_node('replay_node', f'bag:={bag}')
    ros.spin_until(lambda: len(played) > 10)
    assert ros.call(Trigger, 'replay_node/pause').success
    assert not ros.call(Trigger, 'replay_node/pause').success
    # What was on its way has arrived once the second answer has; from here on nothing may come.
    held = len(played)
    assert not ros.call(Trigger, 'replay_node/pause').success
    assert len(played) <= held + 1
    assert ros.call(Trigger, 'replay_node/resume').success
    ros.spin_until(lambda: len(played) == SAMPLES)
    ros.spin_until(lambda: replay.process.poll() is not None)
    assert replay.wait() == 0


def test_excluded_topics_are_not_played(ros, start_node, bag):
    descriptions = ros.collect(String, 'robot_description', LATCHED)
    played = ros.collect(JointState, 'joint_states', JOINT_STATES)
    replay = start_node('replay_node', f'bag:={bag}', 'rate:=10.0', 'exclude:=[/robot_*]')
    ros.spin_until(lambda: len(played) == SAMPLES)
    ros.spin_until(lambda: replay.process.poll() is not None)
    assert not descriptions


@pytest.mark.parametrize(
    ('parameters', 'sentence'),
    [
        ([], 'parameter bag of replay_node is not set'),
        (['bag:=/nonexistent'], '/nonexistent'),
        (['bag:=BAG', "exclude:=['*']"], 'nothing is left to play'),
        (['bag:=BAG', 'rate:=0.0'], 'rate of replay_node does not fit'),
    ],
)
def test_what_cannot_be_played_is_refused_with_one_sentence(refusal, bag, parameters, sentence):
    parameters = [parameter.replace('BAG', str(bag)) for parameter in parameters]
    (line,) = (x for x in refusal('replay_node', *parameters) if '[INFO]' not in x)
    assert sentence in line
