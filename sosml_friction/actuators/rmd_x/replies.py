# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an RMD-X answers."""

from typing import Annotated

from sosml_friction.actuators.rmd_x import layout as wire
from sosml_friction.actuators.rmd_x.commands import (
    MOTION_COMMANDS,
    Command,
    ControlMode,
    ErrorFlag,
)
from sosml_friction.actuators.rmd_x.message import Message, bare, by_command
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.actuators.rmd_x.requests import ECHOED


class Motion(
    Message,
    command=Command.CURRENT,
    places='Bbhhh',
    sequence=('of', 'temperature', 'current', 'speed', 'angle'),
):
    """
    The standard reply to 0x9C, 0xA1, 0xA2, 0xA4 and 0xA8, of which ``of`` is one.

    ``temperature`` [degC], ``current`` iq [A], ``speed`` [rad/s] and ``angle`` [rad] of the output
    shaft in whole degrees.
    """

    temperature: Annotated[int, wire.TEMPERATURE]
    current: Annotated[float, wire.CURRENT]
    speed: Annotated[float, wire.DEGREES]
    angle: Annotated[float, wire.DEGREES]
    of: Annotated[Command, wire.answered_command(MOTION_COMMANDS, 'current and speed')] = (
        Command.CURRENT
    )


class Angle(Message, command=Command.ANGLE, places='B3xi'):
    """The reply to 0x92: multi-turn ``angle`` of the output shaft [rad], in 0.01 degree."""

    angle: Annotated[float, wire.ANGLE]


class SingleTurnAngle(Message, command=Command.SINGLE_TURN_ANGLE, places='B5xH'):
    """The reply to 0x94: ``angle`` within one turn [rad], clockwise, in 0.01 degree."""

    angle: Annotated[float, wire.ANGLE]


class Encoder(Message, command=Command.ENCODER, places='B3xi'):
    """The reply to 0x60: encoder ``counts``, from its zero."""

    counts: Annotated[int, wire.whole('encoder')]


class Status(
    Message,
    command=Command.STATUS,
    places='BbbBHH',
    sequence=('temperature', 'mos_temperature', 'brake_released', 'voltage', 'errors'),
):
    """
    The reply to 0x9A.

    ``temperature`` [degC]; ``brake_released``: the command to the brake, not a sensor; ``voltage``
    [V]; ``errors``; ``mos_temperature`` [degC]: since V4.4, 0 before.
    """

    temperature: Annotated[int, wire.TEMPERATURE]
    brake_released: Annotated[bool, wire.SWITCH]
    voltage: Annotated[float, wire.TENTHS]
    errors: Annotated[ErrorFlag, wire.ERRORS]
    mos_temperature: Annotated[int, wire.TEMPERATURE] = 0


class PhaseCurrents(Message, command=Command.PHASE_CURRENTS, places='Bbhhh'):
    """The reply to 0x9D: ``temperature`` [degC] and the currents of the phases [A]."""

    temperature: Annotated[int, wire.TEMPERATURE]
    a: Annotated[float, wire.CURRENT]
    b: Annotated[float, wire.CURRENT]
    c: Annotated[float, wire.CURRENT]


class Mode(Message, command=Command.MODE, places='B6xB'):
    """The reply to 0x70: which loop runs."""

    mode: Annotated[ControlMode, wire.MODE]


class Power(Message, command=Command.POWER, places='B5xH'):
    """The reply to 0x71: electrical ``power`` [W]."""

    power: Annotated[float, wire.TENTHS]


class Uptime(Message, command=Command.UPTIME, places='B3xI'):
    """The reply to 0xB1: time since power-up [ms]; it tells a reboot."""

    milliseconds: Annotated[int, wire.whole('uptime')]


class Version(Message, command=Command.VERSION, places='B3xI'):
    """The reply to 0xB2: the firmware's date as a decimal number, 20220206 or 2026042402."""

    date: Annotated[int, wire.whole('version')]


class Model(Message, command=Command.MODEL, places='B7s'):
    """The reply to 0xB5 up to V4.3: the model's name, up to 7 characters."""

    name: Annotated[str, wire.characters(7)]


class ModelBlock(Message, command=Command.MODEL, places='BxB5s'):
    """The reply to 0xB5 since V4.4: block 1 to 3 of the model's name, up to 5 characters."""

    block: Annotated[int, wire.whole('block')]
    text: Annotated[str, wire.characters(5)]

    def pack(self) -> bytes:
        """Return block and characters."""
        data = bytearray(super().pack())
        data[1] = 1
        return bytes(data)


TimeoutExpired = bare('TimeoutExpired', Command.TIMEOUT_EXPIRED)
"""0xF1, unasked, about once a second: the motor's watchdog has switched its output off."""


_COMMON = {
    **by_command(
        *ECHOED, Angle, SingleTurnAngle, Encoder, Status, PhaseCurrents, Mode, Power, Uptime,
        Version, Model, TimeoutExpired,
    ),
    **{int(command): Motion for command in MOTION_COMMANDS},
}  # fmt: skip
REPLIES = {
    Protocol.V3: _COMMON,
    Protocol.V4_2: _COMMON,
    Protocol.V4_4: {**_COMMON, **by_command(ModelBlock)},
}
