# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The firmware of an RMD-X motor, emulated."""

import math
from dataclasses import dataclass

import numpy as np

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.emulator.emulated_actuator import EmulatedActuator
from sosml_friction.actuators.parameter import parameter
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.commands import ControlMode, Protocol
from sosml_friction.actuators.rmd_x.configuration import RmdXConfiguration
from sosml_friction.exceptions import CanProtocolError

SUPPLY = 48.0
AMBIENT = 25.0
# Rise of the winding at steady current [K/A^2] and how long it takes [s].
THERMAL_RISE = 1.0
THERMAL_TIME = 600.0
# How often a motor repeats that its communication timeout has passed.
TELL_PERIOD_NS = 1_000_000_000
# An answer to the brake commands takes 50 to 150 ms.
BRAKE_NS = 80_000_000
# 0x76: measured on the real motor.
REBOOT_NS = 1_100_000_000
# The motor's own loops, tuned for an arm of 0.3 kg m2: current per error of speed [A s/rad] and
# of its integral [A/rad], speed per error of angle [1/s].
SPEED_KP = 12.0
SPEED_KI = 180.0
POSITION_KP = 15.0


@dataclass(frozen=True)
class RmdXOptions:
    """Say how good an emulated RMD-X is; noises are standard deviations of white noise."""

    rmd_current_noise: float = parameter("noise of an RMD-X's reported current", 0.03, unit='A')
    rmd_encoder_noise: float = parameter(
        "noise of an RMD-X's angle before it is rounded to 0.01 degree", 2e-5, unit='rad'
    )
    rmd_current_limit: float = parameter("an RMD-X's own current limit", 7.2, unit='A')
    comm_timeout: float = parameter(
        'time without a frame after which a motor turns off; 0: never', 0.05, unit='s'
    )
    timeout_echo: bool = parameter(
        'whether a motor that has turned off so only echoes the next request', True
    )
    rmd_gear_ratio: float = parameter("an RMD-X's motor turns per turn of its output", 8.0)
    rmd_firmware: int = parameter(
        'the version 0xB2 gives; it decides on the layout of frames', 20220206
    )
    rmd_model: str = parameter('the model 0xB5 gives', 'X6-8')
    rmd_encoder_counts: int = parameter('counts of 0x60 per turn of the output', 131072)


class EmulatedRmdX(EmulatedActuator):
    """
    Answer the motor's commands as the manual says.

    Current, speed and position mode; stop, shutdown, brake, reset; status, motion, angle,
    encoder, uptime, version, model; timeout (0xB3). iq is reported with
    noise and rounded to 0.01 A, the angle with encoder noise and rounded to 0.01 degree, speed and
    coarse angle rounded to whole degrees. Without a frame for ``comm_timeout`` the output goes
    off, the motor says 0xF1 then and every second, and the next request is only echoed
    (``timeout_echo``); 0 leaves the last command running for ever, as the factory setting does.
    ``errors`` and ``temperature`` may be set from outside; while an error bit is set the output is
    off.

    Not modelled: motion mode (0x400), gains, accelerations and limits set over CAN, active replies
    (0xB6), a brake that holds, torque ripple, backlash, voltage sag and saturation. What the codec
    has no message for is not answered.
    """

    options_type = RmdXOptions

    def __init__(
        self,
        mount: RmdXConfiguration,
        options: RmdXOptions,
        seed: np.random.SeedSequence,
    ) -> None:
        super().__init__(mount, options, seed, current_limit=options.rmd_current_limit)
        self._id = mount.can_id
        self._options = options
        self._timeout_ns = round(options.comm_timeout * 1e9)
        self._protocol = Protocol.of_version(options.rmd_firmware)
        self._last_frame_ns: int | None = None
        self._tripped = False
        self._told_ns = 0
        self._start_ns = 0
        self._thermal_ns = 0
        self._control_ns = 0
        self._mode = ControlMode.CURRENT
        self._speed_target = 0.0
        self._angle_target: float | None = None
        self._integral = 0.0
        self._output_on = False
        self._released = True
        self.temperature = AMBIENT
        self.errors = rmd_x.ErrorFlag(0)
        self.shutdowns = 0

    @property
    def request_id(self) -> int:
        return rmd_x.REQUEST_BASE + self._id

    @property
    def reported_errors(self) -> rmd_x.ErrorFlag:
        """Return the bits of 0x9A: set from outside, or by a fault."""
        return self.errors | rmd_x.ErrorFlag(self._fault_bits())

    def counters(self) -> dict[str, int]:
        return super().counters() | {'shutdowns': self.shutdowns}

    def restart(self, t_ns: int) -> None:
        self._switch_off()
        self._mode = ControlMode.CURRENT
        self._released = True
        self._tripped = False
        self._last_frame_ns = None
        self._start_ns = t_ns + self.clock_ahead_ns

    def trip(self, t_ns: int) -> None:
        """Turn the output off, say 0xF1, and take the next request for a wake-up only."""
        self.watchdog_trips += self._output_on and self._commanded != 0.0
        self._switch_off()
        self._tripped = True
        self._tell(t_ns)

    def reply_delay_ns(self, frame: Frame) -> int:
        """Return how much longer than others the answer takes: the brake is slow."""
        slow = (rmd_x.Command.BRAKE_RELEASE, rmd_x.Command.BRAKE_LOCK)
        return BRAKE_NS if frame.data[:1] in (bytes([command]) for command in slow) else 0

    def handle(self, frame: Frame, t_ns: int, q: float, v: float) -> Frame | None:
        """Take a request; one that cannot be decoded is not answered."""
        self.frames += 1
        self._last_frame_ns = t_ns
        tripped, self._tripped = self._tripped, False
        if tripped and self._options.timeout_echo:
            return Frame(rmd_x.REPLY_BASE + self._id, frame.data)
        try:
            _, request = rmd_x.decode_request(frame)
            reply = self._act(request, q, v) or self._answer(request, t_ns, q, v)
            return None if reply is None else rmd_x.encode_reply(self._id, reply, self._protocol)
        except CanProtocolError:
            self.undecodable += 1
            return None
        finally:
            if frame.data[:1] == bytes([rmd_x.Command.RESET]):
                self._dark_until_ns = t_ns + REBOOT_NS
                self.restart(self._dark_until_ns)

    def _act(self, request: rmd_x.Request, q: float, v: float) -> rmd_x.Reply | None:
        """Do what is asked, and return the reply to it, or None if it asks only."""
        if isinstance(request, rmd_x.SetCurrent):
            self._drive(ControlMode.CURRENT)
            self._commanded = self._clamped(request.current) if self._output_on else 0.0
        elif isinstance(request, rmd_x.SetSpeed):
            self._drive(ControlMode.SPEED)
            self._speed_target = request.speed
        elif isinstance(request, rmd_x.SetPosition):
            self._drive(ControlMode.POSITION)
            self._angle_target = request.angle
            self._speed_target = request.max_speed
        elif isinstance(request, rmd_x.Stop):
            if self._output_on:
                self._drive(ControlMode.SPEED)
            self._speed_target = 0.0
            return request
        elif isinstance(request, rmd_x.Shutdown):
            self._switch_off()
            self.shutdowns += 1
            return request
        elif isinstance(request, (rmd_x.ReleaseBrake, rmd_x.LockBrake)):
            self._released = isinstance(request, rmd_x.ReleaseBrake)
            if not self._released:
                self._switch_off()
            return request
        elif isinstance(request, rmd_x.SetTimeout):
            self._timeout_ns = request.milliseconds * 1_000_000
            return request
        else:
            return None
        return self._motion(type(request).command, q, v)

    def _answer(self, request: rmd_x.Request, t_ns: int, q: float, v: float) -> rmd_x.Reply | None:
        """Return the reply to a question, None if the motor has none."""
        options = self._options
        if isinstance(request, rmd_x.ReadModel):
            if self._protocol is not Protocol.V4_4:
                return rmd_x.Model(options.rmd_model[:7])
            first = 5 * (request.block - 1)
            return rmd_x.ModelBlock(request.block, options.rmd_model[first : first + 5])
        match request.command:
            case rmd_x.Command.ANGLE:
                return rmd_x.Angle(self._sensed_angle(q))
            case rmd_x.Command.ENCODER:
                turns = self._sensed_angle(q) / math.tau
                return rmd_x.Encoder(round(turns * options.rmd_encoder_counts))
            case rmd_x.Command.STATUS:
                errors = self.reported_errors
                return rmd_x.Status(round(self.temperature), self._released, SUPPLY, errors)
            case rmd_x.Command.MOTION:
                return self._motion(rmd_x.Command.MOTION, q, v)
            case rmd_x.Command.UPTIME:
                on_ns = t_ns + self.clock_ahead_ns - self._start_ns
                return rmd_x.Uptime(on_ns // 1_000_000)
            case rmd_x.Command.VERSION:
                return rmd_x.Version(options.rmd_firmware)
        return None

    def _motion(self, of: rmd_x.Command, q: float, v: float) -> rmd_x.Motion:
        return rmd_x.Motion(
            round(self.temperature),
            self.current + self._normal(self._options.rmd_current_noise),
            self.direction * v,
            self._angle(q),
            of,
        )

    def _drive(self, mode: ControlMode) -> None:
        if mode is not self._mode or not self._output_on:
            self._integral = self._commanded
        self._mode = mode
        self._angle_target = None
        self._output_on = self._released and not self.reported_errors

    def _switch_off(self) -> None:
        self._output_on = False
        self._commanded = 0.0

    def _tell(self, t_ns: int) -> None:
        self._told_ns = t_ns
        self._unsolicited.append(
            rmd_x.encode_reply(self._id, rmd_x.TimeoutExpired(), self._protocol)
        )

    def _angle(self, q: float) -> float:
        """Return where the motor takes itself to be: wrong by whole motor turns after some."""
        turns = sum(fault.number('turns') for fault in self._faults if fault.name == 'power_cycle')
        return self._position(q) + turns * math.tau / self._options.rmd_gear_ratio

    def _sensed_angle(self, q: float) -> float:
        return self._angle(q) + self._encoder_noise_of(self._options.rmd_encoder_noise)

    def control(self, t_ns: int, q: float, v: float) -> None:
        last = self._last_frame_ns
        if self.reported_errors:
            self._switch_off()
        if self._timeout_ns and last is not None and t_ns - last > self._timeout_ns:
            if not self._tripped:
                self.trip(t_ns)
            elif t_ns - self._told_ns >= TELL_PERIOD_NS:
                self._tell(t_ns)
        if self._output_on and self._mode is not ControlMode.CURRENT:
            self._run_loops((t_ns - self._control_ns) * 1e-9, q, v)
        self._control_ns = t_ns
        if t_ns - self._thermal_ns >= 100_000_000:
            h = (t_ns - self._thermal_ns) * 1e-9
            self._thermal_ns = t_ns
            target = AMBIENT + THERMAL_RISE * self.current * self.current
            self.temperature += -math.expm1(-h / THERMAL_TIME) * (target - self.temperature)

    def _run_loops(self, h: float, q: float, v: float) -> None:
        speed = self._speed_target
        if self._angle_target is not None:
            most = abs(self._speed_target)
            speed = POSITION_KP * (self._angle_target - self._angle(q))
            speed = min(max(speed, -most), most)
        error = speed - self.direction * v
        self._integral = self._clamped(self._integral + SPEED_KI * h * error)
        self._commanded = self._clamped(self._integral + SPEED_KP * error)
