# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An RMD-X motor as a joint's actuator, by its current, speed or position loop."""

import math
from collections.abc import Hashable
from dataclasses import replace
from typing import Any

from sosml_friction.actuators.actuator import RESTART_DISTANCE
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.bus.inquiry import FoundActuator, Inquiry
from sosml_friction.actuators.driver.start_up import Request
from sosml_friction.actuators.measurement import Setpoint
from sosml_friction.actuators.plausibility import Plausibility
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.commands import Protocol
from sosml_friction.actuators.rmd_x.configuration import (
    POSITION_MODE,
    SPEED_MODE,
    STOP_AT_END,
    RmdXConfiguration,
)
from sosml_friction.actuators.rmd_x.emulated import EmulatedRmdX
from sosml_friction.actuators.rmd_x.scan import scan_motors
from sosml_friction.actuators.rmd_x.start_up import RmdXStartUp
from sosml_friction.exceptions import CanProtocolError
from sosml_friction.model.robot import JointLimits

STATUS_PERIOD_NS = 100_000_000
UPTIME_PERIOD_NS = 1_000_000_000
# A motor may take 150 ms for the answer to a brake command.
BRAKE_PATIENCE_NS = 1_000_000_000
# Uptimes differ from the host's clock by this much only after a restart [s].
_UPTIME_SLACK = 0.5
# The angle beside the current is in whole degrees, and a little older than the counts [rad].
_COARSE_SLACK = 0.08
# As many questions for the status without a timely answer are a fault: half a second.
_STATUS_LOST = 5
# These are answered by what they were asked with.
_ECHOED = (
    rmd_x.Command.SHUTDOWN,
    rmd_x.Command.STOP,
    rmd_x.Command.BRAKE_RELEASE,
    rmd_x.Command.BRAKE_LOCK,
    rmd_x.Command.TIMEOUT,
)
# Here an echo would mean 0, which is a good answer.
_AMBIGUOUS = (rmd_x.Command.ANGLE, rmd_x.Command.ENCODER, rmd_x.Command.UPTIME)


class RmdXActuator(RmdXStartUp):
    """
    Drive one RMD-X: a command and the position every cycle, 0x9A ten times and 0xB1 once a second.

    The command is 0xA1 (current) in mode torque, 0xA2 (speed) in mode speed with
    v_ref + position_gain * (q_ref - q), 0xA4 (position) in mode position; the position is 0x92,
    or 0x60 where ``counts_per_turn`` is given. A free joint is commanded 0 A by 0xA1 in every
    mode: no torque, and the reply brings iq. Effort is direction * torque_constant * iq as the
    motor reports it, never the command.
    """

    configuration_type = RmdXConfiguration
    emulated_type = EmulatedRmdX

    def __init__(
        self, configuration: RmdXConfiguration, limits: JointLimits, rate: float, **rest: Any
    ) -> None:
        super().__init__(configuration, limits, rate, **rest)
        self._step = configuration.current_rate_limit / rate
        self._limit = min(
            configuration.current_limit, limits.effort / configuration.torque_constant
        )
        self._last_current = 0.0
        self._status_due_ns = self._uptime_due_ns = 0
        self._status_unanswered = 0
        self._errors = rmd_x.ErrorFlag(0)
        self._counts_differ = 0.0
        self._boot_ns: int | None = None
        self._brake_asked = self._brake_waits = False
        self._brake_problem = ''
        self._zero = self.request(rmd_x.SetCurrent(0.0))

    @classmethod
    def speaks_unasked(cls, frame: Frame) -> bool:
        """Tell whether it is 0xF1, by which a motor says that its watchdog has tripped."""
        return frame.data[:1] == bytes([rmd_x.Command.TIMEOUT_EXPIRED])

    @classmethod
    def scan(cls, inquiry: Inquiry) -> list[FoundActuator]:
        return scan_motors(inquiry, cls.configuration_type.driver)

    @property
    def request_ids(self) -> frozenset[int]:
        own = self.configuration.can_id
        return frozenset(
            {rmd_x.REQUEST_BASE + own, rmd_x.BROADCAST_ID, rmd_x.MOTION_REQUEST_BASE + own}
        )

    @property
    def frames_per_cycle(self) -> float:
        share = 2.0 / self.rate
        return 4.0 + share * 1e9 * (1.0 / STATUS_PERIOD_NS + 1.0 / UPTIME_PERIOD_NS)

    def probe(self) -> list[Request]:
        return [self.ask_status]

    # ---- the cycle

    def command(self, setpoint: Setpoint, now_ns: int) -> list[Request]:
        mode = self.configuration.mode
        if mode == SPEED_MODE:
            first = self._speed_request(setpoint)
        elif mode == POSITION_MODE:
            first = self._position_request(setpoint)
        else:
            first = self._current_request(setpoint.effort)
        requests = self._with_status(first, now_ns)
        if self.configuration.brake and not self._brake_asked:
            self._brake_asked = self._brake_waits = True
            requests.insert(0, self.request(rmd_x.ReleaseBrake(), BRAKE_PATIENCE_NS))
        return requests

    def _current_request(self, effort: float) -> Request:
        configuration = self.configuration
        current = configuration.direction * effort / configuration.torque_constant
        if not math.isfinite(current):
            raise CanProtocolError(f'joint {self.name}: the effort {effort} is not finite')
        current = min(max(current, -self._limit), self._limit)
        low, high = self._last_current - self._step, self._last_current + self._step
        current = min(max(current, low), high)
        self._last_current = current
        return self.request(rmd_x.SetCurrent(current))

    def _speed_request(self, setpoint: Setpoint) -> Request:
        q, limits = self.measurement.q, self.limits
        speed = setpoint.velocity + self.configuration.position_gain * (setpoint.position - q)
        if not math.isfinite(speed):
            raise CanProtocolError(f'joint {self.name}: the speed {speed} is not finite')
        # What can still stop before the limit.
        up = math.sqrt(2.0 * self.stop_deceleration * max(0.0, limits.upper - q))
        down = math.sqrt(2.0 * self.stop_deceleration * max(0.0, q - limits.lower))
        speed = min(max(speed, -min(limits.velocity, down)), min(limits.velocity, up))
        return self.request(rmd_x.SetSpeed(self.configuration.direction * speed))

    def _position_request(self, setpoint: Setpoint) -> Request:
        if not math.isfinite(setpoint.position):
            raise CanProtocolError(
                f'joint {self.name}: the position {setpoint.position} is not finite'
            )
        limits = self.limits
        target = min(max(setpoint.position, limits.lower), limits.upper)
        angle = self.configuration.direction * (target - self._zero_of_angle())
        # Positions are commanded in 0x92's angle.
        return self.request(rmd_x.SetPosition(angle + self.counts_turns, limits.velocity))

    def _zero_of_angle(self) -> float:
        return self.configuration.zero_offset + self._turn_offset

    def observe(self, now_ns: int) -> list[Request]:
        return self._with_status(self.request(rmd_x.ReadMotion()), now_ns)

    def release(self, now_ns: int) -> list[Request]:
        """Command 0 A at once, without the rate limit."""
        self._last_current = 0.0
        self._brake_asked = self._brake_waits = False
        self._brake_problem = ''
        return self._with_status(self._zero, now_ns)

    def _with_status(self, first: Request, now_ns: int) -> list[Request]:
        requests = [first, self.ask_angle]
        if now_ns >= self._status_due_ns:
            self._status_due_ns = now_ns + STATUS_PERIOD_NS
            self._status_unanswered += 1
            requests.append(self.ask_status)
        if now_ns >= self._uptime_due_ns:
            self._uptime_due_ns = now_ns + UPTIME_PERIOD_NS
            requests.append(self.ask_uptime)
        return requests

    def shut_down(self) -> list[Request]:
        self._last_current = 0.0
        stop = self.configuration.at_end == STOP_AT_END
        requests = [self._zero, self.request(rmd_x.Stop() if stop else rmd_x.Shutdown())]
        if self.configuration.brake:
            requests.append(self.request(rmd_x.LockBrake(), BRAKE_PATIENCE_NS))
        return requests

    # ---- replies

    def key(self, frame: Frame) -> Hashable:
        """Return (identifier, command byte): the protocol has no sequence number."""
        if len(frame.data) != 8:
            raise CanProtocolError(
                f'frame {frame} has {len(frame.data)} bytes where RMD-X sends 8'
            )
        return frame.can_id, frame.data[0]

    def unsolicited(self, frame: Frame) -> bool:
        if not self.speaks_unasked(frame):
            return False
        self.timeouts += 1
        return True

    def is_echo(self, request: Request, frame: Frame) -> bool:
        """
        Tell whether the motor only echoed: its watchdog had tripped, and this woke it up.

        An answer that equals its question by chance needs 0 degC, no current, no speed and 0
        degrees at once; it costs one cycle.
        """
        command = frame.data[0]
        if frame.data != request.frame.data or command in _ECHOED or command in _AMBIGUOUS:
            return False
        self.timeouts += 1
        return True

    def accept(self, frame: Frame, stamp_ns: int) -> None:
        _, reply = rmd_x.decode_reply(frame, self.protocol or Protocol.V3)
        counts_used, measurement = self.configuration.counts_per_turn, self.measurement
        match reply:
            case rmd_x.Motion():
                self._take_motion(reply)
            case rmd_x.Angle(angle=angle):
                self.angle = angle
                if not counts_used:
                    self._take_position(angle, angle / rmd_x.ANGLE_RESOLUTION, stamp_ns)
            case rmd_x.Encoder(counts=counts):
                self._take_position(self.counted(counts), float(counts), stamp_ns)
            case rmd_x.Status():
                measurement.voltage = reply.voltage
                measurement.temperature = float(reply.temperature)
                self._errors = reply.errors
                self._status_unanswered = 0
            case rmd_x.Uptime(milliseconds=milliseconds):
                self._take_uptime(milliseconds, stamp_ns)
            case rmd_x.Version(date=date):
                self.date = date
                measurement.firmware = str(date)
            case rmd_x.Model(name=name):
                self.blocks[1] = name
            case rmd_x.ModelBlock(block=block, text=text):
                self.blocks[block] = text
            case _ if isinstance(reply, rmd_x.ReleaseBrake):
                self._brake_waits = False

    def _take_motion(self, reply: rmd_x.Motion) -> None:
        configuration, measurement = self.configuration, self.measurement
        measurement.current = reply.current
        measurement.tau = configuration.direction * configuration.torque_constant * reply.current
        measurement.temperature = float(reply.temperature)
        measurement.speed = configuration.direction * reply.speed
        if configuration.counts_per_turn:
            self._counts_differ = math.remainder(
                reply.angle - self.counted(measurement.position_raw), 2.0 * math.pi
            )

    def _take_position(self, angle: float, raw: float, stamp_ns: int) -> None:
        measurement = self.measurement
        measurement.q = self.configuration.direction * angle + self._zero_of_angle()
        measurement.position_raw = raw
        measurement.stamp_ns = stamp_ns

    def _take_uptime(self, milliseconds: int, stamp_ns: int) -> None:
        self.measurement.uptime = milliseconds * 1e-3
        boot_ns = stamp_ns - milliseconds * 1_000_000
        # The two clocks drift apart slowly; a restart moves the origin at once.
        if self._boot_ns is not None and boot_ns - self._boot_ns > _UPTIME_SLACK * 1e9:
            self.restarts += 1
        self._boot_ns = boot_ns

    def overdue(self, key: Hashable) -> None:
        super().overdue(key)
        if key == (self.reply_id, int(rmd_x.Command.BRAKE_RELEASE)):
            self._brake_problem = (
                f'joint {self.name}: the brake did not answer within '
                f'{BRAKE_PATIENCE_NS * 1e-9:g} s (0x77)'
            )

    def waiting(self) -> str:
        return f'the brake of joint {self.name} is opening' if self._brake_waits else ''

    def plausibility(self) -> Plausibility:
        return replace(super().plausibility(), current=self.configuration.current_limit)

    def doubt(self, v: float = math.nan, step: float = 0.0, seconds: float = 0.0) -> str:
        """Return also that counts and the motor's own angle differ: at zero any scale would do."""
        if abs(self._counts_differ) > _COARSE_SLACK:
            return (
                f'joint {self.name}: its angle by counts (0x60) and by the motor differ by '
                f'{self._counts_differ:.3f}: correct {self.name}.counts_per_turn, or set it to 0'
            )
        return super().doubt(v, step, seconds)

    def restart_distance(self) -> float:
        """Return half a motor turn, where its gear ratio is known and that is less."""
        ratio = self.configuration.gear_ratio
        return min(RESTART_DISTANCE, math.pi / ratio) if ratio > 0.0 else RESTART_DISTANCE

    def flags(self) -> str:
        return rmd_x.flag_names(self._errors)

    def warning(self) -> str:
        return self.watchdog_off

    def error(self) -> str:
        """Return the motor's error bits, its silence about them, or the brake's, as a sentence."""
        if self._errors:
            return f'joint {self.name}: the motor reports {rmd_x.flag_names(self._errors)}'
        if self._status_unanswered > _STATUS_LOST:
            return (
                f'joint {self.name}: the motor has not told its status (0x9A) in time '
                f'{self._status_unanswered - 1} times in a row: its errors are not known, and '
                'what it answers besides may be answers to earlier questions'
            )
        return self._brake_problem
