# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An RMD-X motor as a joint's actuator, by its current, speed or position loop."""

from __future__ import annotations

import math
from collections.abc import Hashable

from sosml_friction.actuators.actuator import Actuator, Setpoint
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.configuration import (
    MOTOR_TURN,
    OUTPUT_TURN,
    POSITION_MODE,
    SPEED_MODE,
    STOP_AT_END,
    JointConfiguration,
)
from sosml_friction.actuators.driver.start_up import Check, Request, Step
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x import motion_mode as rmd_x_motion
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.actuators.rmd_x.turns import lost_turns
from sosml_friction.exceptions import CanProtocolError
from sosml_friction.model.robot import JointLimits

STATUS_PERIOD_NS = 100_000_000
UPTIME_PERIOD_NS = 1_000_000_000
# A motor may take 150 ms for the answer to a brake command.
BRAKE_PATIENCE_NS = 1_000_000_000
# A motor whose watchdog has tripped says so once a second.
WATCHDOG_LISTEN_NS = 1_200_000_000
# Uptimes differ from the host's clock by this much only after a restart [s].
_UPTIME_SLACK = 0.5
# Counts and angle of one position may differ by noise and by what the joint moved between [rad];
# the angle beside the current is in whole degrees, and a little older.
_SCALE_SLACK = 0.02
_COARSE_SLACK = 0.08
# So many questions for the status in a row without a timely answer are a fault: half a second.
_STATUS_LOST = 5
_MODEL_BLOCKS = 3
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


class RmdXActuator(Actuator):
    """
    Drive one RMD-X: a command and the position every cycle, 0x9A ten times and 0xB1 once a second.

    The command is 0xA1 (current) in mode torque, 0xA2 (speed) in mode speed with
    v_ref + position_gain * (q_ref - q), 0xA4 (position) in mode position; the position is 0x92,
    or 0x60 where ``counts_per_turn`` is given. A free joint is commanded 0 A by 0xA1 in every
    mode: no torque, and the reply brings iq. The start-up only reads, but for the motor's
    watchdog (0xB3) where ``motor_watchdog_ms`` asks for it.

    Effort is direction * torque_constant * iq as the motor reports it, never the command. In the
    modes speed and position the motor limits its own current: the driver can only watch iq.
    """

    def __init__(
        self,
        configuration: JointConfiguration,
        limits: JointLimits,
        rate: float,
        *,
        margin: float = 0.0,
        stop_deceleration: float = math.inf,
    ) -> None:
        super().__init__(configuration, limits)
        self._id = configuration.can_id
        self._rate = rate
        self._margin = margin
        self._deceleration = stop_deceleration
        self._step = configuration.current_rate_limit / rate
        self._limit = min(
            configuration.current_limit, limits.effort / configuration.torque_constant
        )
        self._last_current = 0.0
        self._last_speed = 0.0
        self._status_due_ns = 0
        self._uptime_due_ns = 0
        self._errors = rmd_x.ErrorFlag(0)
        self._protocol: Protocol | None = None
        self._date = 0
        self._blocks: dict[int, str] = {}
        self._angle = math.nan
        self._turn_offset = 0.0
        # 0x92 minus the angle by counts, whole turns: positions are commanded in 0x92's.
        self._counts_turns = 0.0
        self._counts_differ = 0.0
        self._status_unanswered = 0
        self._boot_ns: int | None = None
        self._watchdog_seen = 0
        self._trips = False
        self._watchdog_written = False
        self._watchdog_off = ''
        self._brake_asked = False
        self._brake_waits = False
        self._brake_problem = ''
        share = 2.0 / rate
        self._cycle_frames = 4.0 + share * 1e9 * (1.0 / STATUS_PERIOD_NS + 1.0 / UPTIME_PERIOD_NS)
        self._zero = self._request(rmd_x.SetCurrent(0.0))
        self._ask_angle = self._request(
            rmd_x.ReadEncoder() if configuration.counts_per_turn else rmd_x.ReadAngle()
        )
        self._ask_status = self._request(rmd_x.ReadStatus())
        self._ask_uptime = self._request(rmd_x.ReadUptime())

    def _request(self, request: rmd_x.Request, patience_ns: int = 0) -> Request:
        protocol = self._protocol or Protocol.V3
        frame = rmd_x.encode_request(self._id, request, protocol)
        return Request(frame, (self.reply_id, int(request.command)), patience_ns)

    @property
    def reply_id(self) -> int:
        """Return 0x240 + id."""
        return rmd_x.REPLY_BASE + self._id

    @property
    def request_ids(self) -> frozenset[int]:
        """Return 0x140 + id, that of all motors, and the motion mode's."""
        return frozenset(
            {
                rmd_x.REQUEST_BASE + self._id,
                rmd_x.BROADCAST_ID,
                rmd_x_motion.MOTION_REQUEST_BASE + self._id,
            }
        )

    @property
    def frames_per_cycle(self) -> float:
        """Return 4 and the shares of status and uptime."""
        return self._cycle_frames

    # ---- start-up

    def start_up(self, *, read_only: bool, watchdog: bool = True) -> list[Step]:
        """Return version, model, status, position and, if asked for, watchdog."""
        steps = [
            Step(
                'version',
                self._ask_version,
                self._check_version,
                lambda: self._silent('version'),
            ),
            *(self._model_step(block) for block in range(1, _MODEL_BLOCKS + 1)),
            Step(
                'status',
                lambda: [self._ask_status, self._ask_uptime],
                self._check_status,
                lambda: self._silent('status'),
            ),
            Step(
                'position',
                self._ask_position,
                self._check_position,
                lambda: self._silent('position'),
            ),
        ]
        if not watchdog:
            return steps
        wanted = self.configuration.motor_watchdog_ms
        self._watchdog_written = False
        if not wanted or read_only:
            return [*steps, self._watchdog_step(last=True)]
        write = Step(
            'watchdog written',
            self._write_watchdog,
            lambda: None,
            lambda: self._silent('watchdog written'),
        )
        return [*steps, self._watchdog_step(last=False), write, self._watchdog_step(last=True)]

    def _model_step(self, block: int) -> Step:
        def ask() -> list[Request]:
            if self._protocol is Protocol.V4_4:
                return [self._request(rmd_x.ReadModel(block))]
            return [] if block > 1 else [self._request(rmd_x.ReadModel())]

        def check() -> Check | None:
            return self._check_model() if block == _MODEL_BLOCKS else None

        return Step('model', ask, check, check, attempts=2)

    def _watchdog_step(self, *, last: bool) -> Step:
        """
        Listen and then ask: a motor that has tripped sends 0xF1, or echoes what it is asked.

        Where any time will do, one that had tripped before the first question counts too.
        """
        begun: list[int] = []

        def heard() -> bool:
            if not begun:
                begun.append(self.timeouts if self._wanted_ns() else self._watchdog_seen)
            return self.timeouts > begun[0] or (last and self._trips)

        def check() -> Check | None:
            self._trips = heard()
            self._watchdog_seen = self.timeouts
            return self._check_watchdog() if last else None

        # Asked even after 0xF1: the first question after it only wakes the motor up.
        return Step(
            'watchdog',
            lambda: [self._ask_status],
            check,
            lambda: check() if heard() else self._silent('watchdog'),
            self._watchdog_pause_ns(),
            heard,
        )

    def _wanted_ns(self) -> int:
        return self.configuration.motor_watchdog_ms * 1_000_000

    def _watchdog_pause_ns(self) -> int:
        # One that is set as wanted has tripped by then; else any time will do.
        return self._wanted_ns() * 3 // 2 + 20_000_000 if self._wanted_ns() else WATCHDOG_LISTEN_NS

    def _ask_version(self) -> list[Request]:
        self._protocol = None
        self._blocks.clear()
        return [self._request(rmd_x.ReadVersion())]

    def _check_version(self) -> Check:
        text = f'firmware {self._date}'
        try:
            self._protocol = Protocol.of_version(self._date)
        except CanProtocolError as error:
            return Check(self.name, 'version', text, problem=f'joint {self.name}: {error}')
        return Check(self.name, 'version', f'{text}, protocol {self._protocol.value}')

    def _silent(self, step: str) -> Check:
        return Check(self.name, step, 'no answer', problem=self.silence())

    def _check_model(self) -> Check:
        name = ''.join(self._blocks[block] for block in sorted(self._blocks))
        self.measurement.model = name
        if name:
            return Check(self.name, 'model', name)
        return Check(
            self.name,
            'model',
            'no answer',
            warning=f'joint {self.name}: the motor does not tell its model (0xB5)',
        )

    def _check_status(self) -> Check:
        measurement = self.measurement
        text = (
            f'{measurement.temperature:.0f} degC, {measurement.voltage:.1f} V, on for '
            f'{measurement.uptime:.1f} s, errors: {self.flags()}'
        )
        return Check(self.name, 'status', text, problem=self.fault())

    def _ask_position(self) -> list[Request]:
        # The status first: a motor whose watchdog has tripped only echoes the first question, and
        # the echo of 0x92 would be the answer "0 degrees".
        requests = [self._ask_status, self._request(rmd_x.ReadAngle())]
        # Both, where counts are used: their scale is nowhere else to be checked.
        if self.configuration.counts_per_turn:
            requests.append(self._ask_angle)
        return requests

    def _check_position(self) -> Check:
        """Bring the position into the joint's band by whole turns, if there is one way only."""
        self._set_turn_offset(0.0)
        if self.configuration.counts_per_turn:
            counted = self._counted(self.measurement.position_raw)
            rest = math.remainder(self._angle - counted, 2.0 * math.pi)
            self._counts_turns = self._angle - counted - rest
            if abs(rest) > _SCALE_SLACK:
                return Check(
                    self.name,
                    'position',
                    f'{self.measurement.position_raw:.0f} counts',
                    problem=(
                        f'joint {self.name}: {self.measurement.position_raw:.0f} counts (0x60) '
                        f'would be {counted:.4f} rad where 0x92 says {self._angle:.4f}: correct '
                        f'{self.name}.counts_per_turn, or set it to 0'
                    ),
                )
        problem = self.out_of_band(self._margin)
        if not problem:
            return Check(self.name, 'position', f'{self.measurement.q:.4f}, inside its limits')
        configuration = self.configuration
        if configuration.lost_turns not in (OUTPUT_TURN, MOTOR_TURN):
            return Check(
                self.name, 'position', f'{self.measurement.q:.4f}, outside', problem=problem
            )
        turn = 2.0 * math.pi
        if configuration.lost_turns == MOTOR_TURN:
            turn /= configuration.gear_ratio
        raw = self.measurement.q
        turns = lost_turns(raw, self.limits, self._margin, turn)
        if len(turns) != 1:
            found = (
                f'{len(turns)} numbers of turns of {turn:.4f} would bring it inside'
                if turns
                else f'no whole number of turns of {turn:.4f} brings it inside'
            )
            return Check(
                self.name, 'position', f'{raw:.4f}, outside', problem=f'{problem} ({found})'
            )
        self._set_turn_offset(turns[0] * turn)
        return Check(
            self.name,
            'position',
            f'{self.measurement.q:.4f} after {turns[0]:+d} turns of {turn:.4f}',
            warning=(
                f'joint {self.name}: its encoder had lost {-turns[0]:+d} turns of {turn:.4f}; '
                f'{raw:.4f} is taken for {self.measurement.q:.4f}'
            ),
        )

    def _set_turn_offset(self, offset: float) -> None:
        self.measurement.q += offset - self._turn_offset
        self._turn_offset = offset

    def _check_watchdog(self) -> Check:
        pause = self._watchdog_pause_ns() * 1e-9
        if self._trips:
            self._watchdog_off = ''
            return Check(self.name, 'watchdog', f'trips within {pause:.2g} s')
        self._watchdog_off = (
            f"joint {self.name}: the motor's own watchdog (0xB3) did not trip within {pause:.2g} "
            's: if this program is killed, the motor keeps its last current'
        )
        if self._watchdog_written:
            problem = f'{self._watchdog_off}; {self.name}.motor_watchdog_ms had no effect'
            return Check(self.name, 'watchdog', 'does not trip', problem=problem)
        self._watchdog_off += f': set {self.name}.motor_watchdog_ms'
        return Check(self.name, 'watchdog', 'off, or too slow', warning=self._watchdog_off)

    def _write_watchdog(self) -> list[Request]:
        """Write 0xB3, unless the motor's watchdog trips in time already: it goes to ROM."""
        if self._trips:
            return []
        self._watchdog_written = True
        return [self._request(rmd_x.SetTimeout(self.configuration.motor_watchdog_ms))]

    def probe(self) -> list[Request]:
        """Ask the status."""
        return [self._ask_status]

    # ---- the cycle

    def command(self, setpoint: Setpoint, now_ns: int) -> list[Request]:
        """Command current, speed or position, limited."""
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
            requests.insert(0, self._request(rmd_x.ReleaseBrake(), BRAKE_PATIENCE_NS))
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
        return self._request(rmd_x.SetCurrent(current))

    def _speed_request(self, setpoint: Setpoint) -> Request:
        q, limits = self.measurement.q, self.limits
        speed = setpoint.velocity + self.configuration.position_gain * (setpoint.position - q)
        if not math.isfinite(speed):
            raise CanProtocolError(f'joint {self.name}: the speed {speed} is not finite')
        # What can still stop before the limit.
        up = math.sqrt(2.0 * self._deceleration * max(0.0, limits.upper - q))
        down = math.sqrt(2.0 * self._deceleration * max(0.0, q - limits.lower))
        speed = min(max(speed, -min(limits.velocity, down)), min(limits.velocity, up))
        return self._request(rmd_x.SetSpeed(self.configuration.direction * speed))

    def _position_request(self, setpoint: Setpoint) -> Request:
        if not math.isfinite(setpoint.position):
            raise CanProtocolError(
                f'joint {self.name}: the position {setpoint.position} is not finite'
            )
        limits = self.limits
        target = min(max(setpoint.position, limits.lower), limits.upper)
        angle = self.configuration.direction * (target - self._zero_of_angle())
        return self._request(rmd_x.SetPosition(angle + self._counts_turns, limits.velocity))

    def _zero_of_angle(self) -> float:
        return self.configuration.zero_offset + self._turn_offset

    def observe(self, now_ns: int) -> list[Request]:
        """Ask 0x9C and the position."""
        return self._with_status(self._request(rmd_x.ReadMotion()), now_ns)

    def release(self, now_ns: int) -> list[Request]:
        """Command 0 A at once, without the rate limit."""
        self._last_current = 0.0
        self._brake_asked = self._brake_waits = False
        self._brake_problem = ''
        return self._with_status(self._zero, now_ns)

    def _with_status(self, first: Request, now_ns: int) -> list[Request]:
        requests = [first, self._ask_angle]
        if now_ns >= self._status_due_ns:
            self._status_due_ns = now_ns + STATUS_PERIOD_NS
            self._status_unanswered += 1
            requests.append(self._ask_status)
        if now_ns >= self._uptime_due_ns:
            self._uptime_due_ns = now_ns + UPTIME_PERIOD_NS
            requests.append(self._ask_uptime)
        return requests

    def shut_down(self) -> list[Request]:
        """Command 0 A, then 0x80 or 0x81, then the brake."""
        self._last_current = 0.0
        stop = self.configuration.at_end == STOP_AT_END
        requests = [self._zero, self._request(rmd_x.Stop() if stop else rmd_x.Shutdown())]
        if self.configuration.brake:
            requests.append(self._request(rmd_x.LockBrake(), BRAKE_PATIENCE_NS))
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
        """Take 0xF1: the motor's watchdog has tripped."""
        if not frame.data or frame.data[0] != rmd_x.Command.TIMEOUT_EXPIRED:
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
        """Take iq, position, status and what the start-up asks."""
        _, reply = rmd_x.decode_reply(frame, self._protocol or Protocol.V3)
        configuration, measurement = self.configuration, self.measurement
        if isinstance(reply, rmd_x.Motion):
            measurement.current = reply.current
            measurement.tau = (
                configuration.direction * configuration.torque_constant * reply.current
            )
            measurement.temperature = float(reply.temperature)
            measurement.speed = configuration.direction * reply.speed
            if configuration.counts_per_turn:
                self._counts_differ = math.remainder(
                    reply.angle - self._counted(measurement.position_raw), 2.0 * math.pi
                )
        elif isinstance(reply, rmd_x.Angle):
            self._angle = reply.angle
            if not configuration.counts_per_turn:
                self._take_position(reply.angle, reply.angle / rmd_x.ANGLE_RESOLUTION, stamp_ns)
        elif isinstance(reply, rmd_x.Encoder):
            angle = self._counted(reply.counts)
            self._take_position(angle, float(reply.counts), stamp_ns)
        elif isinstance(reply, rmd_x.Status):
            measurement.voltage = reply.voltage
            measurement.temperature = float(reply.temperature)
            self._errors = reply.errors
            self._status_unanswered = 0
        elif isinstance(reply, rmd_x.Uptime):
            self._take_uptime(reply.milliseconds, stamp_ns)
        elif isinstance(reply, rmd_x.Version):
            self._date = reply.date
            measurement.firmware = str(reply.date)
        elif isinstance(reply, rmd_x.Model):
            self._blocks[1] = reply.name
        elif isinstance(reply, rmd_x.ModelBlock):
            self._blocks[reply.block] = reply.text
        elif isinstance(reply, rmd_x.ReleaseBrake):
            self._brake_waits = False

    def _counted(self, counts: float) -> float:
        return 2.0 * math.pi * counts / self.configuration.counts_per_turn

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
        """Take note that the brake did not answer."""
        super().overdue(key)
        if key == (self.reply_id, int(rmd_x.Command.BRAKE_RELEASE)):
            self._brake_problem = (
                f'joint {self.name}: the brake did not answer within '
                f'{BRAKE_PATIENCE_NS * 1e-9:g} s (0x77)'
            )

    def waiting(self) -> str:
        """Return that the brake is not open yet."""
        return f'the brake of joint {self.name} is opening' if self._brake_waits else ''

    def doubt(self) -> str:
        """Return that counts and the motor's own angle differ: at zero any scale would do."""
        if not abs(self._counts_differ) > _COARSE_SLACK:
            return ''
        return (
            f'joint {self.name}: its angle by counts (0x60) and by the motor differ by '
            f'{self._counts_differ:.3f}: correct {self.name}.counts_per_turn, or set it to 0'
        )

    def flags(self) -> str:
        """Return the motor's error bits as words."""
        return rmd_x.flag_names(self._errors)

    def warning(self) -> str:
        """Return that the motor's watchdog is off."""
        return self._watchdog_off

    def fault(self) -> str:
        """Return the motor's error bits or an excess of temperature as a sentence."""
        if self._errors:
            return f'joint {self.name}: the motor reports {rmd_x.flag_names(self._errors)}'
        if self.measurement.temperature > self.configuration.temperature_limit:
            return (
                f'joint {self.name}: {self.measurement.temperature:.0f} degC is above '
                f'{self.configuration.temperature_limit:g}'
            )
        if self._status_unanswered > _STATUS_LOST:
            return (
                f'joint {self.name}: the motor has not told its status (0x9A) in time '
                f'{self._status_unanswered - 1} times in a row: its errors are not known, and '
                'what it answers besides may be answers to earlier questions'
            )
        return self._brake_problem
