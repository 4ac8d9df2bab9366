# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""observer_node: every joint_states message gets its estimate, and bad input gets a sentence."""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from outside_observer import define_observer
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import EffectTerm, read_model
from sosml_friction.model.parameter import Parameter as ModelParameter
from sosml_friction.model.simple_models import skeleton_model
from sosml_friction.model.urdf_bodies import with_bodies
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.nodes.observer_node import PATIENCE
from sosml_friction.nodes.observer_parameters import parameters
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.observers.configuration import parse_configuration
from sosml_friction.observers.observer import Observer
from sosml_friction.observers.registry import on_line_names
from sosml_friction.share import share_directory

NAMES = ('shoulder', 'elbow')
HZ = 500


@pytest.fixture(scope='module')
def urdf_path() -> Path:
    return share_directory() / 'urdf' / 'exoskeleton.urdf'


def message(k: int, names=NAMES, effort=True, velocity=True) -> JointState:
    """Return sample k of a smooth motion, 500 Hz."""
    t = k / HZ
    phase = np.arange(1, len(names) + 1) * t
    result = JointState(name=list(names), position=(0.5 + 0.4 * np.sin(phase)).tolist())
    result.header.stamp.sec, result.header.stamp.nanosec = divmod(
        1_000_000_000 + k * 2_000_000, 10**9
    )
    result.header.frame_id = 'base_link'
    if velocity:
        result.velocity = (0.4 * np.arange(1, len(names) + 1) * np.cos(phase)).tolist()
    if effort:
        result.effort = (2.0 * np.sin(3.0 * phase)).tolist()
    return result


def stamp(state: JointState) -> int:
    return state.header.stamp.sec * 10**9 + state.header.stamp.nanosec


def published(
    ros, urdf_path, start_node, *parameters, observers=('first_order', 'sosml'), module=''
):
    """Start observers and return (publisher, estimates of all topics, configuration)."""
    estimates = {
        topic: ros.collect(JointState, topic, JOINT_STATES)
        for topic in (
            'friction_estimate',
            *(f'friction_estimate/{observer}' for observer in observers),
        )
    }
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    output = ros.node.create_publisher(JointState, 'joint_states', JOINT_STATES)
    start_node('observer_node', *parameters, module=module)
    ros.spin_until(lambda: output.get_subscription_count() and configuration)
    for topic in estimates:
        ros.spin_until(lambda topic=topic: ros.node.count_publishers(topic) == 1)
    return output, estimates, configuration


@pytest.mark.parametrize(
    ('count', 'observers', 'parameters'),
    [
        (1500, ('first_order', 'sosml'), ()),
        (
            500,
            on_line_names(),
            (
                f'observers:=[{",".join(on_line_names())}]',
                'friction_jump:=[2.0,1.0]',
                'reversal_time:=[1.0,1.0]',
                'position_noise:=[5.0e-5,5.0e-5]',
                'velocity_noise:=[2.0e-3,2.0e-3]',
            ),
        ),
    ],
    ids=['default', 'all'],
)
def test_every_message_gets_one_estimate_per_observer_with_its_stamp_and_the_batch_value(
    ros, urdf_path, start_node, count, observers, parameters
):
    """The node is a thin shell: 0 difference from the pure estimator on the same samples."""
    description = ros.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf_path.read_text()))
    output, estimates, configuration = published(
        ros, urdf_path, start_node, *parameters, observers=observers
    )
    sent = [message(k) for k in range(count)]
    for start in range(0, len(sent), 100):
        for state in sent[start : start + 100]:
            output.publish(state)
        ros.spin_until(lambda start=start: len(estimates['friction_estimate']) >= start + 100)
    for received in estimates.values():
        ros.spin_until(lambda received=received: len(received) >= len(sent))
        assert [stamp(state) for state in received] == [stamp(state) for state in sent]
        assert all(state.header.frame_id == 'base_link' for state in received)

    robot = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
    estimator = parse_configuration(configuration[0].data, 'test').make_estimator(robot)
    log = JointLog(
        NAMES,
        np.array([stamp(state) for state in sent]),
        np.array([state.position for state in sent]),
        np.array([state.velocity for state in sent]),
        np.array([state.effort for state in sent]),
    )
    batch = estimator.batch(log)
    assert set(batch) == set(observers)
    for name, expected in batch.items():
        live = np.array([state.effort for state in estimates[f'friction_estimate/{name}']])
        np.testing.assert_array_equal(live, expected)
    selected = np.array([state.effort for state in estimates['friction_estimate']])
    np.testing.assert_array_equal(selected, batch['sosml'])
    position = np.array([state.position for state in estimates['friction_estimate']])
    np.testing.assert_array_equal(position, log.q)


def test_an_observer_from_outside_the_package_runs_in_the_node(
    ros, urdf_path, start_node, monkeypatch
):
    """Defined by another program, which then runs the node: every message gets its estimate."""
    monkeypatch.setattr(Observer.registry, 'known', dict(Observer.registry))
    define_observer()
    description = ros.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf_path.read_text()))
    parameters = ('observers:=[leaky]', 'selected:=leaky', 'leaky.time_constant:=[0.02,0.03]')
    output, estimates, configuration = published(
        ros, urdf_path, start_node, *parameters, observers=('leaky',), module='outside_observer'
    )
    sent = [message(k) for k in range(200)]
    for state in sent:
        output.publish(state)
    received = estimates['friction_estimate/leaky']
    ros.spin_until(lambda: len(received) >= len(sent))
    robot = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
    estimator = parse_configuration(configuration[0].data, 'test').make_estimator(robot)
    for state, estimate in zip(sent, received, strict=True):
        columns = (np.array(x) for x in (state.position, state.velocity, state.effort))
        expected = estimator.update(stamp(state), *columns)['leaky']
        np.testing.assert_array_equal(estimate.effort, expected)


def test_a_diagnosed_model_gives_its_own_body_and_the_torque_behind_the_effort(
    ros, urdf_path, start_node, tmp_path
):
    """The driver's older robot_description does not count, and a scale of effort is undone."""
    urdf = urdf_path.read_text()
    known = read_model(share_directory() / 'config' / 'exoskeleton')
    body = 1.2 * known.make_robot().inertial_parameters()[1]
    heavier = replace(
        known,
        urdf=with_bodies(urdf, {'elbow': body}),
        effects=(EffectTerm('effort_scale', 'shoulder', {'error': ModelParameter(0.1, '1')}),),
        provenance={'rigid_body': {'written': ['gravity@elbow'], 'refused': {}}},
    )
    heavier.write(tmp_path / 'model')
    description = ros.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf))
    output, estimates, configuration = published(
        ros, urdf_path, start_node, f'model:={tmp_path / "model"}'
    )
    sent = [message(k) for k in range(100)]
    for state in sent:
        output.publish(state)
    ros.spin_until(lambda: len(estimates['friction_estimate']) >= len(sent))
    estimator = parse_configuration(configuration[0].data, 'test').make_estimator(
        heavier.make_robot()
    )
    effort = np.array([state.effort for state in sent])
    log = JointLog(
        NAMES,
        np.array([stamp(state) for state in sent]),
        np.array([state.position for state in sent]),
        np.array([state.velocity for state in sent]),
        effort / [1.1, 1.0],
    )
    live = np.array([state.effort for state in estimates['friction_estimate']])
    np.testing.assert_array_equal(live, estimator.batch(log)['sosml'])


def test_reset_starts_the_observers_afresh(ros, urdf_path, start_node):
    """After ~/reset the next estimate is NaN, not yet known, and the one after it is a number."""
    output, estimates, _ = published(ros, urdf_path, start_node, f'urdf_path:={urdf_path}')
    received = estimates['friction_estimate']
    for k in range(10):
        output.publish(message(k))
    ros.spin_until(lambda: len(received) == 10)
    assert ros.call(Trigger, 'observer_node/reset').success
    for k in range(10, 12):
        output.publish(message(k))
    ros.spin_until(lambda: len(received) == 12)
    known = [bool(np.isfinite(state.effort).all()) for state in received]
    assert known == [False] + [True] * 9 + [False, True]


def test_a_position_that_wraps_is_continuous_in_the_estimate(ros, urdf_path, start_node, tmp_path):
    """The estimate is that of the same motion without a wrap, but for the joint's weight."""
    endless = tmp_path / 'endless.urdf'
    endless.write_text(urdf_path.read_text().replace('"revolute"', '"continuous"'))
    diagnostics = ros.collect(DiagnosticArray, '/diagnostics', 10)
    output, estimates, _ = published(ros, urdf_path, start_node, f'urdf_path:={endless}')
    received = estimates['friction_estimate']
    sent = []
    for k in range(100):
        state = message(k)
        position = 2.8 + 4.0 * k / HZ
        sent.append(position)
        state.position[0] = (position + np.pi) % (2.0 * np.pi) - np.pi
        state.velocity[0] = 4.0
        output.publish(state)
    ros.spin_until(lambda: len(received) == 100)
    np.testing.assert_allclose([state.position[0] for state in received], sent, atol=1e-9)
    effort = np.array([state.effort for state in received])
    assert np.isfinite(effort[1:]).all()
    # A momentum that had jumped by a turn would show as an estimate of hundreds of Nm.
    assert np.abs(effort[1:]).max() < 20.0
    told = 'shoulder by 6.28319'
    ros.spin_until(
        lambda: any(told == x.value for d in diagnostics for s in d.status for x in s.values)
    )


def test_joints_are_found_by_name_whatever_their_order_and_company(ros, urdf_path, start_node):
    output, estimates, _ = published(ros, urdf_path, start_node, f'urdf_path:={urdf_path}')
    for k in range(3):
        state = message(k, ('gripper', 'elbow', 'shoulder'))
        output.publish(state)
        output.publish(JointState(header=state.header, name=['gripper'], position=[0.0]))
    received = estimates['friction_estimate']
    ros.spin_until(lambda: len(received) == 3)
    for k, state in enumerate(received):
        assert list(state.name) == list(NAMES)
        assert state.position[0] == message(k, ('gripper', 'elbow', 'shoulder')).position[2]


def statuses(diagnostics) -> dict[str, tuple[bytes, str]]:
    """Return level and message of each part, from the last array."""
    return {
        status.name.removeprefix('observer_node: '): (status.level, status.message)
        for status in diagnostics[-1].status
    }


def test_what_is_wrong_is_nan_and_told_and_ends(ros, urdf_path, start_node):
    """Good, an effort that cannot be, silence, good again: level and sentence follow."""
    diagnostics = ros.collect(DiagnosticArray, '/diagnostics', 10)
    errors = ros.collect(JointState, 'friction_estimate_error', JOINT_STATES)
    output, estimates, _ = published(ros, urdf_path, start_node, f'urdf_path:={urdf_path}')
    ros.spin_until(lambda: ros.node.count_publishers('friction_estimate_error') == 1)
    received = estimates['friction_estimate']
    sent = 0

    def tell(level, sentence, change=lambda state: None):
        nonlocal sent
        diagnostics.clear()

        def back():
            last = stamp(message(sent - 1))
            return all(got and stamp(got[-1]) == last for got in (received, errors))

        def told():
            nonlocal sent
            # Each message that comes back calls this: no faster than they do.
            if not sent or back():
                time.sleep(0.02)
                for _ in range(10):
                    state = message(sent)
                    change(state)
                    output.publish(state)
                    sent += 1
            said = statuses(diagnostics)['observers'] if diagnostics else (b'', '')
            return said[0] == level and sentence in said[1]

        ros.spin_until(told)
        ros.spin_until(back)

    def implausible(state):
        state.effort[0] = 60.0

    tell(DiagnosticStatus.OK, 'observing shoulder, elbow')
    assert np.isfinite(received[-1].effort).all()
    assert np.isfinite(errors[-1].effort).all()
    tell(DiagnosticStatus.WARN, 'shoulder: effort 60 Nm where the URDF', implausible)
    assert np.isfinite(received[-1].effort).tolist() == [False, True]
    assert np.isfinite(errors[-1].effort).tolist() == [False, True]
    diagnostics.clear()
    ros.spin_until(
        lambda: diagnostics and statuses(diagnostics)['observers'][0] == DiagnosticStatus.ERROR
    )
    assert 'see whether the driver runs' in statuses(diagnostics)['shoulder'][1]
    tell(DiagnosticStatus.OK, 'observing shoulder, elbow')
    assert np.isfinite(received[-1].effort).all()


def test_a_joint_that_is_held_and_moves_makes_what_carries_it_unknown(ros, urdf_path, start_node):
    """Its weight passed for friction of the shoulder: 1.4 Nm with an error of 0.03, and OK."""
    diagnostics = ros.collect(DiagnosticArray, '/diagnostics', 10)
    received = ros.collect(JointState, 'friction_estimate', JOINT_STATES)
    output = ros.node.create_publisher(JointState, 'joint_states', JOINT_STATES)
    parameters = (f'urdf_path:={urdf_path}', 'armature:=[0.1]', 'joints:=[shoulder]')
    start_node('observer_node', *parameters)
    ros.spin_until(lambda: output.get_subscription_count() == 1)
    count = iter(range(10**6))

    def told() -> bool:
        for _ in range(10):
            k = next(count)
            state = message(k)
            state.effort[0] += 0.1 * np.cos(50.0 * k)
            output.publish(state)
        parts = statuses(diagnostics) if diagnostics else {}
        # Until the first message is heard, the node tells of its observers alone.
        return 'shoulder' in parts and 'joint elbow is at' in parts['shoulder'][1]

    # Two topics, in no order: the last estimate that came may be one from before.
    ros.spin_until(lambda: told() and np.isnan(received[-1].effort[0]))
    assert np.isfinite([state.effort[0] for state in received]).any()


def test_what_does_not_fit_the_joints_is_refused_before_they_are_heard(
    ros, start_node, make_serial_arm, tmp_path
):
    """Where a joint is held, the node waits for where it is; wrong parameters waited with it."""
    urdf = make_serial_arm(['revolute'] * 3, seed=1)
    (tmp_path / 'arm.urdf').write_text(urdf)
    names = list(read_joints(urdf).joints)
    known = replace(skeleton_model(urdf, names[:2], True), provenance={})
    known.write(tmp_path / 'arm')
    stated = (f'model:={tmp_path / "arm"}', f'urdf_path:={tmp_path / "arm.urdf"}')
    stated += ('armature:=[0.1]',)
    for wrong in ('passive_joints:=[gripper]', 'velocity_noise:=[-1.0,1.0]'):
        node = start_node('observer_node', *stated, wrong)
        assert node.wait() == 2
        assert wrong.split(':')[0] in node.output


def test_a_joint_that_is_named_twice_is_told_and_observers_have_their_namespace(
    ros, urdf_path, start_node
):
    """The first was taken in silence; and two observers told under one name."""
    diagnostics = ros.collect(DiagnosticArray, '/diagnostics', 10)
    output = ros.node.create_publisher(JointState, '/left/joint_states', JOINT_STATES)
    start_node('observer_node', f'urdf_path:={urdf_path}', namespace='/left')
    ros.spin_until(lambda: output.get_subscription_count())
    count = iter(range(10**6))

    def told() -> bool:
        output.publish(message(next(count), ('shoulder', 'elbow', 'elbow')))
        parts = {s.name: s.message for d in diagnostics for s in d.status}
        return 'name a joint twice' in parts.get('left/observer_node: observers', '')

    ros.spin_until(told)


def test_a_best_effort_publisher_is_followed(ros, urdf_path, start_node):
    loose = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    output = ros.node.create_publisher(JointState, 'joint_states', loose)
    received = ros.collect(JointState, 'friction_estimate', JOINT_STATES)
    node = start_node('observer_node', f'urdf_path:={urdf_path}')
    count = iter(range(10**6))
    ros.spin_until(lambda: output.publish(message(next(count))) or received)
    assert 'publishes joint_states best_effort: it is subscribed so' in node.output


def test_a_stated_reliability_that_cannot_match_is_told(ros, urdf_path, start_node):
    loose = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    ros.node.create_publisher(JointState, 'joint_states', loose)
    diagnostics = ros.collect(DiagnosticArray, '/diagnostics', 10)
    start_node('observer_node', f'urdf_path:={urdf_path}', 'reliability:=reliable')
    sentence = 'set parameter reliability to best_effort'
    ros.spin_until(lambda: diagnostics and sentence in statuses(diagnostics)['observers'][1])


def test_parameters_are_listed_and_gains_change_at_run_time(ros, urdf_path, start_node):
    output, estimates, configuration = published(
        ros, urdf_path, start_node, f'urdf_path:={urdf_path}'
    )
    names = [spec.name for spec in parameters()]
    values = ros.call(
        GetParameters, 'observer_node/get_parameters', GetParameters.Request(names=names)
    ).values
    # What is not set makes ros2 param dump print nothing at all.
    assert len(values) == len(names)
    assert all(value.type != ParameterType.PARAMETER_NOT_SET for value in values)

    def change(**new):
        request = SetParametersAtomically.Request(
            parameters=[
                Parameter(name.replace('__', '.'), value=value).to_parameter_msg()
                for name, value in new.items()
            ]
        )
        return ros.call(
            SetParametersAtomically, 'observer_node/set_parameters_atomically', request
        ).result

    assert not change(selected='magic').successful
    assert 'one value for each of the joints' in change(first_order__cutoff=[1.0]).reason
    assert change(selected='first_order', first_order__cutoff=[5.0, 6.0]).successful
    ros.spin_until(lambda: len(configuration) == 2)
    gains = parse_configuration(configuration[-1].data, 'test').gains
    assert gains['first_order'] == {'cutoff': [5.0, 6.0]}
    for k in range(20):
        output.publish(message(k))
    ros.spin_until(lambda: all(len(received) == 20 for received in estimates.values()))
    selected, first_order = (
        [state.effort for state in estimates[topic]]
        for topic in ('friction_estimate', 'friction_estimate/first_order')
    )
    np.testing.assert_array_equal(selected, first_order)


def test_what_is_set_while_the_node_waits_for_the_robot_counts(ros, urdf_path, start_node):
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node('observer_node', "passive_joints:=['']")
    new = Parameter('first_order.cutoff', value=[5.0, 6.0]).to_parameter_msg()
    request = SetParametersAtomically.Request(parameters=[new])
    assert ros.call(
        SetParametersAtomically, 'observer_node/set_parameters_atomically', request
    ).result.successful
    description = ros.node.create_publisher(String, 'robot_description', LATCHED)
    description.publish(String(data=urdf_path.read_text()))
    ros.spin_until(lambda: configuration)
    gains = parse_configuration(configuration[-1].data, 'test').gains
    assert gains['first_order'] == {'cutoff': [5.0, 6.0]}


@pytest.mark.parametrize(
    ('parameters', 'states', 'sentence'),
    [
        (
            (),
            {'names': ('hip', 'knee')},
            'joint_states has the joints hip, knee where the model has',
        ),
        ((), {'effort': False}, 'joint_states carries no effort'),
        ((), {'velocity': False}, 'set parameter velocity_source to position_difference'),
    ],
)
def test_useless_joint_states_end_the_node_with_one_sentence(
    ros, urdf_path, start_node, parameters, states, sentence
):
    output = ros.node.create_publisher(JointState, 'joint_states', JOINT_STATES)
    node = start_node('observer_node', f'urdf_path:={urdf_path}', *parameters)
    ros.spin_until(output.get_subscription_count)
    for k in range(PATIENCE):
        output.publish(message(k, **states))
    assert node.wait() == 2
    last = [line for line in node.output.splitlines() if '[INFO]' not in line]
    assert len(last) == 1
    assert sentence in last[0]


@pytest.mark.parametrize(
    ('parameters', 'sentence'),
    [
        (['model:=/nonexistent'], 'model /nonexistent cannot be read'),
        (['urdf_path:=/nonexistent.urdf'], 'URDF /nonexistent.urdf'),
        (['observers:=[magic]'], 'choose from quasi_static, first_order'),
        (['observers:=[sosml, smoother]'], 'smoother needs the whole recording'),
        (['selected:=first_order', 'observers:=[sosml]'], 'select one that runs'),
        (['bandwith:=30.0'], 'has no parameter bandwith: did you mean bandwidth?'),
        (['bandwidth:=-3.0'], 'bandwidth of observer_node does not fit'),
        (['sosml.linear:=[1.0]'], 'gain >= 0 for each joint'),
        (['effort_hold:=[never]'], 'effort_hold'),
        (['observers:=[sosml, kalman]'], 'observer kalman has no gains by bandwidth'),
        (['passive_joints:=[elbow, wrist]'], 'passive_joints names wrist, which is not observed'),
        (['friction_jump:=[2.0, 1.0]'], 'position_noise is [] for the joints shoulder, elbow'),
    ],
)
def test_a_configuration_that_cannot_work_is_refused_with_one_sentence(
    refusal, urdf_path, parameters, sentence
):
    if not any('urdf_path' in parameter for parameter in parameters):
        parameters = [*parameters, f'urdf_path:={urdf_path}']
    (line,) = (x for x in refusal('observer_node', *parameters) if '[INFO]' not in x)
    assert sentence in line


def test_the_node_starts_without_scipy():
    """Its filters and statistics were half of the time from the command to an estimate."""
    program = (
        'import sys, sosml_friction.nodes.observer_node\n'
        "print([name for name in sys.modules if name.startswith(('scipy.signal', 'scipy.stats'))])"
    )
    found = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert (found.stdout, found.stderr) == ('[]\n', '')
