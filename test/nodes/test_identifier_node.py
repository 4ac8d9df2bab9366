# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""identifier_node: what it refuses, how a run fails, and what a crash costs."""

from __future__ import annotations

import json
import resource
import shutil
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from jsonschema import Draft202012Validator
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.controllers import read_controllers
from sosml_friction.diagnosis.library import searched_terms
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.nodes.fresh_start import tell_start
from sosml_friction.nodes.identifier_parameters import check_change
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.one_thread import in_one_thread
from sosml_friction.report.fit.results import fit_document
from sosml_friction.share import share_directory

NAMES = ['shoulder', 'elbow']
REST = [-1.5707963267948966, 0.0]
PERIOD_NS = 2_000_000


class Robot:
    """A robot that does not move: joint_states at 500 Hz by its own stamps, and a description."""

    EVERY_S = 0.002

    def __init__(self, ros, names=tuple(NAMES), listens=True) -> None:
        self.ros, self.names = ros, list(names)
        self.sent: list[int] = []
        description = ros.node.create_publisher(String, 'robot_description', LATCHED)
        urdf = share_directory() / 'urdf' / 'exoskeleton.urdf'
        description.publish(String(data=urdf.read_text()))
        self.output = ros.node.create_publisher(JointState, 'joint_states', JOINT_STATES)
        if listens:
            ros.node.create_subscription(JointTrajectory, 'joint_trajectory', self.follow, 10)
        self._now_ns = 1_000_000_000
        self.timer = ros.node.create_timer(self.EVERY_S, self.step)

    def follow(self, message: JointTrajectory) -> None:
        """Stay."""

    def step(self) -> None:
        state = JointState(name=self.names, position=REST, velocity=[0.0, 0.0], effort=[0.1, 0.2])
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(self._now_ns, 10**9)
        self.sent.append(self._now_ns)
        self._now_ns += PERIOD_NS
        self.output.publish(state)


class MovingRobot(Robot):
    """
    A robot that goes exactly where it is told, with 0.6 and 0.3 Nm of Coulomb friction.

    Its stamps are 5 ms apart and it sends one every 1.5 ms: emulated time runs ahead.
    """

    EVERY_S = 0.0015

    def __init__(self, ros) -> None:
        self.model = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
        self.trajectory, self.begun_ns = None, 0
        self.noise = np.random.default_rng(0)
        super().__init__(ros)

    def follow(self, message: JointTrajectory) -> None:
        t = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points]
        rows = ([getattr(p, what) for p in message.points] for what in ('positions', 'velocities'))
        self.trajectory = Trajectory(tuple(message.joint_names), np.array(t), *map(np.array, rows))
        self.spline, self.begun_ns = self.trajectory.spline(), self._now_ns

    def step(self) -> None:
        q, v, a = np.array(REST), np.zeros(2), np.zeros(2)
        if self.trajectory is not None:
            t = min((self._now_ns - self.begun_ns) * 1e-9, self.trajectory.duration)
            q, v, a = (self.spline(t, k) for k in range(3))
        tau = self.model.inverse_dynamics(q, v, a) + np.sign(v) * [0.6, 0.3]
        tau += self.noise.normal(0.0, 0.02, 2)
        state = JointState(
            name=self.names, position=q.tolist(), velocity=v.tolist(), effort=tau.tolist()
        )
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(self._now_ns, 10**9)
        self.sent.append(self._now_ns)
        self._now_ns += 5_000_000
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
    return standing_bench(ros, start_node, tmp_path)


def standing_bench(ros, start_node, tmp_path, *parameters):
    """Return a standing robot, observers and identifier, and the phase."""
    robot = Robot(ros)
    tell = phase(ros)
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node('observer_node')
    identifier = start_node(
        'identifier_node',
        f'output:={tmp_path}',
        'run_name:=run',
        'centre:=[-1.57, 1.2]',
        *parameters,
    )
    ros.spin_until(lambda: configuration and tell()[0] == 'idle')
    ros.spin_until(lambda: robot.output.get_subscription_count() == 2)
    return robot, identifier, tell


def start(ros, tell) -> None:
    """Call ~/start until it agrees: its peers may not have been discovered yet."""
    answers = []

    def begun() -> bool:
        return tell()[0] in ('starting', 'moving')

    def decided() -> bool:
        answers.append(ros.call(Trigger, 'identifier_node/start', done=begun))
        early = ('does not answer', 'nothing was received')
        if answers[-1] is None or answers[-1].success:
            return True
        return not any(words in answers[-1].message for words in early)

    ros.spin_until(decided)
    assert answers[-1] is None or answers[-1].success, answers[-1].message


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
    start(ros, tell)
    again = ros.call(Trigger, 'identifier_node/start')
    assert not again.success
    ros.spin_until(lambda: tell()[0] == 'failed')
    assert 'no diagnostics come from driver_node: does it run, and is it enabled?' in tell()[1]
    log = Bag.open(tmp_path / 'run' / 'bag').joint_log()
    first = robot.sent.index(int(log.t_ns[0]))
    assert log.t_ns.tolist() == robot.sent[first : first + len(log)]
    assert not (tmp_path / 'run' / 'model').exists()


def test_a_driver_that_would_not_move_is_told_and_nothing_is_left_behind(ros, bench, tmp_path):
    _, _, tell = bench
    diagnostics = ros.node.create_publisher(DiagnosticArray, '/diagnostics', 10)

    def answer(state: str, fault: str, sentence: str):
        values = [KeyValue(key='state', value=state), KeyValue(key='fault', value=fault)]
        status = DiagnosticStatus(name='driver_node: driver', values=values)

        def told() -> bool:
            diagnostics.publish(DiagnosticArray(status=[status]))
            # Its peers may not have been discovered yet, nor the driver.
            said = ros.call(Trigger, 'identifier_node/start', done=lambda: tell()[0] == 'starting')
            assert said is not None
            if said.success:
                ros.call(Trigger, 'identifier_node/abort', done=lambda: tell()[0] == 'failed')
            return sentence in said.message

        ros.spin_until(told)

    answer('disabled', '', 'driver_node is disabled: call its ~/enable first')
    answer('fault', 'over-temperature', 'driver_node is in fault (over-temperature): end the')
    shutil.rmtree(tmp_path / 'run', ignore_errors=True)
    for state in ('disabled', 'fault'):
        answer(state, '', 'driver_node is')
    assert not (tmp_path / 'run').exists()


def test_a_bag_begins_at_the_reset_and_not_at_a_gap_before_it(ros, start_node, tmp_path):
    """
    An estimate that is not known because of a gap may come between the request and the reset.

    Here they all do, up to the reset, which starts the observers with the sample after it.
    """
    robot = Robot(ros)
    tell = phase(ros)
    output = ros.node.create_publisher(JointState, 'friction_estimate/sosml', JOINT_STATES)
    text = ros.node.create_publisher(String, 'observer_configuration', LATCHED)
    gains = {'sosml': {'observer_bandwidth': [50.0, 50.0]}}
    text.publish(String(data=ObserverConfiguration(tuple(NAMES), gains).to_yaml()))
    reset_at = []

    def reset(_, response):
        reset_at.append(len(robot.sent))
        # Some that are not known are on their way already, and stamped before the reset.
        for stamp_ns in robot.sent[-5:]:
            estimate(stamp_ns, np.nan)
        response.success, response.message = True, tell_start(robot.sent[-1])
        return response

    def estimate(stamp_ns, tau_f):
        state = JointState(name=NAMES, position=REST, velocity=[0.0, 0.0], effort=[tau_f] * 2)
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(stamp_ns, 10**9)
        output.publish(state)

    def follow():
        for k in range(len(done), len(robot.sent)):
            done.append(k)
            estimate(robot.sent[k], 0.1 if reset_at and k > reset_at[0] else np.nan)

    done = []
    ros.node.create_timer(robot.EVERY_S, follow)
    ros.node.create_service(Trigger, 'observer_node/reset', reset)
    start_node('identifier_node', f'output:={tmp_path}', 'run_name:=run', 'centre:=[-1.57, 1.2]')
    ros.spin_until(lambda: tell()[0] == 'idle')
    start(ros, tell)
    ros.spin_until(lambda: tell()[0] == 'moving')
    ros.spin_until(lambda: len(robot.sent) > reset_at[0] + 100)
    assert ros.call(Trigger, 'identifier_node/abort').success
    bag = Bag.open(tmp_path / 'run' / 'bag')
    assert int(bag.joint_log().t_ns[0]) == robot.sent[reset_at[0]]
    unknown = np.isnan(bag.joint_log('/friction_estimate/sosml').tau).all(axis=1)
    assert unknown.nonzero()[0].tolist() == [0]


def test_an_observer_that_cannot_start_afresh_fails_the_run_with_its_reason(
    ros, start_node, tmp_path
):
    robot = Robot(ros)
    tell = phase(ros)
    text = ros.node.create_publisher(String, 'observer_configuration', LATCHED)
    gains = {'sosml': {'observer_bandwidth': [50.0, 50.0]}}
    text.publish(String(data=ObserverConfiguration(tuple(NAMES), gains).to_yaml()))
    output = ros.node.create_publisher(JointState, 'friction_estimate/sosml', JOINT_STATES)
    ros.node.create_timer(robot.EVERY_S, lambda: output.publish(JointState(name=NAMES)))

    def reset(_, response):
        response.success, response.message = False, 'waiting for robot_description'
        return response

    ros.node.create_service(Trigger, 'observer_node/reset', reset)
    start_node('identifier_node', f'output:={tmp_path}', 'run_name:=run', 'centre:=[-1.57, 1.2]')
    ros.spin_until(lambda: tell()[0] == 'idle')
    start(ros, tell)
    ros.spin_until(lambda: tell()[0] == 'failed')
    assert 'did not start afresh: waiting for robot_description' in tell()[1]
    ros.spin_until(lambda: not (tmp_path / 'run').exists())


def test_a_silent_driver_fails_the_run_and_keeps_the_bag_and_standing_still_itself_does_not(
    ros, start_node, tmp_path
):
    """
    A machine that lets it wait is no driver that says nothing.

    Stopped by the clock, not until so many messages came: after some ten seconds of silence its
    peers would drop it, and to be found again takes longer than the silence it must not report.
    """
    robot, identifier, tell = standing_bench(ros, start_node, tmp_path, 'tracking_tolerance:=10.0')
    start(ros, tell)
    ros.spin_until(lambda: tell()[0] == 'moving')
    identifier.process.send_signal(signal.SIGSTOP)
    stopped = time.monotonic()
    ros.spin_until(lambda: time.monotonic() > stopped + 5.0)
    identifier.process.send_signal(signal.SIGCONT)
    # The silence that it would have taken it for, once more.
    ros.spin_until(lambda: time.monotonic() > stopped + 10.0)
    assert tell()[0] == 'moving', tell()[1]
    robot.timer.cancel()
    ros.spin_until(lambda: tell()[0] == 'failed')
    assert 'joint_states fell silent for 4 s' in tell()[1]
    assert int(Bag.open(tmp_path / 'run' / 'bag').joint_log().t_ns[-1]) == robot.sent[-1]


def test_a_parameter_that_cannot_be_used_is_refused_when_it_is_set():
    """ROS answered successful, and ~/start refused it."""
    joints = ('shoulder', 'elbow')
    for name, value, sentence in (
        ('trajectory', 'x', "trajectory is 'x': use one of"),
        ('method', 'guess', "method is 'guess': use one of"),
        ('speeds', [0.1, np.nan], 'give finite numbers'),
        ('top_speed', np.nan, 'give finite numbers'),
        ('tracking_tolerance', np.nan, 'give finite numbers'),
        ('centre', [0.0], 'has 1 values for the joints shoulder, elbow'),
        ('acceleration_limit', [1.0] * 3, 'has 3 values'),
    ):
        with pytest.raises(SosmlFrictionError, match=sentence):
            check_change(name, value, joints)
    for name, value in (('trajectory', 'multisine'), ('centre', []), ('run_name', 'a')):
        check_change(name, value, joints)


def test_what_cannot_be_used_is_answered_with_the_reason(ros, start_node, tmp_path):
    start_node('identifier_node', f'output:={tmp_path}')
    request = SetParameters.Request(
        parameters=[Parameter('trajectory', value='x').to_parameter_msg()]
    )
    result = ros.call(SetParameters, 'identifier_node/set_parameters', request).results[0]
    assert not result.successful
    assert 'use one of' in result.reason


def test_abort_closes_the_bag_and_brakes_a_robot_that_offers_no_stop(ros, bench, tmp_path):
    """A robot with another driver went on to the end of the trajectory, and "aborted" was said."""
    _, identifier, tell = bench
    sent = ros.collect(JointTrajectory, 'joint_trajectory', 10)
    start(ros, tell)
    ros.spin_until(lambda: tell()[0] == 'moving' and len(sent) == 1)
    assert 'nobody offers driver_node/stop: if the run is ended' in identifier.output
    answer = ros.call(Trigger, 'identifier_node/abort')
    assert answer.success
    assert 'nobody offers driver_node/stop: a trajectory was sent that brakes' in answer.message
    ros.spin_until(lambda: len(sent) == 2)
    positions = np.array([point.positions for point in sent[1].points])
    np.testing.assert_allclose(positions, [REST, REST], atol=1e-3)
    assert list(sent[1].points[-1].velocities) == [0.0, 0.0]
    assert not Bag.open(tmp_path / 'run' / 'bag').recovered


def test_a_disk_that_is_full_fails_the_run_and_keeps_what_is_written(ros, bench, tmp_path):
    """The program ended with a trace, in the timer that hands the bag to the system."""
    _, identifier, tell = bench
    start(ros, tell)
    ros.spin_until(lambda: tell()[0] == 'moving')
    bag = next((tmp_path / 'run' / 'bag').glob('*.mcap'))
    ros.spin_until(lambda: bag.stat().st_size > 100_000)
    room = bag.stat().st_size
    resource.prlimit(identifier.process.pid, resource.RLIMIT_FSIZE, (room, room))
    ros.spin_until(lambda: tell()[0] == 'failed')
    assert 'cannot be written' in tell()[1]
    assert len(Bag.open(tmp_path / 'run' / 'bag').joint_log()) > 10
    assert not ros.call(Trigger, 'identifier_node/abort').success


def test_a_killed_identifier_leaves_a_bag_with_all_but_the_last_half_second(ros, bench, tmp_path):
    """kill -9 while it records: what was sent up to 0.5 s before is in the bag."""
    robot, identifier, tell = bench
    start(ros, tell)
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
        (["diagnose_without:=['stiction']"], "effect 'stiction' is unknown"),
        (["diagnose_trust:=['friction']"], "'friction' says no trust: write GROUP=SHARE"),
        (["diagnose_trust:=['gears=0.1']"], "'gears' cannot be trusted: use masses"),
    ],
)
def test_a_configuration_that_cannot_work_is_refused(refusal, parameters, sentence):
    (line,) = (x for x in refusal('identifier_node', *parameters) if '[INFO]' not in x)
    assert sentence in line


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
    """
    The shoulder: 0.1 rad, 2 cycles at 0.5 Hz between ramps of 1 s; the elbow stays.

    Which trajectory it is, and one of its options, are set while the node runs.
    """
    Robot(ros)
    trajectories = ros.collect(JointTrajectory, 'joint_trajectory', 10)
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node('observer_node')
    options = ('amplitude:=0.1', 'ramp:=1.0')
    start_node(
        'identifier_node',
        f'output:={tmp_path}',
        'run_name:=run',
        'scale:=[1.0, 0.0]',
        *(f'reversal.{option}' for option in options),
    )
    ros.spin_until(lambda: configuration)
    new = {'trajectory': 'reversal', 'reversal.cycles': 2.0}
    changes = [Parameter(name, value=value).to_parameter_msg() for name, value in new.items()]
    request = SetParametersAtomically.Request(parameters=changes)
    service = 'identifier_node/set_parameters_atomically'
    assert ros.call(SetParametersAtomically, service, request).result.successful
    start(ros, phase(ros))
    ros.spin_until(lambda: trajectories)
    points = trajectories[0].points
    away = np.array([point.positions for point in points]) - REST
    assert np.abs(away[:, 0]).max() == pytest.approx(0.1, rel=0.01)
    np.testing.assert_array_equal(away[:, 1], 0.0)
    end = points[-1].time_from_start
    # The move to the centre, where the robot is already, takes 0.4 s.
    assert end.sec + 1e-9 * end.nanosec == pytest.approx(0.4 + 4.0 + 2.0)


def run_values(arrays) -> list[dict[str, str]]:
    """Return what the identifier's diagnostics said, oldest first."""
    return [
        {'message': status.message} | {item.key: item.value for item in status.values}
        for array in arrays
        for status in array.status
        if status.name == 'identifier_node: run'
    ]


def stamps_of(messages) -> list[int]:
    return [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]


def begin_short_run(ros, start_node, tmp_path, *parameters):
    """Return a robot that moves, and all diagnostics, with a short run begun."""
    robot = MovingRobot(ros)
    arrays = ros.collect(DiagnosticArray, '/diagnostics', QoSProfile(depth=1000))
    configuration = ros.collect(String, 'observer_configuration', LATCHED)
    start_node('observer_node', 'effort_hold:=[mean]')
    start_node(
        'identifier_node',
        f'output:={tmp_path}',
        'run_name:=run',
        'speeds:=[0.1, 0.4, 0.8]',
        'plateau:=0.6',
        'centre:=[-1.57, 1.2]',
        'scale:=[1.0, 0.7]',
        *parameters,
    )
    ros.spin_until(lambda: configuration and run_values(arrays))
    ros.spin_until(lambda: robot.output.get_subscription_count() == 2)
    start(ros, lambda: (run_values(arrays)[-1]['phase'], ''))
    return robot, arrays


def test_fit_and_diagnosis_are_aborted_and_begun_anew_while_the_joints_are_observed(
    ros, start_node, tmp_path
):
    """
    Nothing is written by what is aborted; what is begun anew does what the tool does.

    One run serves for all. While it is fitted each sample that is sent has its estimate, and the
    identifier still takes them. An aborted diagnosis leaves the fit. The controllers that the
    driver names are in the tags of the bag.
    """
    controller = {'shoulder': {'kind': 'actuator', 'reason': 'a test'}}
    latched = ros.node.create_publisher(String, 'controller_configuration', LATCHED)
    latched.publish(String(data=json.dumps(controller)))
    # A small catalogue, for a short test.
    without = sorted(set(searched_terms()) - {'stribeck', 'asymmetric_friction', 'gravity_tilt'})
    asked = ('diagnose:=true', f'diagnose_without:={without}', "diagnose_trust:=['masses=0.1']")
    robot, arrays = begin_short_run(ros, start_node, tmp_path, *asked)
    run = tmp_path / 'run'
    estimates = ros.collect(JointState, 'friction_estimate', JOINT_STATES)

    def last() -> dict[str, str]:
        return run_values(arrays)[-1]

    # The fit, aborted.
    ros.spin_until(lambda: last()['phase'] == 'fitting')
    answer = ros.call(Trigger, 'identifier_node/abort')
    assert answer.success, answer.message
    ros.spin_until(lambda: last()['phase'] != 'fitting')
    assert last()['phase'] == 'failed'
    assert 'aborted' in last()['message']
    assert [p.name for p in run.iterdir()] == ['bag']

    # The fit, begun anew and observed, up to its end.
    answer = ros.call(Trigger, 'identifier_node/fit')
    assert answer.success
    assert answer.message == f'fitting {run / "bag"}'
    ros.spin_until(lambda: last()['phase'] == 'fitting')
    begun, taken = len(robot.sent), int(last()['joint_states taken'])
    ros.spin_until(lambda: last()['phase'] != 'fitting')
    ended, fitted = len(robot.sent), last()
    # The fit is done and told while the diagnosis runs, which is aborted.
    assert fitted['phase'] == 'diagnosing', fitted['message']
    assert fitted['message'].endswith(f'model in {run / "model"}')
    assert not ros.call(Trigger, 'identifier_node/start').success
    answer = ros.call(Trigger, 'identifier_node/abort')
    assert answer.success, answer.message
    assert 'the fit is kept' in answer.message
    assert int(fitted['joint_states taken']) - taken > 0.5 * (ended - begun) > 10
    ros.spin_until(lambda: stamps_of(estimates[-1:]) >= robot.sent[ended - 1 : ended])
    during = [t for t in stamps_of(estimates) if robot.sent[begun] <= t <= robot.sent[ended - 1]]
    assert during == robot.sent[begun:ended]
    # Nobody looks at what it would send from here on.
    robot.timer.cancel()
    ros.spin_until(lambda: last()['phase'] == 'done')
    assert 'aborted' in last()['diagnosis']
    assert {p.name for p in run.iterdir()} == {'bag', 'model', 'parameters.yaml'}
    assert (run / 'model' / 'report.html').is_file()

    told = run_values(arrays)
    shares = [float(x['progress [%]']) for x in told if 'progress [%]' in x]
    assert shares == sorted(shares)
    assert len(set(shares)) > 2
    steps = {x['step'] for x in told if x['phase'] == 'fitting'}
    assert {'fitting', 'drawing shoulder', 'running the observers over the bag'} & steps
    assert told[-1]['trajectory'].startswith('T1, ')

    bag = Bag.open(run / 'bag')
    assert (bag.tags['trajectory'], bag.tags['trajectory_label']) == ('speed_ladder', 'T1')
    assert json.loads(bag.tags['trajectory_options'])['speeds'] == [0.1, 0.4, 0.8]
    assert read_controllers(bag) == controller
    written = json.loads((run / 'model' / 'fit.json').read_text())
    # In more threads than the node's one the last digits are others.
    analysis = in_one_thread(analyse_bag)(run / 'bag')
    offline = json.loads(json.dumps(fit_document(analysis)))
    assert written['joints'] == offline['joints']
    assert written['joints']['shoulder']['sosml']['parameters']['coulomb'][
        'value'
    ] == pytest.approx(0.6, abs=0.02)

    # Fit and diagnosis, to the end.
    assert ros.call(Trigger, 'identifier_node/fit').success
    ros.spin_until(lambda: last()['phase'] == 'fitting')
    ros.spin_until(lambda: last()['phase'] in ('done', 'failed'), patience=300.0)
    assert last()['phase'] == 'done', last()['message']
    document = json.loads((run / 'diagnosis' / 'diagnosis.json').read_text())
    schema = Path(__file__).resolve().parents[2] / 'docs/schema/diagnosis.schema.json'
    Draft202012Validator(json.loads(schema.read_text())).validate(document)
    assert last()['verdict'] == document['verdict'] != 'bad_data'
    assert last()['diagnosis'] == document['sentence']
    assert document['provenance']['bags'][0]['bag'] == 'bag'
    assert document['provenance']['trust'] == {'masses': 0.1}
    assert (run / 'diagnosis' / 'report.html').is_file()
    steps = {x['step'] for x in run_values(arrays) if x['phase'] == 'diagnosing'}
    # They are told twice a second: how many are seen of a short diagnosis is the machine's.
    assert len(steps) > 1


def test_a_run_is_refused_where_nobody_would_take_its_trajectory(ros, start_node, tmp_path):
    Robot(ros, listens=False)
    start_node('observer_node')
    start_node('identifier_node', f'output:={tmp_path}', 'run_name:=run', 'centre:=[-1.57, 1.2]')
    ros.spin_until(
        lambda: (
            ros.call(Trigger, 'identifier_node/start').message
            == 'nobody listens to joint_trajectory: start the driver'
        )
    )
    assert not (tmp_path / 'run').exists()
