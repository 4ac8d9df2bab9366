# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Any arm from joint_states and robot_description alone: on line, from its bag, and fitted."""

import time

import numpy as np
import pytest
from gripper_arm import ARM, COULOMB, ROTOR, VISCOUS, gripper_arm_log, gripper_arm_urdf
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.recorded_robot import stated_armature
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import serialize
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.model.simple_models import skeleton_model
from sosml_friction.nodes.observer_node import PATIENCE
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.observers.configuration import parse_configuration

FIRST_NS = 1_000_000_000
OBSERVERS = ('first_order', 'sosml')


def messages(log) -> list[JointState]:
    result = []
    for t_ns, q, v, tau in zip(log.t_ns.tolist(), log.q, log.v, log.tau, strict=True):
        state = JointState(name=list(log.names), position=q.tolist(), velocity=v.tolist())
        state.effort = tau.tolist()
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(t_ns, 10**9)
        result.append(state)
    return result


def record(folder, states, texts):
    """Return a bag with the messages themselves."""
    with BagRecorder(folder) as recorder:
        recorder.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
        for topic, text in texts.items():
            recorder.add_topic(topic, 'std_msgs/msg/String', latched=True)
            recorder.write(topic, serialize(String(data=text)), FIRST_NS)
        for state in states:
            stamp = state.header.stamp
            t_ns = stamp.sec * 10**9 + stamp.nanosec
            recorder.write('/joint_states', serialize(state), t_ns)
    return folder


def estimated(ros, start_node, urdf, batches, *parameters, listeners=1):
    """Return what observer_node says of states, with its configuration."""
    description = ros.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf))
    output = ros.node.create_publisher(JointState, 'joint_states', JOINT_STATES)
    topics = [f'friction_estimate/{name}' for name in OBSERVERS]
    estimates = {topic: ros.collect(JointState, topic, JOINT_STATES) for topic in topics}
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    node = start_node('observer_node', 'armature:=[0.1]', *parameters)
    ros.spin_until(lambda: output.get_subscription_count() >= listeners)
    for states, known in batches:
        for state in states:
            output.publish(state)
        if known is None:
            # The publishers are made when the joints are known, and found some time later.
            ros.spin_until(lambda: all(ros.node.count_publishers(t) == 1 for t in topics))
            ros.spin_until(lambda: configuration)
        else:
            ros.spin_until(lambda known=known: min(map(len, estimates.values())) >= known)
    return node, estimates, parse_configuration(configuration[0].data, 'test')


def test_estimates_and_fits_of_an_arm_with_a_gripper_are_right_on_line_and_from_a_bag(
    ros, start_node, make_serial_arm, tmp_path
):
    urdf = gripper_arm_urdf(make_serial_arm)
    log = gripper_arm_log(urdf, 9.0)
    states = messages(log)
    # The first message makes the node; of its estimate, nobody can have heard.
    batches = [(states[:1], None)]
    batches += [
        (states[k : k + 100], min(k + 100, len(states)) - 1) for k in range(1, len(states), 100)
    ]
    _, estimates, configuration = estimated(ros, start_node, urdf, batches)
    assert set(configuration.joints) == {*ARM, 'finger_a'}

    texts = {'/robot_description': urdf, '/observer_configuration': configuration.to_yaml()}
    path = record(tmp_path / 'bag', states, texts)
    model = stated_armature(Bag.open(path), path, None, None, {'*': ROTOR})
    analysis = analyse_bag(path, model)
    assert analysis.configuration == configuration
    index = {t: k for k, t in enumerate(analysis.log.t_ns.tolist())}
    for name in OBSERVERS:
        received = estimates[f'friction_estimate/{name}']
        stamps = [s.header.stamp.sec * 10**9 + s.header.stamp.nanosec for s in received]
        rows = [index[t] for t in stamps]
        assert len(rows) >= len(states) - 1
        live = np.array([state.effort for state in received])
        # The finger rests, and its effort is no friction.
        own = [analysis.log.names.index(joint) for joint in ARM]
        np.testing.assert_array_equal(live[:, own], analysis.estimates[name][rows][:, own])
    for name, coulomb, viscous in zip(ARM, COULOMB, VISCOUS, strict=True):
        found = analysis.fit.joints[name]['weak_form'].fit.parameters
        assert found['coulomb'].value == pytest.approx(coulomb, rel=0.02)
        assert found['viscous'].value == pytest.approx(viscous, rel=0.05)
    assert 'does not move' in analysis.fit.unavailable['finger_a']


def test_joints_that_joint_states_does_not_name_are_held_with_a_sentence(
    ros, start_node, make_serial_arm
):
    """A gripper publishes by itself: the arm is what the fuller messages name."""
    urdf = gripper_arm_urdf(make_serial_arm)
    log = gripper_arm_log(urdf, 1.0)
    arm = messages(log.select(ARM))
    gripper = messages(log.select(('finger_a', 'finger_b')))
    first = [state for pair in zip(gripper, arm, strict=True) for state in pair][:PATIENCE]
    rest = arm[PATIENCE // 2 :]
    node, estimates, configuration = estimated(
        ros, start_node, urdf, [(first, None), (rest, len(rest))]
    )
    assert configuration.joints == ARM
    assert list(estimates['friction_estimate/sosml'][-1].name) == list(ARM)
    assert 'joint finger_a is not in the model and held at 0 m, where it was' in node.output


def test_the_model_of_a_urdf_is_observed_without_the_gripper_that_nobody_measures(
    ros, start_node, make_serial_arm, tmp_path
):
    urdf = gripper_arm_urdf(make_serial_arm)
    skeleton_model(urdf).write(tmp_path / 'arm')
    states = messages(gripper_arm_log(urdf, 1.0).select(ARM))
    batches = [(states[:PATIENCE], None), (states[PATIENCE:], len(states) - PATIENCE)]
    node, _, configuration = estimated(
        ros, start_node, urdf, batches, f'model:={tmp_path / "arm"}'
    )
    assert configuration.joints == ARM
    assert 'joint finger_a of the URDF is not in the model and held at 0' in node.output


def test_a_run_begins_with_the_joints_that_are_stated(ros, start_node, make_serial_arm, tmp_path):
    """Of the arm alone: the gripper has no room for a speed ladder."""
    urdf = gripper_arm_urdf(make_serial_arm)
    states = messages(gripper_arm_log(urdf, 2.0))
    stated = f'joints:=[{",".join(ARM)}]'
    slow = ('speeds:=[0.05,0.1]', 'top_speed:=0.2', f'output:={tmp_path / "runs"}')
    node = start_node('identifier_node', 'armature:=[0.1]', stated, *slow)
    batches = [(states[:1], None), (states[1:50], 48)]
    _, _, configuration = estimated(ros, start_node, urdf, batches, stated, listeners=2)
    assert configuration.joints == ARM
    output = ros.node.create_publisher(JointState, 'joint_states', JOINT_STATES)
    ros.collect(JointTrajectory, 'joint_trajectory', 10)
    ros.spin_until(lambda: output.get_subscription_count() == 2)
    ros.spin_until(lambda: 'joints j1, j2' in node.output)
    for state in states[51:]:
        output.publish(state)
        done = ros.call(Trigger, 'identifier_node/start', done=lambda: 'starting' in node.output)
        # It may come before the state does, or before the nodes have found each other.
        if done is None or done.success:
            break
        time.sleep(0.1)
    else:
        pytest.fail(done.message)
    (bag,) = (tmp_path / 'runs').glob('*/bag')
    assert bag.is_dir()


def test_without_a_model_the_node_says_what_to_state(ros, start_node, make_serial_arm):
    urdf = gripper_arm_urdf(make_serial_arm)
    description = ros.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf))
    node = start_node('observer_node')
    assert node.wait() == 2
    assert 'set parameter armature' in node.output
    assert 'Traceback' not in node.output
