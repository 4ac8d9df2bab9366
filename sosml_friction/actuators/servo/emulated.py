# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A position servo behind its CAN bridge, emulated."""

import math
from dataclasses import dataclass

import numpy as np

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.emulator.emulated_actuator import EmulatedActuator
from sosml_friction.actuators.parameter import parameter
from sosml_friction.actuators.servo.configuration import ServoConfiguration
from sosml_friction.actuators.servo.dbc import Mode, ServoDbc, ServoFlag, ServoState
from sosml_friction.exceptions import CanProtocolError

LOOP_PERIOD_NS = 1_000_000


@dataclass(frozen=True)
class ServoOptions:
    """Say how good an emulated servo is; noises are standard deviations of white noise."""

    servo_current_noise: float = parameter("noise of the servo's current sensor", 0.005, unit='A')
    servo_encoder_noise: float = parameter(
        "noise of the servo's position sensor", 5e-5, unit='rad'
    )
    servo_current_limit: float = parameter("the servo's own current limit", 5.0, unit='A')
    servo_current_available: bool = parameter('whether the servo measures its current', True)
    servo_readings: int = parameter(
        "readings of its position sensor that a step of the servo's loop averages", 16
    )
    servo_kp: float = parameter(
        "proportional gain of the servo's position loop", 320.0, unit='A/rad'
    )
    servo_kd: float = parameter(
        "derivative gain of the servo's position loop", 8.0, unit='A s/rad'
    )
    servo_velocity_filter: float = parameter(
        "time constant of the filter of the servo's own velocity; a slow one lets slow motion "
        'ripple, where friction falls with speed',
        2e-3,
        unit='s',
    )
    servo_watchdog: float = parameter(
        'time without a command after which the bridge turns the servo off', 0.05, unit='s'
    )


class EmulatedServo(EmulatedActuator):
    """
    Follow position targets with a 1 kHz proportional-derivative loop that gives a current.

    The loop averages ``servo_readings`` of its noisy sensor; the state reports position, of one
    reading, velocity and current with the DBC's resolution, the current with sensor noise or as
    "not available". The current is the mean since the last state, as the ADC of a bridge averages:
    a single sample would always meet the same phase of the target's staircase, an error
    proportional to speed that looks like viscous friction. Without a command for
    ``servo_watchdog`` the output goes off, which the status says until the next command.

    While a bit of ``status`` is set from outside the output stays off.

    Not modelled: hobby-servo dead band, PWM resolution, gear backlash, potentiometer nonlinearity.
    """

    options_type = ServoOptions

    def __init__(
        self,
        mount: ServoConfiguration,
        options: ServoOptions,
        seed: np.random.SeedSequence,
    ) -> None:
        super().__init__(mount, options, seed, current_limit=options.servo_current_limit)
        self._dbc = ServoDbc(mount.dbc, mount.dbc_map)
        self._options = options
        self._watchdog_ns = round(options.servo_watchdog * 1e9)
        self._last_frame_ns = 0
        self._loop_due_ns = 0
        self.mode = Mode.OFF
        self._target = 0.0
        self._sensor = math.nan
        self._velocity = 0.0
        self._tripped = False
        # Of the current since the last state: sum and number of steps of the grid of time.
        self._current_sum = 0.0
        self._steps = 0.0
        self._step_from_ns = 0
        self._step_ns = 1
        self.status = ServoFlag(0)

    @property
    def request_id(self) -> int:
        """Return the identifier of ``servo_command``."""
        return self._dbc.command_id

    def restart(self, t_ns: int) -> None:
        """Forget the command and the watchdog's bit."""
        self.mode = Mode.OFF
        self._commanded = 0.0
        self._tripped = False
        self._sensor = math.nan
        self._velocity = 0.0
        self._loop_due_ns = t_ns
        self._last_frame_ns = t_ns

    def trip(self, t_ns: int) -> None:
        """Turn the servo off and say so in the next state."""
        self.mode = Mode.OFF
        self._commanded = 0.0
        self._tripped = True
        self.watchdog_trips += 1

    def handle(self, frame: Frame, t_ns: int, q: float, v: float) -> Frame | None:
        """Take a command; one that cannot be decoded is not answered."""
        self.frames += 1
        try:
            command = self._dbc.decode_command(frame)
        except CanProtocolError:
            self.undecodable += 1
            return None
        self._last_frame_ns = t_ns
        tripped, self._tripped = self._tripped, False
        faults = self.status | ServoFlag(self._fault_bits())
        self.mode = Mode.OFF if faults else command.mode
        self._target = command.target
        if self.mode is Mode.OFF:
            self._commanded = 0.0
        elif self.mode is Mode.CURRENT:
            self._commanded = self._clamped(command.target)
        status = faults
        if self.mode is not Mode.OFF:
            status |= ServoFlag.OUTPUT_ON
        if tripped:
            status |= ServoFlag.WATCHDOG
        current = self._measured_current(t_ns)
        state = ServoState(
            position=self._sensed_position(q, 1),
            velocity=self._velocity,
            current=current,
            status=status,
            sequence_echo=command.sequence,
        )
        return self._dbc.encode_state(state)

    def _sensed_position(self, q: float, readings: int) -> float:
        noise = self._options.servo_encoder_noise / math.sqrt(readings)
        return self._position(q) + self._encoder_noise_of(noise)

    def _measured_current(self, t_ns: int) -> float:
        """Return the mean since the last state, with noise; NaN where it is not measured."""
        if not self._options.servo_current_available:
            return math.nan
        # The part of a step since the grid's last point counts now and not again later.
        part = max(0.0, (t_ns - self._step_from_ns) / self._step_ns - 1.0)
        steps = self._steps + part
        mean = (self._current_sum + part * self.current) / steps if steps else self.current
        self._current_sum, self._steps = -part * self.current, -part
        return mean + self._normal(self._options.servo_current_noise)

    def advance(self, share: float) -> None:
        """Let the current follow its command, and add it to the mean."""
        super().advance(share)
        self._current_sum += self.current
        self._steps += 1.0

    def control(self, t_ns: int, q: float, v: float) -> None:
        """Run the position loop each millisecond, and the watchdog."""
        self._step_ns = max(1, t_ns - self._step_from_ns)
        self._step_from_ns = t_ns
        if t_ns < self._loop_due_ns:
            return
        self._loop_due_ns = t_ns + LOOP_PERIOD_NS
        before = self._sensor
        self._sensor = self._sensed_position(q, self._options.servo_readings)
        if not math.isnan(before):
            h, filter_s = LOOP_PERIOD_NS * 1e-9, self._options.servo_velocity_filter
            rate = (self._sensor - before) / h
            share = -math.expm1(-h / filter_s) if filter_s > 0.0 else 1.0
            self._velocity += share * (rate - self._velocity)
        if self.mode is not Mode.OFF and t_ns - self._last_frame_ns > self._watchdog_ns:
            self.trip(t_ns)
        if self.mode is not Mode.OFF and (self.status or self._fault_bits()):
            self.mode = Mode.OFF
            self._commanded = 0.0
        if self.mode is Mode.POSITION:
            self._commanded = self._clamped(
                self._options.servo_kp * (self._target - self._sensor)
                - self._options.servo_kd * self._velocity
            )
