# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
identifier_node: run a trajectory, record it, fit friction when it ends, and diagnose.

A run goes through the phases ``starting`` (the observers are reset and the recording begins at
their first sample, so that a replay of the bag gives the same estimates), ``moving``, ``fitting``
(in a thread: messages are still taken), with the parameter ``diagnose`` ``diagnosing`` (in the
same thread), ``done`` or ``failed``; ``/diagnostics`` has the phase, how far the motion is, what
the fit or the diagnosis is at, and what was diagnosed. Its folder holds the bag, the model folder
with ``report.html`` and ``fit.json``, as ``sosml fit`` writes them, ``parameters.yaml``, which
gives that model to any node with ``--params-file``, and ``diagnosis``, as ``sosml diagnose`` of
that bag writes it: of the model in the parameter ``model``, the one before the fit. A diagnosis
that fails leaves the fit as it is.

The bag says in its tags (rosbag2's custom data) which trajectory it is: ``trajectory`` by name,
``trajectory_label`` (T1, T2, T3) and ``trajectory_options`` as JSON; and, from the driver's topic
``controller_configuration``, which controllers ran: ``controller.<joint>`` as JSON.
"""

import contextlib
import json
import shutil
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from sosml_friction.bags.controllers import CONTROLLER_TOPIC, controller_tags, parse_controllers
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import deserialize, serialize
from sosml_friction.exceptions import ConfigurationError, SosmlFrictionError
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.motion.building_blocks import check_limits
from sosml_friction.motion.trajectories import COMMON, build_trajectory, find_kind
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.nodes.diagnostics import ERROR, OK, WARN, full_name, make_array, make_status
from sosml_friction.nodes.driver_watch import DriverWatch
from sosml_friction.nodes.fit_job import FitJob, summary
from sosml_friction.nodes.fresh_start import read_start
from sosml_friction.nodes.identification_run import IdentificationRun, stamp_ns
from sosml_friction.nodes.identifier_parameters import PARAMETERS, PLAIN, check_change
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.parameters import declare
from sosml_friction.nodes.program_node import ProgramNode
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.nodes.run import run_node
from sosml_friction.nodes.stated_model import StatedModel
from sosml_friction.nodes.trajectory_message import message_from_trajectory, trajectory_bytes
from sosml_friction.observers.configuration import parse_configuration

#: Time between two looks at what does not come as a message [s]. Chosen, no measurement.
_LOOK_S = 0.1
#: Silence of joint_states that ends a run [s]: longer than the 3 s after which DDS looks again for
#: what was lost while a machine stood still.
_SILENT_S = 4.0
#: A copy of a state that is older than the state by this is none of it [ns]. Chosen.
_OLD_NS = 50_000_000
_RUNNING = ('starting', 'moving', 'fitting', 'diagnosing')
_JOINT_STATE = 'sensor_msgs/msg/JointState'


class IdentifierNode(ProgramNode):
    """Run, record and fit; a ConfigurationError if the model or a parameter cannot be used."""

    def __init__(self) -> None:
        super().__init__('identifier_node')
        self._p = declare(self, PARAMETERS)
        self._full_name = full_name(self)
        self._stated = StatedModel(self._p)
        self._encoded_names: list[bytes] = []
        self._observed: tuple[str, ...] = ()
        self._label = find_kind(self._p['trajectory']).label
        if self._stated.model is not None and not self._stated.model.unseen:
            self._look_for(self._stated.model)
        if self._p['diagnose_without'] or self._p['diagnose_trust']:
            # Only for those who asked: the catalogue takes a second to load.
            from sosml_friction.diagnosis.library import make_library
            from sosml_friction.diagnosis.trust import parse_trust

            make_library(tuple(self._p['diagnose_without']))
            parse_trust(self._p['diagnose_trust'])
        self._phase = 'idle'
        self._message = 'call ~/start to run the trajectory'
        self._robot: Robot | None = None
        self._observers: list[str] = []
        self._latched: dict[str, bytes] = {}
        self._controllers: dict[str, dict[str, Any]] = {}
        self._last_state: bytes | None = None
        # The observers' copy of it, in which no position wraps.
        self._last_estimate: bytes | None = None
        # Looks since the last of joint_states: a node that stands still hears nothing either.
        self._silent_looks = 0
        self._run: IdentificationRun | None = None
        self._phase_since = time.monotonic()
        self._job: FitJob | None = None
        self._fitted = ''
        self._diagnosed: dict[str, str] = {}
        self._states = 0
        self._trajectory_output = self.create_publisher(JointTrajectory, 'joint_trajectory', 10)
        self._result_output = self.create_publisher(String, 'friction_parameters', LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._reset_client = self.create_client(Trigger, f'{self._p["observer_node"]}/reset')
        self._stop_client = self.create_client(Trigger, f'{self._p["driver_node"]}/stop')
        self.create_service(Trigger, '~/start', partial(_answer, self._on_start))
        self.create_service(Trigger, '~/abort', partial(_answer, self._on_abort))
        self.create_service(Trigger, '~/fit', partial(_answer, self._on_fit))
        stop = self.resolve_service_name(f'{self._p["driver_node"]}/stop', only_expand=True)
        self._driver = DriverWatch(stop.removesuffix('/stop'))
        self.create_subscription(DiagnosticArray, '/diagnostics', self._driver.take, 10)
        self._stamped = {'joint_states', 'friction_estimate'}
        self._subscribed: set[str] = set()
        self._subscribe('joint_states', JointState, JOINT_STATES)
        self._subscribe('joint_temperatures', Temperature, JOINT_STATES)
        self._subscribe('friction_estimate', JointState, JOINT_STATES)
        for topic in ('robot_description', 'observer_configuration', CONTROLLER_TOPIC):
            self.create_subscription(
                String, topic, partial(self._on_latched, topic), LATCHED, raw=True
            )
        self.add_on_set_parameters_callback(self._on_parameters)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_LOOK_S, self._watch, clock=steady)
        self.create_timer(0.5, self._diagnose, clock=steady)

    def destroy_node(self) -> None:
        """Stop a moving robot, close the bag, give up a running fit, destroy the node."""
        if self._phase == 'moving':
            self.get_logger().info(self._stop())
            time.sleep(0.2)  # for the request to leave before the context closes
        if self._run is not None:
            # The run has failed of it already.
            with contextlib.suppress(SosmlFrictionError):
                self._run.recorder.close()
        if self._job is not None:
            self._job.give_up()
            self._job.join()
        super().destroy_node()

    def _look_for(self, model: RobotModelFile) -> None:
        names = model.joint_names
        check_change('centre', self._p['centre'], names)
        self.get_logger().info(f'model {self._stated.label}: joints {", ".join(names)}')
        self._encoded_names = [name.encode() + b'\0' for name in names]

    # Messages -----------------------------------------------------------------------------------

    def _subscribe(self, topic: str, kind: type, qos: Any) -> None:
        # One argument: with two, which would bring the time of publication, the EventsExecutor of
        # rclpy 7.1.6 ends in a SystemError on serialised messages.
        callback = partial(self._on_message, topic)
        self.create_subscription(kind, topic, callback, qos, raw=True)

    def _on_latched(self, topic: str, data: bytes) -> None:
        try:
            self._read_latched(topic, data)
        except SosmlFrictionError as error:
            self.end(error)

    def _read_latched(self, topic: str, data: bytes) -> None:
        text = deserialize(data, 'std_msgs/msg/String').data
        if topic == 'robot_description':
            if topic not in self._latched:
                self._latched[topic] = data
                self._make_robot()
            elif data != self._latched[topic]:
                self.get_logger().warning('another robot_description is ignored: restart for it')
            return
        if topic == CONTROLLER_TOPIC:
            try:
                self._controllers = parse_controllers(text, f'the topic {topic}')
            except SosmlFrictionError as error:
                self.get_logger().warning(f'the bag will not have the controllers: {error}')
            return
        configuration = parse_configuration(text, 'the topic observer_configuration')
        self._latched[topic] = data
        self._observed = configuration.joints
        self._make_robot()
        self._observers = list(configuration.gains)
        topics = {f'friction_estimate/{observer}' for observer in self._observers}
        for new in sorted(topics - self._subscribed):
            self._subscribe(new, JointState, JOINT_STATES)
        self._subscribed |= topics
        self._stamped = {'joint_states', 'friction_estimate'} | topics
        if self._phase in ('starting', 'moving'):
            self._fail(
                'the observers have another configuration since the run began (started anew, or '
                'their gap followed the rate of joint_states): start it again; set parameter '
                'maximum_gap of the observers if it is the gap'
            )

    def _make_robot(self) -> None:
        """Make the robot once all that it needs is known."""
        if self._robot is not None or 'robot_description' not in self._latched:
            return
        urdf = deserialize(self._latched['robot_description'], 'std_msgs/msg/String').data
        if self._stated.model is None:
            if not self._stated.joints and not self._observed:
                return
            # Those that the observers found in joint_states.
            self._look_for(self._stated.make(urdf, self._observed))
        elif self._stated.model.unseen:
            if not self._observed:
                return
            self._stated.model = self._stated.model.of_measured(self._observed)
            self._look_for(self._stated.model)
        self._robot = self._stated.robot(urdf)
        for sentence in self._robot.remarks:
            self.get_logger().warning(sentence)

    def _on_message(self, topic: str, data: bytes) -> None:
        now_ns = self.get_clock().now().nanoseconds
        if topic == 'joint_states':
            # Another robot part may share the topic; looking for the names spares the decoding.
            names = self._encoded_names
            if not names or not all(name in data for name in names):
                return
            self._last_state = data
            self._silent_looks = 0
            self._states += 1
        run = self._run
        if run is None:
            return
        if self._phase == 'starting':
            run.pending.append((topic, data, now_ns))
            if topic == f'friction_estimate/{self._observers[0]}':
                self._look_for_beginning(run, data)
        elif self._phase == 'moving':
            if topic == f'friction_estimate/{self._observers[0]}':
                self._last_estimate = data
            if topic == 'joint_states' and not run.is_heard:
                has_it = self._trajectory_output.wait_for_all_acked(Duration())
                has_it = has_it or self._driver.follows(self._full_name)
                run.hear(stamp_ns(data), now_ns, has_it)
            self._record(run, topic, data, now_ns)
            self._look_for_end(run, topic, data)

    def _record(self, run: IdentificationRun, topic: str, data: bytes, log_ns: int) -> None:
        # The bag has the same stamps on all its topics: each sample with its estimates.
        if topic in self._stamped and not run.begin_ns <= stamp_ns(data) <= run.end_ns:
            return
        try:
            run.recorder.write(self.resolve_topic_name(topic), data, log_ns)
        except SosmlFrictionError as error:
            self._fail(str(error))

    # A run --------------------------------------------------------------------------------------

    def _on_start(self) -> tuple[bool, str]:
        try:
            run = self._start()
        except SosmlFrictionError as error:
            self.get_logger().error(f'not started: {error}')
            return False, str(error)
        text = f'{self._label}, {run.trajectory.duration:.1f} s, recording to {run.folder}'
        self.get_logger().info(text)
        if lacks := self._lacks_stop():
            lacks += ': if the run is ended, a trajectory will be sent that brakes and holds'
            self.get_logger().warning(lacks)
            text = f'{text}; {lacks}'
        return True, text

    def _on_parameters(self, changes: list[Parameter]) -> SetParametersResult:
        joints = () if self._robot is None else self._robot.names
        try:
            for change in changes:
                check_change(change.name, change.value, joints)
        except SosmlFrictionError as error:
            return SetParametersResult(reason=str(error))
        return SetParametersResult(successful=True)

    def _read_again(self) -> None:
        """Take what was set meanwhile."""
        self._p |= declare(self, [spec for spec in PARAMETERS if not spec.read_only])

    def _start(self) -> IdentificationRun:
        if self._phase in _RUNNING:
            raise ConfigurationError(f'a run is {self._phase}: wait for its end or call ~/abort')
        is_described = 'robot_description' in self._latched
        if not is_described or (self._robot is not None and self._last_state is None):
            missing = 'joint_states' if is_described else 'robot_description'
            raise ConfigurationError(f'nothing was received on {missing}: start the driver')
        if not self._observers or not self._reset_client.service_is_ready():
            raise ConfigurationError(
                f'{self._p["observer_node"]} does not answer: start it, or name it in parameter '
                'observer_node'
            )
        if refusal := self._driver.refusal(self._full_name):
            raise ConfigurationError(refusal)
        if not self._trajectory_output.get_subscription_count():
            raise ConfigurationError('nobody listens to joint_trajectory: start the driver')
        assert self._robot is not None
        assert self._last_state is not None
        # As they are by now.
        self._read_again()
        check_change('centre', self._p['centre'], self._robot.names)
        state = deserialize(self._last_state, _JOINT_STATE)
        trajectory, tags = self._plan(self._robot, state)
        name = self._p['run_name'] or datetime.now(timezone.utc).strftime('%Y%m%d_%H%M%S')
        folder = Path(self._p['output']) / name
        recorder = self._open_bag(folder / 'bag', tags)
        self._enter('starting', 'waiting for the observers to start afresh')
        reset = self._reset_client.call_async(Trigger.Request())
        run = self._run = IdentificationRun(folder, trajectory, recorder, reset)
        return run

    def _open_bag(self, folder: Path, tags: Mapping[str, str]) -> BagRecorder:
        assert self._stated.model is not None
        assert self._robot is not None
        recorder = BagRecorder(folder, {**tags, **controller_tags(self._controllers)})
        kinds = {
            'joint_states': _JOINT_STATE,
            'joint_temperatures': 'sensor_msgs/msg/Temperature',
            'joint_trajectory': 'trajectory_msgs/msg/JointTrajectory',
            'friction_estimate': _JOINT_STATE,
        }
        kinds |= {f'friction_estimate/{observer}': _JOINT_STATE for observer in self._observers}
        for topic, kind in kinds.items():
            recorder.add_topic(self.resolve_topic_name(topic), kind)
        # The one that the model's robot is made of.
        urdf, own = self._latched['robot_description'], self._robot.document
        if own != deserialize(urdf, 'std_msgs/msg/String').data:
            urdf = serialize(String(data=own))
        texts = {
            **self._latched,
            'robot_description': urdf,
            'model_description': serialize(String(data=self._stated.model.to_yaml())),
        }
        now_ns = self.get_clock().now().nanoseconds
        for topic, data in texts.items():
            recorder.add_topic(self.resolve_topic_name(topic), 'std_msgs/msg/String', latched=True)
            recorder.write(self.resolve_topic_name(topic), data, now_ns)
        return recorder

    def _plan(self, robot: Robot, state: JointState) -> tuple[Trajectory, dict[str, str]]:
        """Return the trajectory from where the robot is, and what the bag says of it."""
        position = dict(zip(state.name, state.position, strict=False))
        names = robot.names
        missing = [name for name in names if not np.isfinite(position.get(name, np.nan))]
        if missing:
            raise ConfigurationError(
                f'joint_states has no position for {", ".join(missing)} of the model: name its '
                f'joints alike ({", ".join(state.name)})'
            )
        start = {name: float(position[name]) for name in names}
        centre = dict(zip(names, self._p['centre'] or start.values(), strict=True))
        kind = find_kind(self._p['trajectory'])
        self._label = kind.label
        prefix = '' if kind.name == PLAIN else f'{kind.name}.'
        values = {option.name: self._p[prefix + option.name] for option in kind.options}
        values |= {option.name: self._p[option.name] for option in COMMON}
        trajectory = build_trajectory(kind.name, start, centre, values)
        check_limits(trajectory, robot, self._p['effort_margin'], self._p['acceleration_limit'])
        options = values | {'start': start, 'centre': centre}
        return trajectory, {
            'trajectory': kind.name,
            'trajectory_label': kind.label,
            'trajectory_options': json.dumps(options),
        }

    def _look_for_beginning(self, run: IdentificationRun, data: bytes) -> None:
        if not np.isfinite(deserialize(data, _JOINT_STATE).effort).any():
            run.unknown_ns.append(stamp_ns(data))
        answer = run.reset.result() if run.reset.done() else None
        if answer is None:
            return
        if not answer.success:
            self._fail(f'{self._p["observer_node"]} did not start afresh: {answer.message}')
            return
        before_ns = read_start(answer.message)
        starts = [t for t in run.unknown_ns if before_ns is None or t > before_ns]
        if not starts:
            return
        run.begin_ns = starts[0]
        run.sent_ns = run.heard_ns = stamp_ns(data)
        self._enter('moving', f'running {self._label}')
        pending, run.pending = run.pending, []
        for topic, message, log_ns in pending:
            self._record(run, topic, message, log_ns)
        if self._phase != 'moving':
            return  # the disk refused: nothing may move unrecorded
        trajectory = message_from_trajectory(run.trajectory)
        # So that the driver knows who commands it, whoever else publishes there.
        trajectory.header.frame_id = self._full_name
        self._trajectory_output.publish(trajectory)
        now_ns = self.get_clock().now().nanoseconds
        self._record(run, 'joint_trajectory', trajectory_bytes(trajectory), now_ns)

    def _look_for_end(self, run: IdentificationRun, topic: str, data: bytes) -> None:
        if topic not in self._stamped or stamp_ns(data) <= run.end_ns:
            return
        run.past_end.add(topic)
        # Estimates come after their sample, but an observer that died is not waited for.
        overdue = topic == 'joint_states' and stamp_ns(data) > run.end_ns + 1_000_000_000
        if overdue or self._stamped <= run.past_end:
            self._finish(run)

    def _watch(self) -> None:
        """Look after what does not come as a message: time-outs, the worker's end, the disk."""
        waited = time.monotonic() - self._phase_since
        if self._run is None:
            return
        if self._phase == 'starting' and waited > 10.0:
            self._fail(
                f'{self._p["observer_node"]} did not start afresh within 10 s: is it getting '
                'joint_states?'
            )
        elif self._phase == 'moving':
            try:
                self._run.recorder.flush()
            except SosmlFrictionError as error:
                self._fail(str(error))
                return
            self._silent_looks += 1
            if self._silent_looks * _LOOK_S > _SILENT_S:
                self._fail(
                    f'joint_states fell silent for {_SILENT_S:g} s: see the diagnostics of the '
                    'driver'
                )
            elif self._run.is_heard and self._last_estimate is not None:
                self._check_tracking(self._run, self._last_estimate)
        elif self._phase in ('fitting', 'diagnosing') and self._job is not None:
            self._attend(self._run, self._job)

    def _check_tracking(self, run: IdentificationRun, data: bytes) -> None:
        if off := run.off_track(deserialize(data, _JOINT_STATE), self._p['tracking_tolerance']):
            self._fail(
                f'joint {off[0]} is {off[1]:.2g} away from the trajectory '
                f'{run.elapsed(stamp_ns(data)):.1f} s into it; {self._driver.said}'
            )

    def _finish(self, run: IdentificationRun) -> None:
        try:
            run.recorder.close()
        except SosmlFrictionError as error:
            self._fail(str(error))
            return
        self.get_logger().info(f'{run.recorder.message_count} messages in {run.folder / "bag"}')
        self._begin_fit(run)

    def _begin_fit(self, run: IdentificationRun) -> None:
        self._diagnosed = {}
        self._job = FitJob(
            run.folder,
            FitSettings(method=self._p['method']),
            self._p['diagnose'],
            self._p['diagnose_without'],
            self._p['diagnose_trust'],
        )
        self._enter('fitting', 'running the observers over the bag and fitting')

    def _attend(self, run: IdentificationRun, job: FitJob) -> None:
        """Go on as far as the worker is."""
        ended = not job.running
        if ended:
            self._job = None
        if self._phase == 'fitting' and (ended or isinstance(job.outcome, BagAnalysis)):
            if not isinstance(job.outcome, BagAnalysis):
                self._fail(f'the fit failed: {job.outcome}')
                if job.outcome is not None and not isinstance(job.outcome, SosmlFrictionError):
                    self.end(job.outcome)
                return
            self._result_output.publish(String(data=job.outcome.model.to_yaml()))
            self._fitted = f'{summary(job.outcome)}; model in {run.folder / "model"}'
            if not ended and self._p['diagnose']:
                self._enter('diagnosing', self._fitted)
        if ended:
            self._conclude(run, job)

    def _conclude(self, run: IdentificationRun, job: FitJob) -> None:
        found = job.diagnosis
        if isinstance(found, Exception):
            # The fit is done and stays; what failed is told as it is.
            text = str(found) if isinstance(found, SosmlFrictionError) else repr(found)
            self._diagnosed = {'verdict': 'none', 'diagnosis': f'the diagnosis failed: {text}'}
            self.get_logger().error(self._diagnosed['diagnosis'])
        elif found is not None:
            self._diagnosed = {'verdict': found.verdict, 'diagnosis': found.sentence}
            self.get_logger().info(f'diagnosis: {found.sentence}')
            self._fitted += f'; diagnosis ({found.verdict}) in {run.folder / "diagnosis"}'
        self._enter('done', self._fitted)

    def _on_fit(self) -> tuple[bool, str]:
        if self._phase in _RUNNING:
            return False, f'a run is {self._phase}'
        if self._run is None:
            return False, 'nothing is recorded yet: call ~/start'
        self._read_again()
        self._begin_fit(self._run)
        return True, f'fitting {self._run.folder / "bag"}'

    def _on_abort(self) -> tuple[bool, str]:
        if self._phase in ('fitting', 'diagnosing') and self._job is not None:
            self._job.give_up()
            kept = '; the fit is kept' if self._phase == 'diagnosing' else ''
            return True, f'ends after {self._job.step}{kept}'
        if self._run is None or self._phase not in ('starting', 'moving'):
            return False, f'nothing to abort: {self._phase}'
        folder = self._run.folder
        self._fail('aborted')
        kept = (
            'nothing had moved yet' if self._run is None else f'what was recorded is in {folder}'
        )
        return True, f'{self._message}; {kept}'

    def _lacks_stop(self) -> str:
        """Return that nobody offers to stop the robot, '' where somebody does."""
        if self._stop_client.service_is_ready():
            return ''
        return f'nobody offers {self._p["driver_node"]}/stop'

    def _stop(self) -> str:
        """End a motion by the driver or, where it offers no stop, by a trajectory; say how."""
        lacks = self._lacks_stop()
        if not lacks:
            self._stop_client.call_async(Trigger.Request())
            return f'{self._p["driver_node"]} is asked to stop'
        assert self._run is not None
        assert self._robot is not None
        assert self._last_state is not None
        data = self._last_state
        # In the observers' copy no position wraps; where they died it is old.
        copy = self._last_estimate
        if copy is not None and stamp_ns(data) - stamp_ns(copy) < _OLD_NS:
            data = copy
        brake = self._run.brake(deserialize(data, _JOINT_STATE), self._robot)
        message = message_from_trajectory(brake)
        message.header.frame_id = self._full_name
        self._trajectory_output.publish(message)
        return (
            f'{lacks}: a trajectory was sent that brakes within {brake.duration:.2g} s and holds; '
            'see that the robot follows it'
        )

    def _fail(self, sentence: str) -> None:
        before = self._phase
        if before == 'moving':
            sentence = f'{sentence}; {self._stop()}'
        self._enter('failed', sentence)
        if self._run is not None:
            self._run.pending.clear()
            try:
                self._run.recorder.close()
            except SosmlFrictionError as error:
                self.get_logger().error(str(error))
            if before == 'starting':
                # Nothing has moved: its bag has no sample.
                shutil.rmtree(self._run.folder / 'bag', ignore_errors=True)
                with contextlib.suppress(OSError):
                    self._run.folder.rmdir()
                self._run = None

    def _enter(self, phase: str, message: str) -> None:
        self._phase, self._message, self._phase_since = phase, message, time.monotonic()
        # Two calls: rclpy ties a severity to the line that logs.
        if phase == 'failed':
            self.get_logger().error(f'{phase}: {message}')
        else:
            self.get_logger().info(f'{phase}: {message}')
        self._diagnose()

    def _diagnose(self) -> None:
        values: dict[str, Any] = {'phase': self._phase, 'joint_states taken': self._states}
        run = self._run
        if run is not None:
            values['run'] = str(run.folder)
            values['trajectory'] = f'{self._label}, {run.trajectory.duration:.1f} s'
            values['messages recorded'] = run.recorder.message_count
            if self._phase == 'moving' and self._last_state is not None:
                share = run.progress(stamp_ns(self._last_state))
                values['progress [%]'] = round(100.0 * share, 1)
        if self._job is not None:
            values['step'] = self._job.step
        values |= self._diagnosed
        level = OK
        if self._phase == 'failed':
            level = ERROR
        elif self._diagnosed.get('verdict') in ('none', 'bad_data'):
            level = WARN
        status = make_status(f'{self._full_name}: run', level, self._message, values)
        self._diagnostics.publish(make_array(self.get_clock().now().to_msg(), [status]))


def _answer(
    act: Callable[[], tuple[bool, str]], _: Trigger.Request, response: Trigger.Response
) -> Trigger.Response:
    response.success, response.message = act()
    return response


HELP = NodeHelp(
    'identifier_node',
    'Runs an identification trajectory (~/start), records it, and fits friction when it ends: '
    'bag, model folder, report.html and fit.json in one folder for each run; with diagnose:=true '
    'it then says what the model it was started with gets wrong. ~/abort stops a run, a fit or a '
    'diagnosis, ~/fit fits the last recording again.',
    '--ros-args -p trajectory:=slow_ladder -p centre:=[-1.57,1.2]',
    PARAMETERS,
)


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit code."""
    return run_node(IdentifierNode, args, HELP)


if __name__ == '__main__':
    sys.exit(main())
