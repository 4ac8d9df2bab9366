# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's core: from trajectories to frames and from frames to joint samples, without ROS."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Hashable
from dataclasses import replace

import can
import numpy as np

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.cycle import trouble_names
from sosml_friction.actuators.driver.checks import (
    bus_load,
    check_robot,
    make_actuators,
    run_start_ups,
)
from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.cycle_watch import CycleWatch
from sosml_friction.actuators.driver.drive_motion import DriveMotion
from sosml_friction.actuators.driver.driven_joint import DrivenJoint
from sosml_friction.actuators.driver.driver_bus import DriverBus
from sosml_friction.actuators.driver.joint_sample import JointSample
from sosml_friction.actuators.driver.report import DriverReport, DriverState
from sosml_friction.actuators.driver.start_up import Check, Request
from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import (
    ActuatorError,
    CanProtocolError,
    ConfigurationError,
    TrajectoryError,
)
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory import Trajectory

# How often a start-up that found a problem is repeated while nobody drives.
START_UP_RETRY_NS = 1_000_000_000


class JointDriver:
    """
    Drive and measure the joints over one CAN bus.

    :meth:`configure` asks and checks, commanding no motor; :meth:`step` runs one cycle and is to
    be called ``rate`` times a second from one thread; the other methods may be called from any
    thread. Until :meth:`enable`, torque actuators are commanded zero current (it brings back iq)
    and position actuators are off.

    A fault sets all of them back to that and is latched with its reason until the next
    :meth:`enable`. docs/driver.md says what a fault is, and how a lost bus comes back. ``checks``:
    what the last whole start-up found.

    :param robot: the nominal model, joints in the order of the configuration; this object alone
        may use it.
    :param reopen: opens the bus again after its adapter was lost; it may take its time.
    :raises ConfigurationError: if the joints, identifiers or the bus load do not fit.
    """

    def __init__(
        self,
        configuration: DriverConfiguration,
        robot: Robot,
        bus: can.BusABC,
        clock: Clock,
        reopen: Callable[[], can.BusABC] | None = None,
    ) -> None:
        check_robot(robot, configuration.names, 'driver')
        self.configuration = configuration
        self._clock = clock
        self._actuators = make_actuators(configuration, robot.limits)
        worst, load = bus_load(self._actuators, configuration)
        if worst > 1.0:
            raise ConfigurationError(f'{load}: lower rate or raise can_bitrate')
        self._joints = [DrivenJoint(actuator, configuration) for actuator in self._actuators]
        self._bus = DriverBus(bus, clock, self._actuators, reopen)
        self._motion = DriveMotion(configuration, robot)
        self._watch = CycleWatch(configuration)
        self._lock = threading.Lock()
        self.state = DriverState.UNCONFIGURED
        self._reason = ''
        self.checks: tuple[Check, ...] = ()
        self._start_up_ns = 0
        self._enables = 0
        self._cycles = 0
        self._incomplete = self._late = 0
        self._skew_ns = 0

    @property
    def trajectory_running(self) -> bool:
        """Tell whether a trajectory is being executed."""
        return self._motion.follower.running

    @property
    def bus(self) -> can.BusABC:
        """Return the bus in use: after a recovery it may be another one."""
        return self._bus.cycle.bus

    # ---- what is asked of it

    def configure(self) -> None:
        """
        Ask every actuator who and where it is, without commanding any motor.

        :raises ActuatorError: if one is silent, reports a fault, or is outside its joint's limits.
        """
        self.checks = run_start_ups(self._bus.cycle, self._clock, self._actuators, read_only=False)
        for check in self.checks:
            if check.problem:
                raise ActuatorError(check.problem)
        with self._lock:
            for joint in self._joints:
                joint.begin()
            self._bus.begin()
            self._watch.begin()
            self._hold()
            self.state = DriverState.DISABLED
            self._reason = ''

    def enable(self) -> None:
        """
        Hold the joints, braking those that move; clears a latched fault whose cause is gone.

        :raises ActuatorError: if an actuator is silent, faulty or outside its limits, or no cycle
            has run yet.
        """
        with self._lock:
            if self.state is DriverState.ENABLED:
                return
            if self.state is DriverState.UNCONFIGURED:
                raise ActuatorError(
                    'the driver is not configured: configure and activate it first'
                )
            for joint in self._joints:
                self._refuse(joint)
            self._motion.brake(self._position(), np.array([joint.v for joint in self._joints]))
            for joint in self._joints:
                joint.enable()
            self._watch.enable(self._clock.now_ns())
            self._reason = ''
            self._enables += 1
            self.state = DriverState.ENABLED

    def _refuse(self, joint: DrivenJoint) -> None:
        """Refuse to drive a joint that has a problem or is not known well enough."""
        problem = self._problem(joint)
        if not problem and joint.away:
            problem = f'joint {joint.name} was away and is being asked anew: try again'
        if not problem and math.isnan(joint.v):
            problem = (
                f'joint {joint.name} has no velocity yet: activate the driver and wait '
                f'{self.configuration.velocity_window} cycles'
            )
        if problem:
            raise ActuatorError(problem)

    def disable(self) -> None:
        """Let the joints go: zero current, servo off, trajectory dropped. The arm may fall."""
        with self._lock:
            if self.state is DriverState.ENABLED:
                self.state = DriverState.DISABLED
                self._hold()

    def stop(self) -> None:
        """
        Drop the trajectory, brake with ``stop_deceleration`` and hold.

        :raises ActuatorError: if the driver is not enabled.
        """
        with self._lock:
            if self.state is not DriverState.ENABLED:
                raise ActuatorError(f'the driver is {self.state.value}: there is nothing to stop')
            last = self._motion.follower.last
            self._motion.brake(last.q, last.v)

    def follow(self, trajectory: Trajectory) -> None:
        """
        Check a trajectory as a whole and start it in the next cycle, in place of a running one.

        :raises TrajectoryError: if it does not fit, or the driver is not enabled.
        """
        with self._lock:
            if self.state is not DriverState.ENABLED:
                raise TrajectoryError(
                    f'the driver is {self.state.value}: enable it before it gets a trajectory'
                )
            for actuator in self._actuators:
                if actuator.waiting():
                    raise TrajectoryError(f'{actuator.waiting()}: send the trajectory again')
            position, enables = self._position(), self._enables
        prepared = self._motion.prepare(trajectory, position)
        with self._lock:
            # It was checked against where the joints were then.
            if self.state is not DriverState.ENABLED or self._enables != enables:
                raise TrajectoryError(
                    'the drive ended while the trajectory was checked: send it again'
                )
            self._motion.follower.follow(prepared)

    def heartbeat(self) -> None:
        """Say that the program around is alive; then silence for ``host_timeout`` is a fault."""
        self._watch.heartbeat(self._clock.now_ns())

    def fault(self, reason: str) -> None:
        """Latch a fault of the program around the driver; only :meth:`configure` lifts it."""
        with self._lock:
            self._watch.host_problem = reason
            self._fail(reason)

    def shut_down(self) -> None:
        """
        Switch all outputs off: zero current, then 0x80; servo off. Tried even on a faulty bus.

        A bus that was lost is opened again for it, once. Nothing is sent if no cycle ever ran:
        then nothing was commanded. Not while :meth:`step` runs in another thread.
        """
        with self._lock:
            self.state = DriverState.UNCONFIGURED
        self._bus.shut_down()

    # ---- the cycle

    def step(self) -> JointSample | None:
        """
        Run one cycle; return its sample, or None if a reply did not come or came late.

        The next cycle begins when all replies are in, or ``reply_timeout`` has passed: a late
        reply of an RMD-X, which numbers nothing, could not be told from the next one.

        :raises ActuatorError: if the driver is not configured.
        """
        start_ns = self._clock.now_ns()
        if self.state is DriverState.UNCONFIGURED:
            raise ActuatorError('the driver is not configured: configure it before it steps')
        if self._bus.error:
            self._cycles += 1
            self._incomplete += 1
            if self._bus.recover(start_ns):
                self._start_up_ns = 0
            return None
        self._return_who_was_away(start_ns)
        # The cycle begins after that: it may have taken seconds.
        start_ns = self._clock.now_ns()
        with self._lock:
            problem = self._watch.start_cycle(start_ns)
            if problem:
                self._fail(problem)
            by_joint = self._requests(start_ns)
        missing = self._bus.exchange(
            [request for own in by_joint for request in own],
            start_ns + round(self.configuration.reply_timeout * 1e9),
        )
        with self._lock:
            if self._bus.error:
                self._all_away()
            else:
                self._watch.end_cycle(self._bus.cycle.counters, self._clock.now_ns())
            return self._evaluate(by_joint, missing, start_ns)

    def _requests(self, now_ns: int) -> list[list[Request]]:
        if self.state is DriverState.ENABLED:
            try:
                self._motion.follower.sample(now_ns)
                if self._bus.deaf:
                    # Commands that nobody takes must not pile up where they may burst out later.
                    return [actuator.observe(now_ns) for actuator in self._actuators]
                v = np.array([joint.known_v for joint in self._joints])
                setpoints = self._motion.setpoints(self._position(), v)
                return [
                    actuator.command(setpoint, now_ns)
                    for actuator, setpoint in zip(self._actuators, setpoints, strict=True)
                ]
            except CanProtocolError as error:
                self._fail(str(error))
        return [actuator.release(now_ns) for actuator in self._actuators]

    def _evaluate(
        self, by_joint: list[list[Request]], missing: set[Hashable], start_ns: int
    ) -> JointSample | None:
        self._cycles += 1
        complete = True
        for i, (joint, requests) in enumerate(zip(self._joints, by_joint, strict=True)):
            missed = any(request.key in missing for request in requests)
            complete = complete and not missed
            if not missed:
                joint.take(start_ns)
            if missed or not joint.timely:
                joint.wait(start_ns, self._clock.now_ns(), missed=missed)
            else:
                joint.hear()
            joint.away = joint.away or joint.silent
            problem = self._problem(joint) or joint.event()
            if not problem and joint.answers and self.state is DriverState.ENABLED:
                problem = joint.tracking_problem(float(self._motion.follower.last.q[i]))
            if problem:
                self._fail(problem)
            joint.trust()
            joint.note_events()
        if not complete:
            self._incomplete += 1
            return None
        if any(joint.late for joint in self._joints):
            self._late += 1
            return None
        stamps = tuple(joint.stamp_ns for joint in self._joints)
        sample = JointSample(
            stamp_ns=max(stamps),
            joint_ns=stamps,
            q=self._position(),
            v=np.array([joint.sampled_v for joint in self._joints]),
            tau=np.array([joint.take_effort() for joint in self._joints]),
        )
        self._skew_ns = sample.skew_ns
        return sample

    def _return_who_was_away(self, now_ns: int) -> None:
        """Ask anew who was silent, restarted or cut off, before anything is commanded to it."""
        back = [joint for joint in self._joints if joint.away and not joint.silent]
        if not back or now_ns < self._start_up_ns or self.state is DriverState.ENABLED:
            return
        self._start_up_ns = now_ns + START_UP_RETRY_NS
        checks = self._bus.start_up([joint.actuator for joint in back])
        with self._lock:
            if checks is None:
                self._all_away()
                return
            for joint in back:
                problems = (own.problem for own in checks if own.joint == joint.name)
                joint.come_back(next(filter(None, problems), ''))
            for joint in self._joints:
                joint.note_events()

    def _problem(self, joint: DrivenJoint) -> str:
        """Return what stands against driving ``joint`` now."""
        return (
            self._watch.host_problem
            or self._bus.error
            or self._watch.intruder()
            or (self._watch.blockage() if joint.silent else '')
            or joint.problem()
        )

    def _fail(self, reason: str) -> None:
        """Latch a fault; only an enabled driver has anything to lose."""
        if self.state is DriverState.ENABLED:
            self.state = DriverState.FAULT
            self._reason = reason
            self._hold()

    def _all_away(self) -> None:
        for joint in self._joints:
            joint.away = True

    def _hold(self) -> None:
        self._motion.follower.hold(self._position())

    def _position(self) -> FloatArray:
        return np.array([joint.q for joint in self._joints])

    # ---- what is shown of it

    def report(self) -> DriverReport:
        """Return a snapshot for diagnostics."""
        with self._lock:
            driven = self.state is DriverState.ENABLED
            reference = self._motion.follower.last.q.tolist()
            return DriverReport(
                state=self.state,
                reason=self._reason,
                trajectory_running=self.trajectory_running,
                cycles=self._cycles,
                incomplete_cycles=self._incomplete,
                late_cycles=self._late,
                skew_ns=self._skew_ns,
                bus=replace(self._bus.cycle.counters),
                bus_trouble=trouble_names(self._bus.cycle.trouble),
                joints=tuple(
                    joint.report(self._problem(joint), q if driven else math.nan)
                    for joint, q in zip(self._joints, reference, strict=True)
                ),
            )

    def bus_load(self) -> str:
        """Return the bus load as a sentence with its arithmetic."""
        return bus_load(self._actuators, self.configuration)[1]
