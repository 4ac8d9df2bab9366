# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An RMD-X motor as a joint's actuator, in current mode."""

from __future__ import annotations

import math
from collections.abc import Hashable

from sosml_friction.actuators import rmd_x
from sosml_friction.actuators.actuator import Actuator, Request
from sosml_friction.actuators.configuration import JointConfiguration
from sosml_friction.actuators.frame import Frame
from sosml_friction.exceptions import CanProtocolError
from sosml_friction.model.robot import JointLimits

STATUS_PERIOD_NS = 100_000_000


class RmdXActuator(Actuator):
    """
    Drive one RMD-X: 0xA1 (current) and 0x92 (angle) every cycle, 0x9A (status) ten times a second.

    A free joint is commanded 0 A by 0xA1 as well: no torque, and the reply brings iq. Before the
    first cycle only 0xB2, 0x9A and 0x92 are asked. Effort is direction * torque_constant * iq as
    the motor reports it, never the command.
    """

    def __init__(
        self, configuration: JointConfiguration, limits: JointLimits, rate: float
    ) -> None:
        super().__init__(configuration, limits)
        self._id = configuration.can_id
        self._step = configuration.current_rate_limit / rate
        self._limit = min(
            configuration.current_limit, limits.effort / configuration.torque_constant
        )
        self._last_current = 0.0
        self._status_due_ns = 0
        self._errors = rmd_x.ErrorFlag(0)
        self._cycle_frames = 4.0 + 2.0 * 1e9 / STATUS_PERIOD_NS / rate
        zero = rmd_x.encode_request(self._id, rmd_x.SetCurrent(0.0))
        self._zero = Request(zero, (self.reply_id, rmd_x.Command.CURRENT))
        self._ask_angle = self._plain(rmd_x.ReadAngle(), rmd_x.Command.ANGLE)
        self._ask_status = self._plain(rmd_x.ReadStatus(), rmd_x.Command.STATUS)

    def _plain(self, request: rmd_x.Request, command: rmd_x.Command) -> Request:
        return Request(rmd_x.encode_request(self._id, request), (self.reply_id, command))

    @property
    def reply_id(self) -> int:
        """Return 0x240 + id."""
        return rmd_x.REPLY_BASE + self._id

    @property
    def frames_per_cycle(self) -> float:
        """Return 4 and the share of the status."""
        return self._cycle_frames

    def probe(self) -> list[Request]:
        """Ask version, status and angle."""
        return [
            self._plain(rmd_x.ReadVersion(), rmd_x.Command.VERSION),
            self._ask_status,
            self._ask_angle,
        ]

    def command(self, effort: float, position: float, now_ns: int) -> list[Request]:
        """Command the current of ``effort``, limited in size and rate."""
        configuration = self.configuration
        current = configuration.direction * effort / configuration.torque_constant
        if not math.isfinite(current):
            raise CanProtocolError(f'joint {self.name}: the effort {effort} is not finite')
        current = min(max(current, -self._limit), self._limit)
        low, high = self._last_current - self._step, self._last_current + self._step
        current = min(max(current, low), high)
        self._last_current = current
        frame = rmd_x.encode_request(self._id, rmd_x.SetCurrent(current))
        return self._with_status(Request(frame, self._zero.key), now_ns)

    def release(self, now_ns: int) -> list[Request]:
        """Command 0 A at once, without the rate limit."""
        self._last_current = 0.0
        return self._with_status(self._zero, now_ns)

    def _with_status(self, first: Request, now_ns: int) -> list[Request]:
        if now_ns < self._status_due_ns:
            return [first, self._ask_angle]
        self._status_due_ns = now_ns + STATUS_PERIOD_NS
        return [first, self._ask_angle, self._ask_status]

    def shut_down(self) -> list[Request]:
        """Command 0 A, then 0x80."""
        self._last_current = 0.0
        return [self._zero, self._plain(rmd_x.Shutdown(), rmd_x.Command.SHUTDOWN)]

    def key(self, frame: Frame) -> Hashable:
        """Return (identifier, command byte): the protocol has no sequence number."""
        if len(frame.data) != 8:
            raise CanProtocolError(
                f'frame {frame} has {len(frame.data)} bytes where RMD-X sends 8'
            )
        return frame.can_id, frame.data[0]

    def accept(self, frame: Frame, stamp_ns: int) -> None:
        """Take iq from 0xA1, position from 0x92 and the rest from 0x9A."""
        _, reply = rmd_x.decode_reply(frame)
        configuration, measurement = self.configuration, self.measurement
        if isinstance(reply, rmd_x.Motion):
            measurement.current = reply.current
            measurement.tau = (
                configuration.direction * configuration.torque_constant * reply.current
            )
            measurement.temperature = float(reply.temperature)
        elif isinstance(reply, rmd_x.Angle):
            measurement.q = configuration.direction * reply.angle + configuration.zero_offset
            measurement.stamp_ns = stamp_ns
        elif isinstance(reply, rmd_x.Status):
            measurement.voltage = reply.voltage
            measurement.temperature = float(reply.temperature)
            self._errors = reply.errors
        elif isinstance(reply, rmd_x.Version):
            measurement.firmware = str(reply.date)

    def flags(self) -> str:
        """Return the motor's error bits as words."""
        return rmd_x.flag_names(self._errors)

    def fault(self) -> str:
        """Return the motor's error bits or an excess of temperature as a sentence."""
        if self._errors:
            return f'joint {self.name}: the motor reports {rmd_x.flag_names(self._errors)}'
        if self.measurement.temperature > self.configuration.temperature_limit:
            return (
                f'joint {self.name}: {self.measurement.temperature:.0f} degC is above '
                f'{self.configuration.temperature_limit:g}'
            )
        return ''
