# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The firmware of an RMD-X motor, emulated."""

from __future__ import annotations

import math

import numpy as np

from sosml_friction.actuators import rmd_x
from sosml_friction.actuators.emulated_actuator import EmulatedActuator
from sosml_friction.actuators.frame import Frame
from sosml_friction.exceptions import CanProtocolError

FIRMWARE_DATE = 20220206
SUPPLY = 48.0
AMBIENT = 25.0
# Rise of the winding at steady current [K/A^2] and how long it takes [s].
THERMAL_RISE = 1.0
THERMAL_TIME = 600.0


class EmulatedRmdX(EmulatedActuator):
    """
    Answer 0xA1, 0x92, 0x9A, 0xB2, 0x80 and 0x81 as the manual says.

    iq is reported with noise and rounded to 0.01 A, the angle with encoder noise and rounded to
    0.01 degree, speed and coarse angle rounded to whole degrees. Without a frame for
    ``comm_timeout_ns`` the output goes off until the next 0xA1; 0 leaves the last command running
    for ever, as the factory setting does. ``errors`` and ``temperature`` may be set from outside.

    Not modelled: the motor's speed and position loops (0x81 here is zero current), brake, torque
    ripple, backlash, voltage sag, saturation, and the echo of the first command after a timeout.
    """

    def __init__(
        self,
        name: str,
        *,
        can_id: int,
        torque_constant: float,
        direction: int,
        zero_offset: float,
        current_limit: float,
        current_noise: float,
        encoder_noise: float,
        comm_timeout_ns: int,
        seed: np.random.SeedSequence,
    ) -> None:
        super().__init__(name, torque_constant, direction, zero_offset, current_limit, seed)
        self._id = can_id
        self._current_noise = current_noise
        self._encoder_noise = encoder_noise
        self._timeout_ns = comm_timeout_ns
        self._last_frame_ns: int | None = None
        self._thermal_ns = 0
        self.temperature = AMBIENT
        self.errors = rmd_x.ErrorFlag(0)
        self.shutdowns = 0

    @property
    def request_id(self) -> int:
        """Return 0x140 + id."""
        return rmd_x.REQUEST_BASE + self._id

    def handle(self, frame: Frame, t_ns: int, q: float, v: float) -> Frame | None:
        """Take a request; one that cannot be decoded is not answered."""
        self.frames += 1
        self._last_frame_ns = t_ns
        try:
            _, request = rmd_x.decode_request(frame)
        except CanProtocolError:
            self.undecodable += 1
            return None
        reply: rmd_x.Reply
        if isinstance(request, rmd_x.SetCurrent):
            self._commanded = self._clamped(request.current)
            x = self._position(q)
            reply = rmd_x.Motion(
                round(self.temperature),
                self.current + self._normal(self._current_noise),
                self.direction * v,
                x,
            )
        elif isinstance(request, rmd_x.ReadAngle):
            reply = rmd_x.Angle(self._position(q) + self._normal(self._encoder_noise))
        elif isinstance(request, rmd_x.ReadStatus):
            reply = rmd_x.Status(round(self.temperature), True, SUPPLY, self.errors)
        elif isinstance(request, rmd_x.ReadVersion):
            reply = rmd_x.Version(FIRMWARE_DATE)
        else:
            self._commanded = 0.0
            self.shutdowns += isinstance(request, rmd_x.Shutdown)
            reply = request
        return rmd_x.encode_reply(self._id, reply)

    def control(self, t_ns: int, q: float, v: float) -> None:
        """Watch the communication timeout and warm the winding."""
        last = self._last_frame_ns
        if (
            self._timeout_ns
            and last is not None
            and t_ns - last > self._timeout_ns
            and self._commanded != 0.0
        ):
            self._commanded = 0.0
            self.watchdog_trips += 1
        if t_ns - self._thermal_ns >= 100_000_000:
            h = (t_ns - self._thermal_ns) * 1e-9
            self._thermal_ns = t_ns
            target = AMBIENT + THERMAL_RISE * self.current * self.current
            self.temperature += -math.expm1(-h / THERMAL_TIME) * (target - self.temperature)
