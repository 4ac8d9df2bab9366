# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Drive and measure the joints over CAN: the lifecycle node around :class:`JointDriver`."""

import json
import math
import sys
import time
from array import array
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import can
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.srv import ChangeState
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.time import Time
from sensor_msgs.msg import JointState, Temperature
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.actuators.driver.configuration import DriverConfiguration, controller_entries
from sosml_friction.actuators.driver.cycle_thread import CycleThread
from sosml_friction.actuators.driver.driver import JointDriver
from sosml_friction.actuators.driver.joint_sample import JointSample
from sosml_friction.actuators.driver.real_time import take_real_time
from sosml_friction.actuators.driver.report import DriverReport, DriverState
from sosml_friction.actuators.driver.sample_relay import SampleRelay
from sosml_friction.actuators.parameter import parameters_of
from sosml_friction.bags.controllers import CONTROLLER_TOPIC
from sosml_friction.exceptions import (
    ActuatorError,
    ConfigurationError,
    SosmlFrictionError,
    TrajectoryError,
)
from sosml_friction.model.model_folder import read_model
from sosml_friction.nodes.actuator_parameters import all_joint_specs, declare_joints, specs_of
from sosml_friction.nodes.commander import Commander, Endpoint, callers, publishers
from sosml_friction.nodes.diagnostics import ERROR, OK, WARN, full_name, make_array, make_status
from sosml_friction.nodes.driver_diagnostics import bus_values, cycle_values, joint_status
from sosml_friction.nodes.driver_watch import FOLLOWING
from sosml_friction.nodes.follow_action import GOALS, FollowAction
from sosml_friction.nodes.node_help import NodeHelp
from sosml_friction.nodes.pace import Pace
from sosml_friction.nodes.parameters import ParameterSpec, declare
from sosml_friction.nodes.qos import JOINT_STATES, LATCHED
from sosml_friction.nodes.run import run_node, stop_requested
from sosml_friction.nodes.stamps import StampConverter
from sosml_friction.nodes.trajectory_message import trajectory_from_message
from sosml_friction.share import share_directory

_OWN_PARAMETERS = (
    ParameterSpec(
        'joints', 'string_array', None, 'the joints to drive, in the order of the model'
    ),
    ParameterSpec(
        'model', 'string', '', 'the nominal model folder; empty: config/exoskeleton of the package'
    ),
    ParameterSpec(
        'can_interface',
        'string',
        None,
        'a python-can interface: socketcan, slcan, virtual, udp_multicast, pcan, ...',
    ),
    ParameterSpec(
        'can_channel',
        'string',
        None,
        'its channel: can0, /dev/ttyACM0, socket://127.0.0.1:29536, ...',
    ),
    ParameterSpec(
        'bus_wait',
        'double',
        0.0,
        'how long to wait for a bus that cannot be opened yet, as of an emulator that starts '
        'beside the driver',
        's',
        (0.0, 3600.0),
    ),
    ParameterSpec(
        'commander_timeout',
        'double',
        5.0,
        'silence after its last command and motion that ends the hold of a commander; nobody '
        'else is obeyed before',
        's',
        (0.0, 3600.0),
    ),
    *specs_of(parameters_of(DriverConfiguration)),
    ParameterSpec(
        'realtime_priority',
        'integer',
        50,
        'SCHED_FIFO priority of the thread of the cycle, with the memory of this process locked, '
        'where it is permitted; 0: as any other program',
        range=(0.0, 99.0),
    ),
    ParameterSpec('autostart', 'bool', True, 'configure and activate without being told to'),
)
PARAMETERS = (*_OWN_PARAMETERS, *all_joint_specs())

# How often a bus is tried that cannot be opened yet [s].
BUS_PERIOD = 0.2
# How often the node says that its callbacks run [s].
HEARTBEAT_PERIOD = 0.05
# A cycle takes as long as opening a serial adapter again, 2 s, not much longer [ns].
HANG_NS = 5_000_000_000


class DriverNode(LifecycleNode):
    """
    Publish ``joint_states`` from CAN actuators and execute ``joint_trajectory``.

    ``configure`` opens the bus and asks every actuator who it is; ``activate`` starts the cycle,
    which measures and commands no torque; ``~/enable`` alone lets a joint be driven. Deactivation,
    shutdown, an error and the end of the process switch the outputs off.

    Stamps are when joints were asked; effort comes from measured current, is the mean since the
    sample before, and NaN where there is none; velocity is the slope of the last positions, see
    :class:`WindowedSlope`.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('driver_node', **kwargs)
        autostart = [spec for spec in _OWN_PARAMETERS if spec.name == 'autostart']
        self._autostart = bool(declare(self, autostart)['autostart'])
        self._starting = False
        self._failure: Exception | None = None
        self._bus: can.BusABC | None = None
        self._driver: JointDriver | None = None
        self._thread: CycleThread | None = None
        self._relay: SampleRelay | None = None
        self._hangs = False
        self._priority = 0
        self._channel = ''
        self._listener: Callable[[JointState], None] | None = None
        #: The URDF that is published as robot_description, '' before the configuration.
        self.description = ''
        self._refused_trajectory = ''
        self._commander = Commander(0.0)
        self._action: FollowAction | None = None
        #: Counts motions that were begun or ended by a command.
        self.commands = 0
        self._refused_commands: list[str] = []
        self._pace = Pace()
        self._reported_fault = ''
        self._ended = ''
        self._stamps: StampConverter | None = None
        self._entities: list[tuple[Any, Any]] = []
        # rclpy raises out of the callback where a transition does not fit, which ends the program.
        self._transit = self._service_change_state.callback
        self._service_change_state.callback = self._on_change_state

    def _on_change_state(
        self, request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response:
        """Answer a request; one that does not fit the state fails, as it does in C++."""
        _, state = self._state_machine.current_state
        fits = {ident: label for ident, label, *_ in self._state_machine.available_transitions}
        if request.transition.label or request.transition.id in fits:
            return self._transit(request, response)
        self.get_logger().warning(
            f'transition {request.transition.id} does not fit the state {state}: ask for one of '
            f'{", ".join(f"{label} ({ident})" for ident, label in fits.items()) or "none"}'
        )
        response.success = False
        return response

    def autostart(self) -> None:
        """
        Configure and activate if the parameter ``autostart`` says so.

        :raises SosmlFrictionError: why the configuration failed.
        """
        if not self._autostart:
            return
        self._starting = True
        try:
            configured = self.trigger_configure() == TransitionCallbackReturn.SUCCESS
            if not configured or self.trigger_activate() != TransitionCallbackReturn.SUCCESS:
                raise self._failure or ConfigurationError('the driver cannot be started')
        finally:
            self._starting = False

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters, open the bus, ask the actuators."""
        try:
            self._configure()
        except SosmlFrictionError as error:
            self._release()
            return self._refuse(error)
        except Exception as error:  # rclpy would swallow it
            self._failure = error
            self.get_logger().fatal(f'configuration failed by a defect: {error!r}')
            raise
        self._failure = None
        return super().on_configure(state)

    def _refuse(self, error: SosmlFrictionError) -> TransitionCallbackReturn:
        self._failure = error
        # At autostart the program's one line on stderr says it.
        if not self._starting:
            self.get_logger().error(str(error))
        return TransitionCallbackReturn.FAILURE

    def _configure(self) -> None:
        self._refuse_after_hang()
        values = declare(self, _OWN_PARAMETERS)
        if self.get_parameter('use_sim_time').value:
            raise ConfigurationError(
                'use_sim_time is set for driver_node: hardware runs in real time, unset it'
            )
        values |= declare_joints(self, values['joints'])
        model_path = Path(values['model'] or share_directory() / 'config' / 'exoskeleton')
        model = read_model(model_path)
        configuration = DriverConfiguration.from_parameters(values)
        robot = model.make_robot()
        self._priority = int(values['realtime_priority'])
        self._channel = f'{values["can_interface"]} {values["can_channel"]}'
        self._commander = Commander(values['commander_timeout'])

        def open_again() -> can.BusABC:
            return open_bus(values['can_interface'], values['can_channel'], configuration.bitrate)

        self._bus = self._await_bus(open_again, values['bus_wait'])
        clock = Clock()
        self._driver = JointDriver(configuration, robot, self._bus, clock, open_again)
        self._driver.configure()
        self._cycle_clock = clock
        controllers = json.dumps(controller_entries(configuration, robot.limits))
        self._create_entities(configuration, str(model.urdf), controllers)
        logger = self.get_logger()
        logger.info(f'model {model_path}, bus {self._channel}')
        logger.info(f'bus load: {self._driver.bus_load()}')
        self._tell_checks(self._driver)

    def _await_bus(self, open_it: Callable[[], can.BusABC], wait: float) -> can.BusABC:
        end = time.monotonic() + wait
        while True:
            try:
                return open_it()
            except ActuatorError as error:
                if time.monotonic() >= end or stop_requested() or not self.context.ok():
                    raise
                self.get_logger().info(f'waiting {wait:g} s for the bus: {error}', once=True)
            time.sleep(BUS_PERIOD)

    def _refuse_after_hang(self) -> None:
        """Never give a bus a second owner: the thread that hung in it may still come back."""
        if self._hangs:
            raise ConfigurationError(
                'a call into the CAN driver did not return, so the bus still has its owner: '
                "switch the actuators' power off and start this program anew"
            )

    def _tell_checks(self, driver: JointDriver) -> None:
        logger = self.get_logger()
        for check in driver.checks:
            logger.info(f'{check.joint}: {check.step}: {check.result}')
            if check.warning:
                logger.warning(check.warning)

    def _create_entities(
        self, configuration: DriverConfiguration, urdf: str, controllers: str
    ) -> None:
        def make(kind: str, *what: Any) -> Any:
            entity = getattr(self, f'create_{kind}')(*what)
            self._entities.append((getattr(self, f'destroy_{kind}'), entity))
            return entity

        self._joint_states = make('lifecycle_publisher', JointState, 'joint_states', JOINT_STATES)
        self._temperatures = make('lifecycle_publisher', Temperature, 'joint_temperatures', 10)
        description = make('publisher', String, 'robot_description', LATCHED)
        controller = make('publisher', String, CONTROLLER_TOPIC, LATCHED)
        self._diagnostics = make('publisher', DiagnosticArray, '/diagnostics', 10)
        make('service', SetBool, '~/enable', self._on_enable)
        make('service', Trigger, '~/stop', self._on_stop)
        make('subscription', JointTrajectoryMessage, 'joint_trajectory', self._on_trajectory, 10)
        make('timer', 1.0, self._on_timer)
        make('timer', HEARTBEAT_PERIOD, self._on_heartbeat)
        self._action = FollowAction.offer(self)
        self._message = JointState(name=list(configuration.names))
        self.description = urdf
        description.publish(String(data=urdf))
        controller.publish(String(data=controllers))

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start the cycle: measuring, no torque."""
        result = super().on_activate(state)
        if self._driver is None:
            return TransitionCallbackReturn.FAILURE
        try:
            self._refuse_after_hang()
            if self._driver.state is DriverState.UNCONFIGURED:
                # A deactivation shut the actuators down: ask them again.
                self._driver.configure()
                self._tell_checks(self._driver)
        except SosmlFrictionError as error:
            super().on_deactivate(state)
            return self._refuse(error)
        self._stamps = StampConverter(
            self._cycle_clock.now_ns, lambda: int(self.get_clock().now().nanoseconds)
        )
        self._ended = ''
        driver = self._driver
        self._relay = SampleRelay(
            self._publish, driver.fault, max(2, round(driver.configuration.rate))
        )
        self._thread = CycleThread(driver, self._cycle_clock, self._relay.put)
        self._relay.start()
        driver.heartbeat()
        self._thread.start()
        if refused := take_real_time(self._thread.native_id or 0, self._priority):
            self.get_logger().info(refused)
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop the cycle and switch the outputs off."""
        self._stop_thread()
        self._commander.release()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close the bus."""
        self._release()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Switch the outputs off and close the bus."""
        self._release()
        return super().on_shutdown(state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Switch the outputs off and close the bus."""
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def destroy_node(self) -> None:
        """Switch the outputs off and close the bus."""
        self._release()
        super().destroy_node()

    def _stop_thread(self) -> None:
        if self._thread is not None:
            self._hangs = not self._thread.stop()
            if self._hangs:
                self.get_logger().fatal(
                    'a call into the CAN driver does not return: the outputs are not known to be '
                    "off, only the actuators' own watchdogs are left: switch the power off"
                )
            self._thread = None
        if self._relay is not None:
            if not self._relay.stop():
                self.get_logger().error('the publisher of joint_states hangs and is left behind')
            self._relay = None

    def _release(self) -> None:
        self._stop_thread()
        if self._driver is not None:
            # It may have opened it anew.
            self._bus = self._driver.bus
        self._driver = None
        if self._hangs:
            # Closing it could hang as well, and this process is to end.
            self._bus = None
        if self._bus is not None:
            bus, self._bus = self._bus, None
            try:
                bus.shutdown()
            except (can.CanError, OSError) as error:
                self.get_logger().warning(f'the CAN bus did not close: {error}')
        if self._action is not None:
            self._action.destroy()
            self._action = None
        for destroy, entity in self._entities:
            destroy(entity)
        self._entities = []

    def _publish(self, sample: JointSample) -> None:
        """Publish one sample; runs in the relay's thread."""
        assert self._stamps is not None
        message = self._message
        message.header.stamp = Time(nanoseconds=self._stamps.to_ros_ns(sample.stamp_ns)).to_msg()
        message.position = array('d', sample.q)
        message.velocity = array('d', sample.v)
        message.effort = array('d', sample.tau)
        self._joint_states.publish(message)
        if self._listener is not None:
            self._listener(message)

    def listen(self, listener: Callable[[JointState], None]) -> None:
        """
        Hand each sample to ``listener``, after it is published and in the thread that publishes.

        The message is filled anew with the next sample. What ``listener`` raises ends the drive.
        """
        self._listener = listener

    def _on_enable(self, request: SetBool.Request, response: SetBool.Response) -> Any:
        if not request.data:
            # Whoever asks for it: the joints are let go, and so is the driver.
            self._commander.release()
            response.success, response.message = self._command('disable')
        elif refusal := self._refuse_other(callers(self, '~/enable')):
            response.success, response.message = False, refusal
        else:
            response.success, response.message = self._command('enable')
        return response

    def _refuse_other(self, senders: list[Endpoint]) -> str:
        """Return why none of ``senders`` may command, or ''; the log says it once for each."""
        self._watch_commander()
        refusal = self._commander.refusal(senders)
        if refusal and refusal not in self._refused_commands:
            self._refused_commands.append(refusal)
            self.get_logger().warning(refusal)
        return refusal

    def _watch_commander(self) -> None:
        present = publishers(self, 'joint_trajectory')
        if self._action is not None:
            present += callers(self, GOALS)
        self._commander.watch(time.monotonic(), present)
        if not self._commander.name:
            self._refused_commands.clear()

    def _on_stop(self, request: Trigger.Request, response: Trigger.Response) -> Any:
        response.success, response.message = self._command('stop')
        return response

    def _command(self, what: str) -> tuple[bool, str]:
        if self._driver is None or self._thread is None:
            return False, 'the driver is not active: activate it first'
        try:
            getattr(self._driver, what)()
        except SosmlFrictionError as error:
            self.get_logger().error(f'{what} refused: {error}')
            return False, str(error)
        self.commands += what != 'enable'
        done = {'enable': 'enabled: the joints hold', 'disable': 'disabled: no torque'}
        text = done.get(what, 'stopped: the joints hold')
        self.get_logger().info(text)
        # At once, so that whoever asked for it finds it so.
        self._on_timer()
        return True, text

    def _on_trajectory(self, message: JointTrajectoryMessage) -> None:
        found = publishers(self, 'joint_trajectory')
        try:
            self.begin(message, Commander.senders(found, message.header.frame_id))
        except SosmlFrictionError as error:
            # Of another commander the log has told already.
            if str(error) not in self._refused_commands:
                self.get_logger().error(f'trajectory refused: {error}')

    def begin(self, message: JointTrajectoryMessage, senders: list[Endpoint]) -> None:
        """
        Start a trajectory that one of ``senders`` sent.

        :raises SosmlFrictionError: why it is refused; the diagnostics say it as well.
        """
        try:
            if self._driver is None or self._thread is None:
                raise TrajectoryError('the driver is not active: activate it first')
            if refusal := self._refuse_other(senders):
                raise TrajectoryError(refusal)
            self._driver.follow(trajectory_from_message(message))
        except SosmlFrictionError as error:
            # Of another commander "refused commander" tells, for as long as the hold lasts.
            if str(error) not in self._refused_commands:
                self._refused_trajectory = str(error)
            raise
        self._refused_trajectory = ''
        self.commands += 1
        self._commander.take(senders, time.monotonic())
        self.get_logger().info(f'following a trajectory of {self._commander.name}')

    def report(self) -> DriverReport | None:
        """Return a snapshot of the driver, None before it is configured."""
        return None if self._driver is None else self._driver.report()

    def halt(self) -> None:
        """Brake and hold, whatever is commanded."""
        self._command('stop')

    def _on_heartbeat(self) -> None:
        if self._driver is not None and self._thread is not None:
            self._driver.heartbeat()
            if self._driver.trajectory_running:
                self._commander.moves(time.monotonic())
        if self._action is not None:
            self._action.watch()

    def _on_timer(self) -> None:
        driver = self._driver
        if driver is None:
            return
        if self._stamps is not None:
            self._stamps.refresh()
        self._watch_commander()
        report = driver.report()
        thread = self._thread
        self._pace.look(report, thread.skipped if thread else 0)
        if report.reason and report.reason != self._reported_fault:
            self.get_logger().error(f'fault, no torque: {report.reason}')
        self._reported_fault = report.reason
        stamp = self.get_clock().now().to_msg()
        for joint in report.joints:
            if math.isfinite(joint.temperature):
                temperature = Temperature(temperature=joint.temperature, variance=0.0)
                temperature.header.stamp = stamp
                temperature.header.frame_id = joint.name
                self._temperatures.publish(temperature)
        self._diagnostics.publish(make_array(stamp, self._statuses(driver, report, thread)))
        if thread is not None and thread.error is not None:
            self._ended = f'the cycle ended, no torque: {thread.error!r}'
            self.get_logger().fatal(self._ended)
            self.trigger_deactivate()

    def _statuses(
        self, driver: JointDriver, report: DriverReport, thread: CycleThread | None
    ) -> list[DiagnosticStatus]:
        if self._ended:
            level, text = ERROR, self._ended
        elif report.state is DriverState.FAULT:
            level, text = ERROR, report.reason
        elif thread and self._cycle_clock.now_ns() - thread.last_cycle_ns > HANG_NS:
            level, text = ERROR, 'the cycle hangs in the bus: the torque is what it was'
        elif self._refused_trajectory:
            level, text = WARN, f'trajectory refused: {self._refused_trajectory}'
        elif self._refused_commands:
            level, text = WARN, self._refused_commands[-1]
        elif busy := self._pace.remark:
            level, text = WARN, busy
        elif report.trajectory_running:
            level, text = OK, FOLLOWING
        else:
            level, text = OK, report.state.value
        name, channel = full_name(self), self._channel
        cycle = cycle_values(
            report, driver.configuration, self._refused_trajectory, thread, self._relay
        )
        cycle['commander'] = self._commander.name or 'nobody'
        cycle['refused commander'] = (self._refused_commands or [''])[-1]
        bus = bus_values(report, driver.bus_load())
        return [
            make_status(f'{name}: driver', level, text, cycle, channel),
            make_status(f'{name}: bus', OK, channel, bus, channel),
            *(joint_status(name, joint, channel) for joint in report.joints),
        ]


def make_driver_node(starts: bool = True) -> DriverNode:
    """
    Make the node and start it if its parameter ``autostart`` says so.

    :param starts: False to leave that to the caller.
    :raises SosmlFrictionError: why it cannot start.
    """
    # The cycle's thread must not wait 5 ms for a callback to give the interpreter away.
    sys.setswitchinterval(5e-4)
    node = DriverNode()
    if not starts:
        return node
    try:
        node.autostart()
    except SosmlFrictionError:
        node.destroy_node()
        raise
    return node


HELP = NodeHelp(
    'driver_node',
    'Drives the joints over CAN and publishes what they do: joint_states (rad, rad/s, Nm), '
    'joint_temperatures, robot_description. No motor gets torque before ~/enable; ~/stop ends it. '
    'A lifecycle node that configures and activates itself unless it is told not to.',
    '--ros-args --params-file config/exoskeleton.yaml',
    PARAMETERS,
)


def main(args: Sequence[str] | None = None) -> int:
    """Run the program; return its exit code."""
    return run_node(make_driver_node, args, HELP)


if __name__ == '__main__':
    sys.exit(main())
