# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's core: from trajectories to frames and from frames to joint samples, without ROS."""

from __future__ import annotations

import math
import threading
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from enum import Enum

import can
import numpy as np
from numpy.typing import NDArray

from sosml_friction.actuators.actuator import Actuator, Request
from sosml_friction.actuators.clock import Clock
from sosml_friction.actuators.configuration import (
    RMD_X,
    DriverConfiguration,
    JointConfiguration,
)
from sosml_friction.actuators.controller import JointController
from sosml_friction.actuators.cycle import BusCounters, BusCycle
from sosml_friction.actuators.joint_trajectory import JointTrajectory, prepare_trajectory
from sosml_friction.actuators.rmd_x_actuator import RmdXActuator
from sosml_friction.actuators.servo_actuator import ServoActuator
from sosml_friction.actuators.trajectory_follower import TrajectoryFollower
from sosml_friction.actuators.velocity import WindowedSlope
from sosml_friction.exceptions import (
    ActuatorError,
    CanProtocolError,
    ConfigurationError,
    TrajectoryError,
)
from sosml_friction.model.robot import JointLimits, Robot
from sosml_friction.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]

PROBE_TIMEOUT_NS = 200_000_000
PROBE_ATTEMPTS = 3
SHUT_DOWN_TIMEOUT_NS = 20_000_000
SHUT_DOWN_ATTEMPTS = 3

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

    ``missed``: replies that did not come, in total; ``problem``: what would fault it now, or ''.
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
    joints: tuple[JointReport, ...]


class JointDriver:
    """
    Drive and measure the joints over one CAN bus.

    :meth:`configure` asks and checks, commanding no motor; :meth:`step` runs one cycle and is to
    be called ``rate`` times a second from one thread; the other methods may be called from any
    thread. Until :meth:`enable`, torque actuators are commanded zero current (it brings back iq)
    and position actuators are off. A fault - no answer for ``missed_limit`` periods, an error
    flag, temperature, a value that is not finite, a joint outside its limits - sets all of them
    back to that and is latched with its reason until the next :meth:`enable`. As a context manager
    it ends in :meth:`shut_down`.

    :param robot: the nominal model, joints in the order of the configuration; this object alone
        may use it.
    :raises ConfigurationError: if the joints, identifiers or the bus load do not fit.
    """

    def __init__(
        self, configuration: DriverConfiguration, robot: Robot, bus: can.BusABC, clock: Clock
    ) -> None:
        if robot.names != configuration.names:
            raise ConfigurationError(
                f'the model has the joints {", ".join(robot.names)}, the driver '
                f'{", ".join(configuration.names)}: name the same, in the same order'
            )
        self.configuration = configuration
        self._clock = clock
        self._limits = robot.limits
        self._actuators = make_actuators(configuration, robot.limits)
        check_bus_load(self._actuators, configuration)
        self._cycle = BusCycle(bus, clock, self._actuators)
        gains = [
            (joint.kp, joint.kd) if joint.driver == RMD_X else (0.0, 0.0)
            for joint in configuration.joints
        ]
        self._controller = JointController(robot, *np.array(gains).T)
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
        self._silent_since: list[int | None] = [None] * n
        self._silence_ns = [0] * n
        self._missed_total = [0] * n
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

    def __enter__(self) -> JointDriver:
        return self

    def __exit__(self, *_: object) -> None:
        self.shut_down()

    def configure(self) -> None:
        """
        Ask every actuator who and where it is, without commanding any motor.

        :raises ActuatorError: if one is silent, reports a fault, or is outside its joint's limits.
        """
        for _ in range(PROBE_ATTEMPTS):
            silent: list[Actuator] = []
            for actuator in self._actuators:
                requests = actuator.probe()
                missing = self._cycle.exchange(requests, self._clock.now_ns() + PROBE_TIMEOUT_NS)
                if missing:
                    silent.append(actuator)
            if not silent:
                break
        if silent:
            raise ActuatorError(silent[0].silence())
        for actuator in self._actuators:
            problem = actuator.fault() or self._out_of_band(actuator)
            if problem:
                raise ActuatorError(problem)
        with self._lock:
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
                if math.isnan(self._v[i]):
                    raise ActuatorError(
                        f'joint {actuator.name} has no velocity yet: activate the driver and wait '
                        f'{self.configuration.velocity_window} cycles'
                    )
            self._brake(self._position(), self._v)
            self._reason = ''
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

    def follow(self, trajectory: JointTrajectory | Trajectory) -> None:
        """
        Check a trajectory as a whole and start it in the next cycle, in place of a running one.

        :raises TrajectoryError: if it does not fit, or the driver is not enabled.
        """
        with self._lock:
            if self._state is not DriverState.ENABLED:
                raise TrajectoryError(
                    f'the driver is {self._state.value}: enable it before it gets a trajectory'
                )
            position = self._position()
        if isinstance(trajectory, Trajectory):
            trajectory = JointTrajectory.from_trajectory(trajectory)
        tolerance = np.full(len(position), self.configuration.start_tolerance)
        prepared = prepare_trajectory(trajectory, self.names, self._limits, position, tolerance)
        with self._lock:
            if self._state is DriverState.ENABLED:
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
            by_actuator = self._requests(start_ns)
        requests = [request for own in by_actuator for request in own]
        deadline_ns = start_ns + round(self.configuration.reply_timeout * 1e9)
        self._commanded = True
        bus_error = ''
        try:
            missing = self._cycle.exchange(requests, deadline_ns)
        except ActuatorError as error:
            missing = {request.key for request in requests}
            bus_error = str(error)
        with self._lock:
            self._bus_error = bus_error
            return self._evaluate(by_actuator, missing, start_ns)

    def shut_down(self) -> None:
        """
        Switch all outputs off: zero current, then 0x80; servo off. Tried even on a faulty bus.

        Nothing is sent if no cycle ever ran: then nothing was commanded. Not while :meth:`step`
        runs in another thread.
        """
        with self._lock:
            self._state = DriverState.UNCONFIGURED
        if not self._commanded:
            return
        for actuator in self._actuators:
            for _ in range(SHUT_DOWN_ATTEMPTS):
                try:
                    missing = self._cycle.exchange(
                        actuator.shut_down(), self._clock.now_ns() + SHUT_DOWN_TIMEOUT_NS
                    )
                except ActuatorError:
                    continue
                if not missing:
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
                bus=self._cycle.counters,
                joints=joints,
            )

    def bus_load(self) -> str:
        """Return the bus load as a sentence with its arithmetic."""
        return bus_load(self._actuators, self.configuration)[1]

    def _requests(self, now_ns: int) -> list[list[Request]]:
        if self._state is DriverState.ENABLED:
            try:
                reference = self._follower.sample(now_ns)
                effort = self._controller.effort(reference, self._position(), self._known_v)
                return [
                    actuator.command(float(effort[i]), float(reference.q[i]), now_ns)
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
            if any(request.key in missing for request in requests):
                complete = False
                self._missed_total[i] += 1
                since = self._silent_since[i]
                self._silent_since[i] = since = start_ns if since is None else since
                self._silence_ns[i] = self._clock.now_ns() - since
            else:
                self._silent_since[i] = None
                self._silence_ns[i] = 0
                measurement = actuator.measurement
                self._v[i] = self._slopes[i].update(measurement.stamp_ns, measurement.q)
                if not math.isnan(self._v[i]):
                    self._known_v[i] = self._v[i]
            problem = self._problem(i)
            if problem:
                self._fail(problem)
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

    def _problem(self, i: int) -> str:
        actuator = self._actuators[i]
        if self._bus_error:
            return self._bus_error
        silence_ns = self._silence_ns[i]
        if silence_ns >= self.configuration.missed_limit * self.configuration.period_ns:
            return f'{actuator.silence()} (silent for {silence_ns * 1e-6:.0f} ms)'
        return actuator.fault() or self._out_of_band(actuator) or self._too_fast(i)

    def _out_of_band(self, actuator: Actuator) -> str:
        q, limits = actuator.measurement.q, actuator.limits
        margin = self.configuration.limit_margin
        # Written so that NaN is outside.
        if limits.lower - margin <= q <= limits.upper + margin:
            return ''
        excess = max(limits.lower - q, q - limits.upper)
        return (
            f'joint {actuator.name} is at {q:.4f}, {excess:.4f} outside its limits '
            f'{limits.lower:g} to {limits.upper:g}: move it back, or correct {actuator.name}.'
            'zero_offset'
        )

    def _too_fast(self, i: int) -> str:
        limit = 1.2 * self._limits[i].velocity
        if abs(self._v[i]) > limit:
            return (
                f'joint {self._actuators[i].name} moves at {self._v[i]:.3f} per second, above 1.2 '
                f'times its limit {self._limits[i].velocity:g}'
            )
        return ''


def make_actuators(
    configuration: DriverConfiguration, limits: Sequence[JointLimits]
) -> list[Actuator]:
    """
    Build the actuator of each joint.

    :raises ConfigurationError: if two of them answer from the same identifier.
    """
    actuators = [
        _make_actuator(joint, limit, configuration.rate)
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


def _make_actuator(joint: JointConfiguration, limits: JointLimits, rate: float) -> Actuator:
    if joint.driver == RMD_X:
        return RmdXActuator(joint, limits, rate)
    return ServoActuator(joint, limits, rate)


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
