# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A position servo behind a CAN bridge as a joint's actuator."""

import math
from collections.abc import Hashable
from typing import Any

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.bus.inquiry import FoundActuator, Inquiry
from sosml_friction.actuators.driver.start_up import Check, Request, Step
from sosml_friction.actuators.measurement import Setpoint
from sosml_friction.actuators.servo.configuration import ServoConfiguration
from sosml_friction.actuators.servo.dbc import (
    SERVO_FAULTS,
    Mode,
    ServoCommand,
    ServoDbc,
    ServoFlag,
    flag_names,
)
from sosml_friction.actuators.servo.emulated import EmulatedServo
from sosml_friction.exceptions import CanProtocolError
from sosml_friction.model.robot import JointLimits


class ServoActuator(Actuator):
    """
    Drive one servo in position mode: one command and one state per cycle.

    A free joint is commanded mode off. The target stays within the URDF's limits and moves no
    faster than the URDF's velocity. Effort is direction * torque_constant * measured current, NaN
    where the bridge measures none. The servo limits its own current.
    """

    configuration_type = ServoConfiguration
    emulated_type = EmulatedServo
    configuration: ServoConfiguration

    def __init__(
        self, configuration: ServoConfiguration, limits: JointLimits, rate: float, **rest: Any
    ) -> None:
        super().__init__(configuration, limits, rate, **rest)
        self._dbc = ServoDbc(configuration.dbc, configuration.dbc_map)
        self._step = limits.velocity / rate
        self._sequence = 0
        self._target: float | None = None
        self._status = ServoFlag(0)

    @classmethod
    def scan(cls, inquiry: Inquiry) -> list[FoundActuator]:
        """Tell the bridge of ``inquiry.dbc`` "off": it answers nothing else."""
        if not inquiry.dbc:
            return []
        dbc = ServoDbc(inquiry.dbc)
        command = dbc.encode_command(ServoCommand(Mode.OFF, 1))
        for _ in range(2):
            for frame in inquiry.ask({dbc.state_id: command})[:1]:
                found = FoundActuator(dbc.command_id, cls.configuration_type.driver)
                try:
                    state = dbc.decode_state(frame)
                except CanProtocolError as error:
                    found.remarks.append(str(error))
                    return [found]
                found.errors = flag_names(state.status)
                if math.isnan(state.current):
                    found.remarks.append(
                        'it measures no current: effort and friction stay unknown'
                    )
                return [found]
        return []

    @property
    def reply_id(self) -> int:
        return self._dbc.state_id

    @property
    def request_ids(self) -> frozenset[int]:
        return frozenset({self._dbc.command_id})

    @property
    def frames_per_cycle(self) -> float:
        return 2.0

    def _request(self, mode: Mode, target: float = 0.0) -> Request:
        self._sequence = (self._sequence + 1) % self._dbc.sequence_count
        frame = self._dbc.encode_command(ServoCommand(mode, self._sequence, target))
        return Request(frame, (self.reply_id, self._sequence))

    def start_up(self, *, read_only: bool, watchdog: bool = True) -> list[Step]:
        return [
            Step('status', self.probe, self._check_status),
            Step('position', list, self._check_position),
        ]

    def _check_status(self) -> Check:
        current = self.measurement.current
        text = f'flags: {self.flags()}, current '
        text += 'not available' if math.isnan(current) else f'{current:.3f} A'
        return Check(self.name, 'status', text, self.fault(), self.warning())

    def warning(self) -> str:
        if not math.isnan(self.measurement.current):
            return ''
        return (
            f'joint {self.name}: the bridge measures no current: its effort, and with it the '
            'friction of this joint, is not available'
        )

    def _check_position(self) -> Check:
        problem = self.out_of_band()
        where = 'outside' if problem else 'inside its limits'
        return Check(self.name, 'position', f'{self.measurement.q:.4f}, {where}', problem)

    def probe(self) -> list[Request]:
        """Ask by commanding off: the bridge answers nothing else."""
        return [self._request(Mode.OFF)]

    def command(self, setpoint: Setpoint, now_ns: int) -> list[Request]:
        position = setpoint.position
        if not math.isfinite(position):
            raise CanProtocolError(f'joint {self.name}: the position {position} is not finite')
        start = self.measurement.q if self._target is None else self._target
        target = min(max(position, start - self._step), start + self._step)
        target = min(max(target, self.limits.lower), self.limits.upper)
        self._target = target
        return [self._position_request(target)]

    def _position_request(self, target: float) -> Request:
        configuration = self.configuration
        return self._request(
            Mode.POSITION, configuration.direction * (target - configuration.zero_offset)
        )

    def observe(self, now_ns: int) -> list[Request]:
        """Command the last target again: the bridge answers nothing else."""
        if self._target is None:
            return self.release(now_ns)
        return [self._position_request(self._target)]

    def release(self, now_ns: int) -> list[Request]:
        self._target = None
        return [self._request(Mode.OFF)]

    def shut_down(self) -> list[Request]:
        return self.release(0)

    def key(self, frame: Frame) -> Hashable:
        return frame.can_id, self._dbc.decode_state(frame).sequence_echo

    def accept(self, frame: Frame, stamp_ns: int) -> None:
        state = self._dbc.decode_state(frame)
        configuration, measurement = self.configuration, self.measurement
        measurement.q = configuration.direction * state.position + configuration.zero_offset
        measurement.current = state.current
        measurement.tau = configuration.direction * configuration.torque_constant * state.current
        measurement.position_raw = state.position / self._dbc.position_resolution
        measurement.speed = configuration.direction * state.velocity
        measurement.stamp_ns = stamp_ns
        self._status = state.status

    def flags(self) -> str:
        return flag_names(self._status)

    def error(self) -> str:
        faults = self._status & SERVO_FAULTS
        # The watchdog's bit counts while a target is out: then the bridge has dropped the joint.
        if self._target is not None:
            faults |= self._status & ServoFlag.WATCHDOG
        if not faults:
            return ''
        return f'joint {self.name}: the servo bridge reports {flag_names(faults)}'
