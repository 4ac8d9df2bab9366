# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's core: from trajectories to frames and from frames to joint samples, without ROS."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import can
import numpy as np
from numpy.typing import NDArray

from sosml_friction.actuators.actuator import Actuator, Setpoint
from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.cycle import BusCounters, BusCycle
from sosml_friction.actuators.driver.configuration import (
    RMD_X,
    TORQUE_MODE,
    DriverConfiguration,
    JointConfiguration,
)
from sosml_friction.actuators.driver.soft_stop import SoftStop
from sosml_friction.actuators.driver.start_up import Check, Request
from sosml_friction.actuators.driver.start_up_run import run_start_ups
from sosml_friction.actuators.rmd_x.actuator import RmdXActuator
from sosml_friction.actuators.servo.actuator import ServoActuator
from sosml_friction.exceptions import (
    ActuatorError,
    CanProtocolError,
    ConfigurationError,
    TrajectoryError,
)
from sosml_friction.model.robot import JointLimits, Robot
from sosml_friction.motion.controller import JointController
from sosml_friction.motion.prepare_trajectory import prepare_trajectory
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_follower import TrajectoryFollower
from sosml_friction.motion.velocity import WindowedSlope

FloatArray = NDArray[np.float64]

SHUT_DOWN_TIMEOUT_NS = 20_000_000
SHUT_DOWN_ATTEMPTS = 3
# How often a lost bus is tried again, and how long its first question waits.
RETRY_NS = 100_000_000
PROBE_TIMEOUT_NS = 20_000_000
# How often a start-up that found a problem is repeated while nobody drives.
START_UP_RETRY_NS = 1_000_000_000
# A joint that moves less than the first share of its tracking limit while its reference moves more
# than the second is stuck.
STILL_SHARE, STUCK_SHARE = 0.01, 0.25
# Measured current and speed may differ from what they should be by this, and for this long: a
# current ripples, the speed by position lags behind the motor's own [A, rad/s, cycles].
CURRENT_FACTOR, CURRENT_SLACK = 1.5, 0.5
SPEED_FACTOR, SPEED_SLACK = 0.3, 0.6
IMPLAUSIBLE_CYCLES = 25
# Another program on the bus is taken to be there for so long after its last command.
INTRUDER_NS = 1_000_000_000

# A standard frame of 8 bytes with its pause: without and with the worst stuffing.
FRAME_BITS = 111
FRAME_BITS_STUFFED = 135


class DriverState(Enum):
    """Where the driver is."""

    UNCONFIGURED = 'unconfigured'
    DISABLED = 'disabled'
    ENABLED = 'enabled'
    FAULT = 'fault'


@dataclass(frozen=True)
class JointSample:
    """
    Hold what one completed cycle measured, joints in the driver's order.

    ``stamp_ns``: receive time of the cycle's last position, on the driver's clock; ``joint_ns``:
    of each joint's. ``q`` [rad or m], ``v`` [rad/s or m/s], ``tau`` [Nm or N], each (n,); NaN is
    not known: v until its window is full, tau where the actuator measures no current.
    """

    stamp_ns: int
    joint_ns: tuple[int, ...]
    q: FloatArray
    v: FloatArray
    tau: FloatArray

    @property
    def skew_ns(self) -> int:
        """Return the time between the first and the last position of the cycle [ns]."""
        return max(self.joint_ns) - min(self.joint_ns)


@dataclass(frozen=True)
class JointReport:
    """
    Hold what diagnostics show of a joint; units as in :class:`Measurement`.

    ``missed``: cycles without all replies, in total; ``problem``: what would fault it now, or '';
    ``latency``: from the cycle's begin to the position's arrival [s]; ``tracking_error``:
    reference minus position [rad or m], NaN while it is not driven; ``timeouts``: how often the
    actuator's own watchdog tripped; ``restarts``: how often it was switched on anew.
    """

    name: str
    q: float
    v: float
    tau: float
    current: float
    temperature: float
    voltage: float
    firmware: str
    flags: str
    missed: int
    problem: str
    warning: str
    model: str
    position_raw: float
    speed: float
    uptime: float
    latency: float
    tracking_error: float
    timeouts: int
    restarts: int


@dataclass(frozen=True)
class DriverReport:
    """Hold what diagnostics show of the driver; ``reason`` is why it is in FAULT."""

    state: DriverState
    reason: str
    trajectory_running: bool
    cycles: int
    incomplete_cycles: int
    skew_ns: int
    bus: BusCounters
    bus_trouble: str
    joints: tuple[JointReport, ...]


class JointDriver:
    """
    Drive and measure the joints over one CAN bus.

    :meth:`configure` asks and checks, commanding no motor; :meth:`step` runs one cycle and is to
    be called ``rate`` times a second from one thread; the other methods may be called from any
    thread. Until :meth:`enable`, torque actuators are commanded zero current (it brings back iq)
    and position actuators are off.

    A fault sets all of them back to that and is latched with its reason until the next
    :meth:`enable`: no timely answer for ``missed_limit`` periods, the bus, an error flag,
    temperature, a value that is not finite, a joint outside its limits, too fast, too far from
    its reference or not moving with it, current or speed that do not fit, a watchdog that tripped
    or a restart while driven, a host that hangs. A lost bus is tried again without sending
    anything but one harmless question; whatever was away goes through the start-up once more. As
    a context manager it ends in :meth:`shut_down`.

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
        if robot.names != configuration.names:
            raise ConfigurationError(
                f'the model has the joints {", ".join(robot.names)}, the driver '
                f'{", ".join(configuration.names)}: name the same, in the same order'
            )
        check_limits(robot)
        self.configuration = configuration
        self._clock = clock
        self._limits = robot.limits
        self._actuators = make_actuators(configuration, robot.limits)
        check_bus_load(self._actuators, configuration)
        self._cycle = BusCycle(bus, clock, self._actuators, reopen)
        by_torque = [
            joint.driver == RMD_X and joint.mode == TORQUE_MODE for joint in configuration.joints
        ]
        gains = np.array(
            [
                (joint.kp, joint.kd) if torque else (0.0, 0.0)
                for joint, torque in zip(configuration.joints, by_torque, strict=True)
            ]
        )
        self._controller = JointController(robot, *gains.T)
        self._soft_stop = SoftStop(
            robot.limits,
            np.array([limits.effort for limits in robot.limits]),
            gains[:, 1],
            configuration.stop_deceleration,
            configuration.limit_margin,
        )
        window = configuration.velocity_window
        gap_ns = window * configuration.period_ns
        self._slopes = [WindowedSlope(window, gap_ns) for _ in self._actuators]
        n = len(self._actuators)
        self._follower = TrajectoryFollower(np.zeros(n))
        self._lock = threading.Lock()
        self._state = DriverState.UNCONFIGURED
        self._reason = ''
        self._commanded = False
        self._v = np.full(n, math.nan)
        # The last velocity that was known: after a hiccup of the host the window fills anew for a
        # few cycles, and a joint damped by an old velocity is better off than an undamped one.
        self._known_v = np.zeros(n)
        self._bus_error = ''
        self._retry_ns = 0
        self._deaf = False
        self._blocked = False
        self._not_sent = 0
        self._silent_since: list[int | None] = [None] * n
        self._silence_ns = [0] * n
        self._latency_ns = [0] * n
        self._missed_total = [0] * n
        self._away = [False] * n
        # Where a joint was when it last answered, and whether it was switched on anew since.
        self._trusted_q = [math.nan] * n
        self._restarted = [False] * n
        self._start_up_ns = 0
        self._start_problem = [''] * n
        self._timeouts = [0] * n
        self._restarts = [0] * n
        self._implausible = [0] * n
        self._still_q = [math.nan] * n
        self._still_reference = [math.nan] * n
        self._checks: tuple[Check, ...] = ()
        self._host_ns: int | None = None
        self._host_problem = ''
        self._step_ns: int | None = None
        self._enables = 0
        self._intruders = 0
        self._intruded_ns: int | None = None
        self._cycles = 0
        self._incomplete = 0
        self._skew_ns = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Return the joints in order."""
        return self.configuration.names

    @property
    def state(self) -> DriverState:
        """Return the driver's state."""
        return self._state

    @property
    def trajectory_running(self) -> bool:
        """Tell whether a trajectory is being executed."""
        return self._follower.running

    @property
    def bus(self) -> can.BusABC:
        """Return the bus in use: after a recovery it may be another one."""
        return self._cycle.bus

    @property
    def checks(self) -> tuple[Check, ...]:
        """Return what the last whole start-up found."""
        return self._checks

    def __enter__(self) -> JointDriver:
        return self

    def __exit__(self, *_: object) -> None:
        self.shut_down()

    def configure(self) -> None:
        """
        Ask every actuator who and where it is, without commanding any motor.

        :raises ActuatorError: if one is silent, reports a fault, or is outside its joint's limits.
        """
        self._checks = run_start_ups(self._cycle, self._clock, self._actuators, read_only=False)
        for check in self._checks:
            if check.problem:
                raise ActuatorError(check.problem)
        with self._lock:
            n = len(self._actuators)
            self._away = [False] * n
            self._restarted = [False] * n
            self._trusted_q = self._position().tolist()
            self._start_problem = [''] * n
            self._silent_since = [None] * n
            self._silence_ns = [0] * n
            self._bus_error = self._host_problem = ''
            self._host_ns = self._step_ns = None
            # What was measured before belongs to another drive: no velocity until it is known.
            self._v = np.full(n, math.nan)
            self._known_v = np.zeros(n)
            for slope in self._slopes:
                slope.reset()
            self._implausible = [0] * n
            self._deaf = self._blocked = False
            self._follower.hold(self._position())
            self._note_events()
            self._state = DriverState.DISABLED
            self._reason = ''

    def enable(self) -> None:
        """
        Hold the joints, braking those that move; clears a latched fault whose cause is gone.

        :raises ActuatorError: if an actuator is silent, faulty or outside its limits, or no cycle
            has run yet.
        """
        with self._lock:
            if self._state is DriverState.ENABLED:
                return
            if self._state is DriverState.UNCONFIGURED:
                raise ActuatorError(
                    'the driver is not configured: configure and activate it first'
                )
            for i, actuator in enumerate(self._actuators):
                problem = self._problem(i)
                if problem:
                    raise ActuatorError(problem)
                if self._away[i]:
                    raise ActuatorError(
                        f'joint {actuator.name} was away and is being asked anew: try again'
                    )
                if math.isnan(self._v[i]):
                    raise ActuatorError(
                        f'joint {actuator.name} has no velocity yet: activate the driver and wait '
                        f'{self.configuration.velocity_window} cycles'
                    )
            self._brake(self._position(), self._v)
            self._note_events()
            self._implausible = [0] * len(self._actuators)
            self._forget_still()
            if self._host_ns is not None:
                self._host_ns = self._clock.now_ns()
            self._reason = ''
            self._step_ns = None
            self._enables += 1
            self._state = DriverState.ENABLED

    def disable(self) -> None:
        """Let the joints go: zero current, servo off, trajectory dropped. The arm may fall."""
        with self._lock:
            if self._state is DriverState.ENABLED:
                self._state = DriverState.DISABLED
                self._follower.hold(self._position())

    def stop(self) -> None:
        """
        Drop the trajectory, brake with ``stop_deceleration`` and hold.

        :raises ActuatorError: if the driver is not enabled.
        """
        with self._lock:
            if self._state is not DriverState.ENABLED:
                raise ActuatorError(f'the driver is {self._state.value}: there is nothing to stop')
            last = self._follower.last
            self._brake(last.q, last.v)

    def follow(self, trajectory: Trajectory) -> None:
        """
        Check a trajectory as a whole and start it in the next cycle, in place of a running one.

        :raises TrajectoryError: if it does not fit, or the driver is not enabled.
        """
        with self._lock:
            if self._state is not DriverState.ENABLED:
                raise TrajectoryError(
                    f'the driver is {self._state.value}: enable it before it gets a trajectory'
                )
            for actuator in self._actuators:
                if actuator.waiting():
                    raise TrajectoryError(f'{actuator.waiting()}: send the trajectory again')
            position, enables = self._position(), self._enables
        tolerance = np.full(len(position), self.configuration.start_tolerance)
        prepared = prepare_trajectory(trajectory, self.names, self._limits, position, tolerance)
        with self._lock:
            # It was checked against where the joints were then.
            if self._state is not DriverState.ENABLED or self._enables != enables:
                raise TrajectoryError(
                    'the drive ended while the trajectory was checked: send it again'
                )
            self._follower.follow(prepared)

    def step(self) -> JointSample | None:
        """
        Run one cycle; return its sample, or None if a reply did not come in time.

        The next cycle begins when all replies are in, or ``reply_timeout`` has passed: requests do
        not pile up before an actuator that is late, and as the RMD-X numbers nothing, a late reply
        could not be told from the next one.
        """
        start_ns = self._clock.now_ns()
        with self._lock:
            if self._state is DriverState.UNCONFIGURED:
                raise ActuatorError('the driver is not configured: configure it before it steps')
        if self._bus_error:
            self._recover(start_ns)
            return None
        self._return_who_was_away(start_ns)
        # The cycle begins after that: it may have taken seconds.
        start_ns = self._clock.now_ns()
        with self._lock:
            self._check_host(start_ns)
            self._check_stall(start_ns)
            by_actuator = self._requests(start_ns)
        requests = [request for own in by_actuator for request in own]
        deadline_ns = start_ns + round(self.configuration.reply_timeout * 1e9)
        self._commanded = True
        try:
            missing = self._cycle.exchange(requests, deadline_ns)
        except ActuatorError as error:
            with self._lock:
                self._lose_bus(str(error))
                missing = {request.key for request in requests}
                return self._evaluate(by_actuator, missing, start_ns)
        with self._lock:
            self._deaf = all(request.key in missing for request in requests)
            not_sent = self._cycle.counters.not_sent
            self._blocked, self._not_sent = not_sent > self._not_sent, not_sent
            self._note_intruders()
            return self._evaluate(by_actuator, missing, start_ns)

    def heartbeat(self) -> None:
        """
        Say that the program around the driver is alive.

        From the first call on, ``host_timeout`` without another one is a fault.
        """
        self._host_ns = self._clock.now_ns()

    def fault(self, reason: str) -> None:
        """Latch a fault of the program around the driver; only :meth:`configure` lifts it."""
        with self._lock:
            self._host_problem = reason
            self._fail(reason)

    def _check_host(self, now_ns: int) -> None:
        if self._host_ns is None:
            return
        silence = (now_ns - self._host_ns) * 1e-9
        if silence > self.configuration.host_timeout:
            self._fail(
                f'the program around the driver has not been heard of for {silence:.2f} s: one of '
                'its callbacks hangs'
            )

    def _note_intruders(self) -> None:
        count, now_ns = self._cycle.counters.intruders, self._clock.now_ns()
        if count > self._intruders:
            self._intruded_ns = now_ns
        elif self._intruded_ns is not None and now_ns - self._intruded_ns > INTRUDER_NS:
            self._intruded_ns = None
        self._intruders = count

    def _check_stall(self, now_ns: int) -> None:
        """
        Take a pause of the cycle itself for what it is: the reference would jump after it.

        The joints were without a command for as long as a silent actuator may be.
        """
        last_ns, self._step_ns = self._step_ns, now_ns
        if last_ns is None:
            return
        configuration = self.configuration
        allowed_ns = configuration.missed_limit * configuration.period_ns
        pause_ns = now_ns - last_ns
        if pause_ns > allowed_ns + round(configuration.reply_timeout * 1e9):
            self._fail(
                f'the cycle stood still for {pause_ns * 1e-6:.0f} ms, longer than missed_limit '
                f'({configuration.missed_limit} periods): the machine is too busy, or slept'
            )

    def _lose_bus(self, error: str) -> None:
        self._bus_error = error
        self._away = [True] * len(self._actuators)
        self._retry_ns = self._clock.now_ns() + RETRY_NS

    def _recover(self, now_ns: int) -> None:
        """Try a lost bus again: first nothing, then one harmless question to each actuator."""
        self._cycles += 1
        self._incomplete += 1
        if now_ns < self._retry_ns:
            return
        self._retry_ns = now_ns + RETRY_NS
        if not self._cycle.recover():
            return
        questions = [request for actuator in self._actuators for request in actuator.probe()]
        try:
            missing = self._cycle.exchange(questions, self._clock.now_ns() + PROBE_TIMEOUT_NS)
        except ActuatorError as error:
            with self._lock:
                self._bus_error = str(error)
            return
        if len(missing) == len(questions):
            return
        with self._lock:
            self._bus_error = ''
            self._start_up_ns = 0
            # A motor without a watchdog of its own still has the current of the moment the bus
            # was lost: no question is more urgent than to end that.
            released = [request for own in self._actuators for request in own.release(now_ns)]
        try:
            self._cycle.exchange(released, self._clock.now_ns() + PROBE_TIMEOUT_NS)
        except ActuatorError as error:
            with self._lock:
                self._lose_bus(str(error))

    def _return_who_was_away(self, now_ns: int) -> None:
        """Ask anew who was silent, restarted or cut off, before anything is commanded to it."""
        back = [i for i, away in enumerate(self._away) if away and not self._silent(i)]
        if not back or now_ns < self._start_up_ns or self._state is DriverState.ENABLED:
            return
        self._start_up_ns = now_ns + START_UP_RETRY_NS
        actuators = [self._actuators[i] for i in back]
        try:
            checks = run_start_ups(
                self._cycle, self._clock, actuators, read_only=True, watchdog=False
            )
        except ActuatorError as error:
            with self._lock:
                self._lose_bus(str(error))
            return
        with self._lock:
            for i in back:
                name = self._actuators[i].name
                problems = [own.problem for own in checks if own.joint == name and own.problem]
                self._restarted[i] |= self._actuators[i].restarts > self._restarts[i]
                problem = problems[0] if problems else self._lost_count(i)
                self._start_problem[i] = problem
                self._away[i] = bool(problem)
                self._restarted[i] &= bool(problem)
            self._note_events()

    def _lost_count(self, i: int) -> str:
        """
        Return that a joint came back from a restart too far from where it was, or ''.

        A motor that is moved while it is off may lose whole turns, of its own or of the output.
        Within the joint's limits nothing else tells: half a motor turn is refused, 0.3 rad where
        its gear ratio is not known.
        """
        actuator = self._actuators[i]
        distance = abs(actuator.measurement.q - self._trusted_q[i])
        ratio = actuator.configuration.gear_ratio
        allowed = min(0.3, math.pi / ratio) if ratio > 0.0 else 0.3
        if not self._restarted[i] or not distance > allowed:
            return ''
        return (
            f'joint {actuator.name} was switched off and came back {distance:.3f} from where it '
            'was: it may have lost count of its turns: move it back to where it was, or check its '
            'angle and configure the driver anew'
        )

    def _note_events(self) -> None:
        self._timeouts = [actuator.timeouts for actuator in self._actuators]
        self._restarts = [actuator.restarts for actuator in self._actuators]

    def shut_down(self) -> None:
        """
        Switch all outputs off: zero current, then 0x80; servo off. Tried even on a faulty bus.

        A bus that was lost is opened again for it, once. Nothing is sent if no cycle ever ran:
        then nothing was commanded. Not while :meth:`step` runs in another thread.
        """
        with self._lock:
            self._state = DriverState.UNCONFIGURED
        if not self._commanded:
            return
        left = list(self._actuators)
        lost, reopened = bool(self._bus_error), False
        for _ in range(SHUT_DOWN_ATTEMPTS):
            try:
                if lost and not reopened:
                    reopened = True
                    self._cycle.recover()
                asked = [(actuator, actuator.shut_down()) for actuator in left]
                requests = [request for _, own in asked for request in own]
                missing = self._cycle.exchange(
                    requests, self._clock.now_ns() + SHUT_DOWN_TIMEOUT_NS
                )
            except Exception:
                # Whatever it was, a defect in a CAN driver included: the joint is still driven.
                lost = True
                continue
            left = [
                actuator
                for actuator, own in asked
                if any(request.key in missing for request in own)
            ]
            if not left:
                break
        self._commanded = False

    def report(self) -> DriverReport:
        """Return a snapshot for diagnostics."""
        with self._lock:
            joints = tuple(
                JointReport(
                    name=actuator.name,
                    q=actuator.measurement.q,
                    v=float(self._v[i]),
                    tau=actuator.measurement.tau,
                    current=actuator.measurement.current,
                    temperature=actuator.measurement.temperature,
                    voltage=actuator.measurement.voltage,
                    firmware=actuator.measurement.firmware,
                    flags=actuator.flags(),
                    missed=self._missed_total[i],
                    problem=self._problem(i),
                    warning=actuator.warning(),
                    model=actuator.measurement.model,
                    position_raw=actuator.measurement.position_raw,
                    speed=actuator.measurement.speed,
                    uptime=actuator.measurement.uptime,
                    latency=self._latency_ns[i] * 1e-9,
                    tracking_error=self._tracking_error(i),
                    timeouts=actuator.timeouts,
                    restarts=actuator.restarts,
                )
                for i, actuator in enumerate(self._actuators)
            )
            return DriverReport(
                state=self._state,
                reason=self._reason,
                trajectory_running=self._follower.running,
                cycles=self._cycles,
                incomplete_cycles=self._incomplete,
                skew_ns=self._skew_ns,
                bus=replace(self._cycle.counters),
                bus_trouble=self._cycle.trouble_text(),
                joints=joints,
            )

    def bus_load(self) -> str:
        """Return the bus load as a sentence with its arithmetic."""
        return bus_load(self._actuators, self.configuration)[1]

    def _requests(self, now_ns: int) -> list[list[Request]]:
        if self._state is DriverState.ENABLED:
            try:
                reference = self._follower.sample(now_ns)
                if self._deaf:
                    # Commands that nobody takes must not pile up where they may burst out later.
                    return [actuator.observe(now_ns) for actuator in self._actuators]
                q = self._position()
                effort = self._controller.effort(reference, q, self._known_v)
                effort = self._soft_stop.limit(effort, q, self._known_v)
                return [
                    actuator.command(
                        Setpoint(float(effort[i]), float(reference.q[i]), float(reference.v[i])),
                        now_ns,
                    )
                    for i, actuator in enumerate(self._actuators)
                ]
            except CanProtocolError as error:
                self._fail(str(error))
        return [actuator.release(now_ns) for actuator in self._actuators]

    def _evaluate(
        self, by_actuator: list[list[Request]], missing: set[Hashable], start_ns: int
    ) -> JointSample | None:
        self._cycles += 1
        complete = True
        for i, (actuator, requests) in enumerate(zip(self._actuators, by_actuator, strict=True)):
            measurement = actuator.measurement
            if any(request.key in missing for request in requests):
                complete = False
                self._missed_total[i] += 1
                self._wait_for(i, start_ns)
            else:
                self._latency_ns[i] = measurement.stamp_ns - start_ns
                if self._latency_ns[i] * 1e-9 > 0.5 * self.configuration.reply_timeout:
                    # What comes so late may as well be the answer to the cycle before.
                    self._wait_for(i, start_ns)
                else:
                    self._silent_since[i] = None
                    self._silence_ns[i] = 0
                v = self._slopes[i].update(measurement.stamp_ns, measurement.q)
                self._v[i] = v
                if not math.isnan(v):
                    self._known_v[i] = v
                self._judge_plausibility(i, v)
            self._away[i] = self._away[i] or self._silent(i)
            problem = self._problem(i) or self._event(i)
            if not problem and self._silent_since[i] is None:
                problem = self._tracking_problem(i)
            if problem:
                self._fail(problem)
            if not self._away[i]:
                self._trusted_q[i] = measurement.q
        self._note_events()
        if not complete:
            self._incomplete += 1
            return None
        stamps = tuple(actuator.measurement.stamp_ns for actuator in self._actuators)
        sample = JointSample(
            stamp_ns=max(stamps),
            joint_ns=stamps,
            q=self._position(),
            v=self._v.copy(),
            tau=np.array([actuator.measurement.tau for actuator in self._actuators]),
        )
        self._skew_ns = sample.skew_ns
        return sample

    def _fail(self, reason: str) -> None:
        """Latch a fault; only an enabled driver has anything to lose."""
        if self._state is DriverState.ENABLED:
            self._state = DriverState.FAULT
            self._reason = reason
            self._follower.hold(self._position())

    def _brake(self, q: FloatArray, v: FloatArray) -> None:
        self._follower.brake(
            q,
            v,
            self.configuration.stop_deceleration,
            np.array([limits.lower for limits in self._limits]),
            np.array([limits.upper for limits in self._limits]),
        )

    def _position(self) -> FloatArray:
        return np.array([actuator.measurement.q for actuator in self._actuators])

    def _wait_for(self, i: int, start_ns: int) -> None:
        since = self._silent_since[i]
        self._silent_since[i] = since = start_ns if since is None else since
        self._silence_ns[i] = self._clock.now_ns() - since

    def _silent(self, i: int) -> bool:
        limit_ns = self.configuration.missed_limit * self.configuration.period_ns
        return self._silence_ns[i] >= limit_ns

    def _problem(self, i: int) -> str:
        """Return what stands against driving joint ``i`` now."""
        actuator = self._actuators[i]
        if self._host_problem or self._bus_error:
            return self._host_problem or self._bus_error
        if self._intruded_ns is not None:
            return (
                'another program commands these actuators on the same bus (or they share an '
                'identifier): end it'
            )
        if self._silent(i) and self._blocked:
            return (
                'the CAN bus takes no frames (transmit buffer full): nobody acknowledges them: '
                "check the actuators' power, wiring, termination and bit rate"
            )
        if self._silent(i):
            return (
                f'{actuator.silence()} (no timely answer for {self._silence_ns[i] * 1e-6:.0f} ms)'
            )
        return (
            actuator.fault()
            or self._start_problem[i]
            or actuator.out_of_band(self.configuration.limit_margin)
            or self._too_fast(i)
            or self._implausibility(i)
        )

    def _event(self, i: int) -> str:
        """Return what has happened to joint ``i`` since the last cycle."""
        actuator = self._actuators[i]
        if actuator.restarts > self._restarts[i]:
            self._away[i] = self._restarted[i] = True
            return f'joint {actuator.name}: the motor was switched on anew while it was driven'
        if actuator.timeouts > self._timeouts[i]:
            return (
                f"joint {actuator.name}: the motor's own watchdog switched it off: commands came "
                'too late or not at all'
            )
        return ''

    def _tracking_error(self, i: int) -> float:
        if self._state is not DriverState.ENABLED:
            return math.nan
        return float(self._follower.last.q[i]) - self._actuators[i].measurement.q

    def _tracking_problem(self, i: int) -> str:
        if self._state is not DriverState.ENABLED:
            return ''
        actuator, reference = self._actuators[i], float(self._follower.last.q[i])
        q, limit = actuator.measurement.q, actuator.configuration.tracking_limit
        if not abs(reference - q) <= limit:
            return (
                f'joint {actuator.name} is at {q:.4f} where its reference is {reference:.4f}, '
                f'further than tracking_limit {limit:g}: something holds or drives it'
            )
        if not abs(q - self._still_q[i]) <= STILL_SHARE * limit:
            self._still_q[i], self._still_reference[i] = q, reference
        travel = abs(reference - self._still_reference[i])
        if travel > STUCK_SHARE * limit:
            return (
                f'joint {actuator.name} stays at {q:.4f} while its reference moved by '
                f'{travel:.4f}: it is blocked, its brake is closed or its encoder is stuck'
            )
        return ''

    def _forget_still(self) -> None:
        self._still_q = [math.nan] * len(self._still_q)

    def _judge_plausibility(self, i: int, v: float) -> None:
        configuration, measurement = self.configuration.joints[i], self._actuators[i].measurement
        odd = False
        if configuration.driver == RMD_X:
            limit = CURRENT_FACTOR * configuration.current_limit + CURRENT_SLACK
            odd = abs(measurement.current) > limit
            difference = abs(v - measurement.speed)
            odd = odd or difference > SPEED_SLACK + SPEED_FACTOR * abs(measurement.speed)
        odd = odd or bool(self._actuators[i].doubt())
        self._implausible[i] = self._implausible[i] + 1 if odd else 0

    def _implausibility(self, i: int) -> str:
        if self._implausible[i] < IMPLAUSIBLE_CYCLES:
            return ''
        actuator = self._actuators[i]
        return actuator.doubt() or (
            f'joint {actuator.name} reports {actuator.measurement.current:.2f} A and '
            f'{actuator.measurement.speed:.2f} per second, its position says {self._v[i]:.2f} and '
            f'its limit {actuator.configuration.current_limit:g} A: its sensors or its own limits '
            'are wrong'
        )

    def _too_fast(self, i: int) -> str:
        limit = 1.2 * self._limits[i].velocity
        if abs(self._v[i]) > limit:
            return (
                f'joint {self._actuators[i].name} moves at {self._v[i]:.3f} per second, above 1.2 '
                f'times its limit {self._limits[i].velocity:g}'
            )
        return ''


def check_limits(robot: Robot) -> None:
    """
    Refuse limits that limit nothing: every comparison with NaN is false.

    :raises ConfigurationError: with the joint and its limit.
    """
    for name, own in zip(robot.names, robot.limits, strict=True):
        for what, value in (('velocity', own.velocity), ('effort', own.effort)):
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigurationError(
                    f'the URDF gives joint {name} the {what} limit {value:g}: give a positive '
                    'number'
                )
        if not (math.isfinite(own.lower) and math.isfinite(own.upper) and own.lower < own.upper):
            raise ConfigurationError(
                f'the URDF limits joint {name} to {own.lower:g} to {own.upper:g}: give two '
                'numbers, the lower one first'
            )


def make_actuators(
    configuration: DriverConfiguration, limits: Sequence[JointLimits]
) -> list[Actuator]:
    """
    Build the actuator of each joint.

    :raises ConfigurationError: if two of them answer from the same identifier.
    """
    actuators = [
        _make_actuator(joint, limit, configuration)
        for joint, limit in zip(configuration.joints, limits, strict=True)
    ]
    by_id: dict[int, str] = {}
    for actuator in actuators:
        other = by_id.setdefault(actuator.reply_id, actuator.name)
        if other != actuator.name:
            raise ConfigurationError(
                f'joints {other} and {actuator.name} both answer from {actuator.reply_id:#05x}: '
                'give each its own identifier'
            )
    return actuators


def _make_actuator(
    joint: JointConfiguration, limits: JointLimits, configuration: DriverConfiguration
) -> Actuator:
    rate, margin = configuration.rate, configuration.limit_margin
    if joint.driver == RMD_X:
        return RmdXActuator(
            joint,
            limits,
            rate,
            margin=margin,
            stop_deceleration=configuration.stop_deceleration,
        )
    return ServoActuator(joint, limits, rate, margin=margin)


def bus_load(
    actuators: Sequence[Actuator], configuration: DriverConfiguration
) -> tuple[float, str]:
    """Return the worst share of the bit rate the cycle takes, and it as a sentence."""
    frames = sum(actuator.frames_per_cycle for actuator in actuators)
    least, worst = (
        frames * configuration.rate * bits / configuration.bitrate
        for bits in (FRAME_BITS, FRAME_BITS_STUFFED)
    )
    text = (
        f'{frames:g} frames per cycle at {configuration.rate:g} Hz of {FRAME_BITS} to '
        f'{FRAME_BITS_STUFFED} bits take {100 * least:.1f} to {100 * worst:.1f} % of '
        f'{configuration.bitrate} bit/s'
    )
    return worst, text


def check_bus_load(actuators: Sequence[Actuator], configuration: DriverConfiguration) -> None:
    """
    Refuse a cycle that does not fit the bus.

    :raises ConfigurationError: with the arithmetic.
    """
    worst, text = bus_load(actuators, configuration)
    if worst > 1.0:
        raise ConfigurationError(f'{text}: lower rate or raise can_bitrate')
