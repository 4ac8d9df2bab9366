# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Driver and emulator as processes, over slcan bytes and DDS."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Duration
from can_chain import PARAMETER_FILE, CanChain
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.nodes.demo import PATIENT_DRIVER, PATIENT_HARDWARE
from sosml_friction.nodes.driver_node import PARAMETERS, trajectory_from_message
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from validation.parameter_tables import markdown_table

HANGING = np.array([-np.pi / 2, 0.0])


class Chain(CanChain):
    """Both on a machine that may be loaded, and the joint states."""

    def __init__(self, ros, start_node) -> None:
        super().__init__(ros, start_node)
        self.states = ros.collect(JointState, 'joint_states', JOINT_STATES)

    def emulator(self, *parameters: str):
        return self.start_emulator(*PATIENT_HARDWARE, *parameters)

    def driver(self, *parameters: str):
        return self.start_driver(*PATIENT_DRIVER, 'host_timeout:=10.0', *parameters)

    def ask_to_enable(self):
        """Return the answer of the driver."""
        return self.ros.call(SetBool, 'driver_node/enable', SetBool.Request(data=True))

    def enable(self) -> None:
        """Ask until it does: on a busy machine an answer or a velocity may be missing."""
        self.ros.spin_until(lambda: self.ask_to_enable().success)

    def send(self, times, positions) -> None:
        self.ros.spin_until(lambda: self.trajectories.get_subscription_count() > 0)
        self.trajectories.publish(message(times, positions))


def message(times, positions, velocities=True) -> JointTrajectory:
    result = JointTrajectory(joint_names=['shoulder', 'elbow'])
    for t, q in zip(times, positions, strict=True):
        result.points.append(
            JointTrajectoryPoint(
                positions=[float(x) for x in q],
                velocities=[0.0, 0.0] if velocities else [],
                time_from_start=Duration(sec=int(t), nanosec=round((t % 1) * 1e9)),
            )
        )
    return result


@pytest.fixture
def chain(ros, start_node):
    return Chain(ros, start_node)


def stamps(states) -> np.ndarray:
    return np.array([s.header.stamp.sec * 10**9 + s.header.stamp.nanosec for s in states])


def test_a_whole_session(chain):
    """Measure released, enable, follow, refuse, stop, SIGTERM: one pair of processes for all."""
    ros = chain.ros
    emulator = chain.emulator()
    temperatures = ros.collect(Temperature, 'joint_temperatures', 10)
    descriptions = ros.collect(String, 'robot_description', LATCHED)
    driver = chain.driver()

    # Released: it measures, at the rate of its cycles, and nothing moves.
    ros.spin_until(lambda: len(chain.states) >= 500)
    states = list(chain.states)
    assert [tuple(s.name) for s in states] == [('shoulder', 'elbow')] * len(states)
    q = np.array([s.position for s in states])
    np.testing.assert_allclose(q, np.tile(HANGING, (len(q), 1)), atol=5e-4)
    counts = np.degrees(q[:, 0]) / 0.01
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    t = stamps(states)
    assert (np.diff(t) > 0).all()
    # Never faster than its rate; how much slower is the machine's business.
    assert np.diff(t).mean() > 1.99e6
    plant = chain.fresh('emulator_node: shoulder')
    assert float(plant['commanded current [A]']) == 0.0
    assert float(plant['true position']) == pytest.approx(-math.pi / 2, abs=1e-5)
    assert '<robot name="exoskeleton">' in descriptions[0].data

    # Every completed cycle is published, none twice.
    before = chain.fresh('driver_node: driver')
    done = int(before['cycles']) - int(before['incomplete cycles']) - int(before['late cycles'])
    ros.spin_until(lambda: len(chain.states) >= done)
    assert before['state'] == 'disabled'
    assert before['velocity lag [ms]'] == '10'
    assert chain.diagnostics['driver_node: bus'][1]['frames foreign'] == '0'
    assert chain.diagnostics['driver_node: shoulder'][1]['voltage [V]'] == '48'
    assert temperatures[0].header.frame_id == 'shoulder'
    assert temperatures[0].temperature == pytest.approx(25.0, abs=2.0)

    # A trajectory before enable is refused with its reason.
    chain.send([1.0], [HANGING + np.array([0.3, 0.4])])
    ros.spin_until(
        lambda: 'enable it before' in chain.value('driver_node: driver', 'refused trajectory')
    )
    assert ros.call(Trigger, 'driver_node/stop').success is False

    # Enabled it holds, then follows.
    chain.enable()
    target = HANGING + np.array([0.4, 0.6])
    chain.send([1.5], [target])
    ros.spin_until(lambda: np.allclose(chain.states[-1].position, target, atol=0.04))
    ros.spin_until(lambda: chain.fresh('driver_node: driver')['trajectory running'] == 'False')
    assert chain.value('driver_node: driver', 'refused trajectory') == ''
    plant = chain.fresh('emulator_node: shoulder')
    assert float(plant['true position']) == pytest.approx(target[0], abs=0.04)
    assert float(plant['commanded current [A]']) > 0.5
    assert chain.states[-1].effort[0] > 0.5

    # Beyond the limits it is refused as a whole and the joints stay.
    chain.send([5.0], [[2.0, 0.5]])
    ros.spin_until(
        lambda: 'outside its limits' in chain.value('driver_node: driver', 'refused trajectory')
    )
    assert np.allclose(chain.states[-1].position, target, atol=0.04)
    assert ros.call(Trigger, 'driver_node/stop').success

    # SIGTERM while it holds the arm up: zero current and shutdown reach the motor.
    assert float(chain.fresh('emulator_node: shoulder')['commanded current [A]']) > 0.5
    assert driver.stop(signal.SIGTERM) == 0
    ros.spin_until(lambda: chain.fresh('emulator_node: shoulder')['shutdowns'] == '1')
    assert float(chain.value('emulator_node: shoulder', 'commanded current [A]')) == 0.0
    assert float(chain.value('emulator_node: elbow', 'commanded current [A]')) == 0.0
    assert chain.value('emulator_node: shoulder', 'watchdog trips') == '0'
    assert 'Traceback' not in driver.output
    assert emulator.stop(signal.SIGINT) == 0
    assert 'Traceback' not in emulator.output


def test_a_second_commander_is_refused_and_named_and_may_always_switch_off(chain, other):
    """Whoever moves the joints holds the driver, as far as ROS tells who that is."""
    ros = chain.ros
    chain.emulator()
    driver = chain.driver('commander_timeout:=60.0')
    ros.spin_until(lambda: len(chain.states) > 100)
    chain.enable()
    chain.send([20.0], [HANGING + np.array([0.4, 0.6])])
    ros.spin_until(lambda: chain.fresh('driver_node: driver')['commander'] == 'test')
    commands = other.node.create_publisher(JointTrajectory, 'joint_trajectory', 10)
    other.spin_until(lambda: commands.get_subscription_count() > 0)
    refused = 'other or test (ROS does not tell which'
    sent_s = -np.inf

    def is_refused():
        # DDS loses what is sent before the driver has discovered its publisher: send again.
        nonlocal sent_s
        if time.monotonic() > sent_s + 1.0:
            sent_s = time.monotonic()
            commands.publish(message([1.0], [HANGING]))
        return refused in chain.value('driver_node: driver', 'refused commander')

    # ROS does not say who sent it: it may have been either.
    ros.spin_until(is_refused)
    named = message([1.0], [HANGING])
    named.header.frame_id = '/other'
    commands.publish(named)
    refused = 'other may not command: test holds this driver until 60 s'
    ros.spin_until(
        lambda: chain.value('driver_node: driver', 'refused commander').startswith(refused)
    )
    assert chain.value('driver_node: driver', 'trajectory running') == 'True'
    assert refused in chain.diagnostics['driver_node: driver'][0]
    response = other.call(SetBool, 'driver_node/enable', SetBool.Request(data=True))
    assert not response.success
    # The test has a client of that service as well.
    assert 'test holds this driver' in response.message
    commands.publish(named)
    # Off is for everybody, and lets the driver go.
    assert other.call(SetBool, 'driver_node/enable', SetBool.Request()).success
    assert chain.fresh('driver_node: driver')['commander'] == 'nobody'
    chain.enable()
    commands.publish(named)
    ros.spin_until(lambda: chain.fresh('driver_node: driver')['commander'] == 'other')
    assert driver.output.count('other may not command') == 1


def test_lifecycle_and_a_lost_bus(chain):
    """Without autostart it waits to be told; deactivation ends the torque; a dead bus is said."""
    ros = chain.ros
    emulator = chain.emulator()
    driver = chain.driver('autostart:=false')

    def state() -> str:
        return ros.call(GetState, 'driver_node/get_state').current_state.label

    def change(transition, end) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        service = 'driver_node/change_state'
        answer = ros.call(ChangeState, service, request, done=lambda: state() == end)
        return answer is None or answer.success

    assert state() == 'unconfigured'
    # What does not fit ended the program with a trace.
    for wrong in (Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_CLEANUP, 99):
        request = ChangeState.Request(transition=Transition(id=wrong))
        assert not ros.call(ChangeState, 'driver_node/change_state', request).success
    assert f'transition {Transition.TRANSITION_CLEANUP} does not fit the state' in driver.output
    assert state() == 'unconfigured'
    assert change(Transition.TRANSITION_CONFIGURE, 'inactive')
    assert not chain.ask_to_enable().success
    plant = chain.fresh('emulator_node: shoulder')
    # The start-up only asks, version, model, status, uptime, status with angle, status again, and
    # again what a busy machine answers too late; then it is silent.
    assert int(plant['frames']) >= 7
    assert plant['commanded current [A]'] == '0'
    assert chain.fresh('emulator_node: shoulder')['frames'] == plant['frames']
    assert change(Transition.TRANSITION_ACTIVATE, 'active')
    ros.spin_until(lambda: len(chain.states) > 100)
    chain.enable()
    assert change(Transition.TRANSITION_DEACTIVATE, 'inactive')
    assert chain.fresh('emulator_node: shoulder')['shutdowns'] == '1'
    count = len(chain.states)
    frames = chain.fresh('emulator_node: shoulder')['frames']
    assert chain.fresh('emulator_node: shoulder')['frames'] == frames
    assert change(Transition.TRANSITION_ACTIVATE, 'active')
    ros.spin_until(lambda: len(chain.states) > count + 100)
    chain.enable()

    emulator.stop(signal.SIGKILL)
    ros.spin_until(lambda: chain.value('driver_node: driver', 'state') == 'fault')
    assert 'the CAN bus failed' in chain.diagnostics['driver_node: driver'][0]
    response = chain.ask_to_enable()
    assert not response.success
    assert 'the CAN bus failed' in response.message

    # The adapter comes back: the driver opens it by itself, and waits to be enabled.
    chain.emulator()
    count = len(chain.states)
    ros.spin_until(lambda: len(chain.states) > count + 100)
    assert chain.fresh('driver_node: driver')['state'] == 'fault'
    assert float(chain.value('emulator_node: shoulder', 'commanded current [A]')) == 0.0
    assert int(chain.value('driver_node: bus', 'bus opened again')) >= 1
    chain.enable()
    assert driver.stop(signal.SIGINT) == 0
    assert 'Traceback' not in driver.output


def test_an_elbow_without_current_has_no_effort_and_no_friction_all_the_way(chain):
    """NaN from the bridge's "not available" to joint_states to the observer, which says why."""
    ros = chain.ros
    chain.emulator('servo_current_available:=false')
    chain.start_node('observer_node', files=(PARAMETER_FILE,))
    estimates = ros.collect(JointState, 'friction_estimate', JOINT_STATES)
    chain.driver()
    # A cycle that a busy machine loses is a fresh start, which has none for a moment.
    ros.spin_until(lambda: len(estimates) > 200 and math.isfinite(estimates[-1].effort[0]))
    assert all(math.isnan(state.effort[1]) for state in chain.states)
    assert all(math.isfinite(state.effort[0]) for state in chain.states)
    assert all(math.isnan(estimate.effort[1]) for estimate in estimates)
    sentence = 'friction of this joint unavailable: its actuator reports no current'
    ros.spin_until(
        lambda: chain.diagnostics.get('observer_node: elbow', ('', {}))[0].startswith(sentence)
    )
    assert chain.fresh('driver_node: elbow')['effort'] == 'not measured'
    assert 'measures no current' in chain.diagnostics['driver_node: elbow'][0]


HANGING_CALLBACK = """
import sys, time
from sosml_friction.nodes import driver_node

driver_node.DriverNode._on_stop = lambda *_: time.sleep(3600)
sys.exit(driver_node.main(sys.argv[1:]))
"""


def test_a_callback_that_hangs_ends_in_zero_current_on_the_wire(chain, tmp_path):
    """Not by the motor's watchdog: the cycle goes on, and commands nothing."""
    ros = chain.ros
    chain.emulator()
    arguments = ['--ros-args', '--params-file', str(PARAMETER_FILE)]
    for parameter in (*PATIENT_DRIVER, f'can_channel:=socket://127.0.0.1:{chain.port}'):
        arguments += ['-p', parameter]
    log = (tmp_path / 'hanging.log').open('wb')
    driver = subprocess.Popen(
        [sys.executable, '-c', HANGING_CALLBACK, *arguments], stdout=log, stderr=log
    )
    try:
        chain.enable()
        chain.send([1.0], [HANGING + np.array([0.4, 0.4])])
        ros.spin_until(
            lambda: (
                float(chain.fresh('emulator_node: shoulder')['commanded current [A]']) > 0.5
                and chain.fresh('driver_node: driver')['trajectory running'] == 'False'
            )
        )
        stop = ros.node.create_client(Trigger, 'driver_node/stop')
        ros.spin_until(stop.service_is_ready)
        answer = stop.call_async(Trigger.Request())
        ros.spin_until(
            lambda: float(chain.fresh('emulator_node: shoulder')['commanded current [A]']) == 0.0
        )
        frames = int(chain.value('emulator_node: shoulder', 'frames'))
        ros.spin_until(
            lambda: int(chain.fresh('emulator_node: shoulder')['frames']) > frames + 500
        )
        assert float(chain.value('emulator_node: shoulder', 'commanded current [A]')) == 0.0
        assert float(chain.value('emulator_node: elbow', 'commanded current [A]')) == 0.0
        assert chain.value('emulator_node: shoulder', 'watchdog trips') == '0'
        assert not answer.done()
    finally:
        driver.kill()
        driver.wait()
        log.close()


@pytest.mark.parametrize(
    ('parameters', 'sentence'),
    [
        (['shoulder.torque_constant:=-1.0'], 'shoulder.torque_constant is -1'),
        (['shoulder.direction:=2'], 'shoulder.direction is 2'),
        (['shoulder.mode:=fast'], "shoulder.mode of driver_node is 'fast'"),
        (['shoulder.mode:=speed'], 'shoulder.position_gain is nan'),
        (['elbow.dbc_map:=[speed=Speed]'], "'speed=Speed' in dbc_map"),
        (['shoulder.driver:=servo'], "shoulder.driver of driver_node is 'servo'"),
        (['joints:=[shoulder]'], 'name the same, in the same order'),
        (['model:=/no/such/model'], 'model /no/such/model cannot be read'),
        (['can_interface:=no_such'], "CAN interface 'no_such' cannot be used"),
        (['can_bitrate:=250000'], 'lower rate or raise can_bitrate'),
        (['elbow.dbc:=/no/such.dbc'], 'the DBC /no/such.dbc cannot be read'),
        (['use_sim_time:=true'], 'hardware runs in real time'),
        ([], 'slcan on socket://127.0.0.1:1 cannot be opened'),
    ],
)
def test_a_bad_configuration_is_one_line_and_exit_code_two(refusal, parameters, sentence):
    needs_bus = ('lower rate', 'same order', 'the DBC', 'dbc_map')
    bus = (
        ['can_interface:=virtual', 'can_channel:=nobody']
        if sentence.startswith(needs_bus) or any(s in sentence for s in needs_bus)
        else ['can_channel:=socket://127.0.0.1:1']
    )
    (line,) = refusal('driver_node', *bus, *parameters, files=(PARAMETER_FILE,))
    assert sentence in line


def test_a_silent_bus_is_one_line_and_exit_code_two(start_node):
    node = start_node(
        'driver_node', 'can_interface:=virtual', 'can_channel:=nobody', files=(PARAMETER_FILE,)
    )
    assert node.wait() == 2
    (line,) = node.output.strip().splitlines()
    assert 'joint shoulder: no answer from 0x241' in line


def test_a_driver_that_starts_before_its_bus_waits_for_it(chain):
    driver = chain.driver('bus_wait:=60.0')
    chain.ros.spin_until(lambda: 'waiting 60 s for the bus' in driver.output)
    chain.emulator()
    chain.ros.spin_until(lambda: chain.states)
    assert driver.process.poll() is None


def test_a_required_parameter_that_is_missing_is_named(refusal):
    (line,) = refusal('driver_node')
    assert 'parameter joints of driver_node is not set' in line


def test_a_message_becomes_the_trajectory_it_says():
    trajectory = trajectory_from_message(message([0.25, 2.0], [[0.1, 0.2], [0.3, 0.4]]))
    assert trajectory.names == ('shoulder', 'elbow')
    np.testing.assert_allclose(trajectory.t, [0.25, 2.0])
    np.testing.assert_allclose(trajectory.q, [[0.1, 0.2], [0.3, 0.4]])
    np.testing.assert_allclose(trajectory.v, 0.0)
    assert trajectory_from_message(message([1.0], [[0.0, 0.0]], False)).v is None


@pytest.mark.parametrize('what', ['positions', 'velocities'])
def test_points_with_missing_numbers_are_refused(what):
    broken = message([1.0, 2.0], [[0.0, 0.0], [0.1, 0.1]])
    setattr(broken.points[1], what, [0.0])
    with pytest.raises(TrajectoryError, match='point 1'):
        trajectory_from_message(broken)


def test_an_empty_message_is_refused():
    for empty in (JointTrajectory(), JointTrajectory(joint_names=['shoulder', 'elbow'])):
        with pytest.raises(TrajectoryError, match='at least one point'):
            trajectory_from_message(empty)


def test_every_parameter_has_its_row_in_the_table():
    table = markdown_table(PARAMETERS)
    for spec in PARAMETERS:
        assert f'`{spec.name}`' in table
        assert spec.description
