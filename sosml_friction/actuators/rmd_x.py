# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The RMD-X motor protocol: bytes to physical values and back, no input or output.

Protocol V3/V4 of MyActuator ("Servo Motor Control Protocol" V4.2): 11-bit identifiers, always 8
bytes, little endian, two's complement; the host sends to 0x140 + id, the motor answers from
0x240 + id with the command byte repeated. Both directions are coded: the driver needs one, the
emulator the other. The sign is the motor's own; which way that turns the joint is the driver's
``direction``.

What the wire can carry (unit here, counts there): angle 0.01 degree int32, current 0.01 A int16,
angle and speed of the standard reply 1 degree and 1 degree/s int16, voltage 0.1 V uint16. Values
are rounded to the nearest count and saturated.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag

from sosml_friction.actuators.frame import Frame
from sosml_friction.exceptions import CanProtocolError

REQUEST_BASE = 0x140
REPLY_BASE = 0x240
MOTOR_IDS = range(1, 33)

ANGLE_RESOLUTION = math.radians(0.01)
CURRENT_RESOLUTION = 0.01
_DEGREE = math.radians(1.0)


class Command(IntEnum):
    """Byte 0 of a frame."""

    SHUTDOWN = 0x80
    STOP = 0x81
    ANGLE = 0x92
    STATUS = 0x9A
    CURRENT = 0xA1
    VERSION = 0xB2


class ErrorFlag(IntFlag):
    """Bits of the error word; several may be set, and bits of other firmware are kept."""

    STALL = 0x0002
    UNDER_VOLTAGE = 0x0004
    OVER_VOLTAGE = 0x0008
    OVER_CURRENT = 0x0010
    POWER_OVERRUN = 0x0040
    CALIBRATION_WRITE = 0x0080
    OVER_SPEED = 0x0100
    BOARD_OVER_TEMPERATURE = 0x0800
    MOTOR_OVER_TEMPERATURE = 0x1000
    ENCODER_CALIBRATION = 0x2000
    ENCODER_DATA = 0x4000


def flag_names(word: int) -> str:
    """Return the set bits as words, ``unknown 0x..`` for bits without a name, ``none`` for 0."""
    names = [flag.name.lower() for flag in ErrorFlag if word & flag and flag.name]
    unknown = word & ~sum(ErrorFlag)
    if unknown:
        names.append(f'unknown {unknown:#06x}')
    return ', '.join(names) or 'none'


@dataclass(frozen=True)
class Shutdown:
    """0x80: output off, the joint is free; the motor echoes it."""


@dataclass(frozen=True)
class Stop:
    """0x81: speed to zero, the motor's own loop holds; the motor echoes it."""


@dataclass(frozen=True)
class ReadAngle:
    """0x92: ask for the multi-turn angle."""


@dataclass(frozen=True)
class ReadStatus:
    """0x9A: ask for temperature, voltage and errors."""


@dataclass(frozen=True)
class ReadVersion:
    """0xB2: ask for the firmware's date."""


@dataclass(frozen=True)
class SetCurrent:
    """0xA1: command the torque-producing current [A]; answered by :class:`Motion`."""

    current: float


@dataclass(frozen=True)
class Motion:
    """
    The standard reply to 0xA1.

    ``temperature`` [degC], ``current`` iq [A], ``speed`` [rad/s] and ``angle`` [rad] of the output
    shaft in whole degrees.
    """

    temperature: int
    current: float
    speed: float
    angle: float


@dataclass(frozen=True)
class Angle:
    """The reply to 0x92: multi-turn ``angle`` of the output shaft [rad], in 0.01 degree."""

    angle: float


@dataclass(frozen=True)
class Status:
    """
    The reply to 0x9A.

    ``temperature`` [degC]; ``brake_released``: the command to the brake, not a sensor; ``voltage``
    [V]; ``errors``.
    """

    temperature: int
    brake_released: bool
    voltage: float
    errors: ErrorFlag


@dataclass(frozen=True)
class Version:
    """The reply to 0xB2: the firmware's date as a decimal number, 20220206 or 2026042402."""

    date: int


Request = Shutdown | Stop | ReadAngle | ReadStatus | ReadVersion | SetCurrent
Reply = Shutdown | Stop | Angle | Status | Version | Motion

_PLAIN_REQUESTS: dict[type, Command] = {
    Shutdown: Command.SHUTDOWN,
    Stop: Command.STOP,
    ReadAngle: Command.ANGLE,
    ReadStatus: Command.STATUS,
    ReadVersion: Command.VERSION,
}
_REQUESTS_BY_COMMAND = {int(command): kind for kind, command in _PLAIN_REQUESTS.items()}


def encode_request(motor_id: int, request: Request) -> Frame:
    """
    Return the frame the host sends.

    :raises CanProtocolError: if the id is not 1..32, or a value is not finite.
    """
    can_id = REQUEST_BASE + _checked_id(motor_id)
    if isinstance(request, SetCurrent):
        counts = _counts(request.current, CURRENT_RESOLUTION, 16)
        return Frame(can_id, struct.pack('<B3xhxx', Command.CURRENT, counts))
    return Frame(can_id, struct.pack('<B7x', _PLAIN_REQUESTS[type(request)]))


def decode_request(frame: Frame) -> tuple[int, Request]:
    """
    Return the motor's id and what it is asked.

    :raises CanProtocolError: if the frame is not one of the requests above.
    """
    motor_id = _id_of(frame, REQUEST_BASE)
    command = frame.data[0]
    if command == Command.CURRENT:
        (counts,) = struct.unpack_from('<h', frame.data, 4)
        return motor_id, SetCurrent(counts / 100.0)
    kind = _REQUESTS_BY_COMMAND.get(command)
    if kind is None:
        raise CanProtocolError(f'frame {frame} asks with the unknown command {command:#04x}')
    return motor_id, kind()


def encode_reply(motor_id: int, reply: Reply) -> Frame:
    """
    Return the frame the motor sends.

    :raises CanProtocolError: if the id is not 1..32, or a value is not finite.
    """
    can_id = REPLY_BASE + _checked_id(motor_id)
    if isinstance(reply, Motion):
        data = struct.pack(
            '<Bbhhh',
            Command.CURRENT,
            _counts(reply.temperature, 1.0, 8),
            _counts(reply.current, CURRENT_RESOLUTION, 16),
            _counts(reply.speed, _DEGREE, 16),
            _counts(reply.angle, _DEGREE, 16),
        )
    elif isinstance(reply, Angle):
        data = struct.pack('<B3xi', Command.ANGLE, _counts(reply.angle, ANGLE_RESOLUTION, 32))
    elif isinstance(reply, Status):
        data = struct.pack(
            '<BbxBHH',
            Command.STATUS,
            _counts(reply.temperature, 1.0, 8),
            int(reply.brake_released),
            _counts(reply.voltage, 0.1, 16, signed=False),
            int(reply.errors) & 0xFFFF,
        )
    elif isinstance(reply, Version):
        data = struct.pack(
            '<B3xI', Command.VERSION, _counts(float(reply.date), 1.0, 32, signed=False)
        )
    else:
        data = struct.pack('<B7x', _PLAIN_REQUESTS[type(reply)])
    return Frame(can_id, data)


def decode_reply(frame: Frame) -> tuple[int, Reply]:
    """
    Return the motor's id and what it says.

    :raises CanProtocolError: if the frame is not one of the replies above.
    """
    motor_id = _id_of(frame, REPLY_BASE)
    data = frame.data
    command = data[0]
    if command == Command.CURRENT:
        temperature, current, speed, angle = struct.unpack_from('<bhhh', data, 1)
        return motor_id, Motion(temperature, current / 100.0, speed * _DEGREE, angle * _DEGREE)
    if command == Command.ANGLE:
        (angle,) = struct.unpack_from('<i', data, 4)
        return motor_id, Angle(math.radians(angle / 100.0))
    if command == Command.STATUS:
        temperature, released, voltage, errors = struct.unpack_from('<bxBHH', data, 1)
        return motor_id, Status(temperature, released != 0, voltage / 10.0, ErrorFlag(errors))
    if command == Command.VERSION:
        return motor_id, Version(struct.unpack_from('<I', data, 4)[0])
    if command == Command.SHUTDOWN:
        return motor_id, Shutdown()
    if command == Command.STOP:
        return motor_id, Stop()
    raise CanProtocolError(f'frame {frame} answers with the unknown command {command:#04x}')


def _checked_id(motor_id: int) -> int:
    if motor_id not in MOTOR_IDS:
        raise CanProtocolError(f'motor id {motor_id} is not between 1 and 32')
    return motor_id


def _id_of(frame: Frame, base: int) -> int:
    motor_id = frame.can_id - base
    if motor_id not in MOTOR_IDS:
        raise CanProtocolError(
            f'frame {frame} is outside {base + 1:#05x}..{base + 32:#05x}, where the RMD-X talks'
        )
    if len(frame.data) != 8:
        raise CanProtocolError(f'frame {frame} has {len(frame.data)} bytes where RMD-X sends 8')
    return motor_id


def _counts(value: float, resolution: float, bits: int, *, signed: bool = True) -> int:
    """Return the nearest count, saturated to what ``bits`` hold."""
    counts = value / resolution
    if not math.isfinite(counts):
        raise CanProtocolError(f'the value {value} cannot be sent: it is not finite')
    low, high = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if signed else (0, (1 << bits) - 1)
    return min(max(round(counts), low), high)
