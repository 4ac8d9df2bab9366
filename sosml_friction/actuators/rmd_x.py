# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The RMD-X motor protocol: bytes to physical values and back, no input or output.

Protocol V3/V4 of MyActuator ("Servo Motor Control Protocol" V4.2): 11-bit identifiers, always 8
bytes, little endian, two's complement; the host sends to 0x140 + id (0x280 for all motors), the
motor answers from 0x240 + id with the command byte repeated. Both directions are coded: the driver
needs one, the emulator the other. The sign is the motor's own; which way that turns the joint is
the driver's ``direction``. Layouts that depend on the firmware take a :class:`Protocol`. The
motion mode (0x400 + id) is in :mod:`~sosml_friction.actuators.rmd_x_motion`, the identifiers
themselves (0x300) in :mod:`~sosml_friction.actuators.rmd_x_id`.

What the wire can carry (unit here, counts there): angle 0.01 degree int32, current 0.01 A int16,
speed command 0.01 degree/s int32, angle and speed of the standard reply 1 degree and 1 degree/s
int16, voltage 0.1 V uint16. Values are rounded to the nearest count and saturated.

Not coded: 0x9B (gone since V3), 0xA3 and 0xA5 (V3.4 to V3.6 only), 0xC0 and 0xC1 (undocumented).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from dataclasses import dataclass, fields
from enum import IntEnum, IntFlag
from typing import ClassVar

from sosml_friction.actuators.frame import Frame
from sosml_friction.actuators.rmd_x_protocol import Protocol
from sosml_friction.exceptions import CanProtocolError

REQUEST_BASE = 0x140
REPLY_BASE = 0x240
BROADCAST_ID = 0x280
MOTOR_IDS = range(1, 33)

ANGLE_RESOLUTION = math.radians(0.01)
CURRENT_RESOLUTION = 0.01
_DEGREE = math.radians(1.0)


class Command(IntEnum):
    """Byte 0 of a frame."""

    FUNCTION = 0x20
    READ_GAINS = 0x30
    GAINS_TO_RAM = 0x31
    GAINS_TO_ROM = 0x32
    READ_ACCELERATION = 0x42
    ACCELERATION_TO_ROM = 0x43
    ENCODER = 0x60
    ENCODER_RAW = 0x61
    ENCODER_OFFSET = 0x62
    ENCODER_OFFSET_TO_ROM = 0x63
    ENCODER_ZERO_TO_ROM = 0x64
    MODE = 0x70
    POWER = 0x71
    RESET = 0x76
    BRAKE_RELEASE = 0x77
    BRAKE_LOCK = 0x78
    SHUTDOWN = 0x80
    STOP = 0x81
    SINGLE_TURN_ENCODER = 0x90
    ANGLE = 0x92
    SINGLE_TURN_ANGLE = 0x94
    STATUS = 0x9A
    MOTION = 0x9C
    PHASE_CURRENTS = 0x9D
    CURRENT = 0xA1
    SPEED = 0xA2
    POSITION = 0xA4
    SINGLE_TURN_POSITION = 0xA6
    INCREMENT = 0xA8
    UPTIME = 0xB1
    VERSION = 0xB2
    TIMEOUT = 0xB3
    BITRATE = 0xB4
    MODEL = 0xB5
    ACTIVE_REPLY = 0xB6
    TIMEOUT_EXPIRED = 0xF1


MOTION_COMMANDS = (
    Command.MOTION,
    Command.CURRENT,
    Command.SPEED,
    Command.POSITION,
    Command.INCREMENT,
)
"""Commands answered by :class:`Motion`."""

ENCODER_COMMANDS = (
    Command.ENCODER,
    Command.ENCODER_RAW,
    Command.ENCODER_OFFSET,
    Command.ENCODER_OFFSET_TO_ROM,
    Command.ENCODER_ZERO_TO_ROM,
)
"""Commands answered by :class:`Encoder`."""


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


class ControlMode(IntEnum):
    """Which of its loops the motor runs (0x70)."""

    CURRENT = 1
    SPEED = 2
    POSITION = 3


class FunctionIndex(IntEnum):
    """What 0x20 sets."""

    CLEAR_MULTI_TURN = 1
    ID_FILTER = 2
    REPORT_ERRORS = 3
    SAVE_MULTI_TURN = 4
    SET_ID = 5
    POSITION_MAX = 6
    POSITION_MIN = 7


class AccelerationIndex(IntEnum):
    """Which acceleration 0x42 and 0x43 are about."""

    POSITION_ACCELERATION = 0
    POSITION_DECELERATION = 1
    SPEED_ACCELERATION = 2
    SPEED_DECELERATION = 3


class GainIndex(IntEnum):
    """Which gain 0x30 to 0x32 are about since V4.2."""

    CURRENT_KP = 1
    CURRENT_KI = 2
    SPEED_KP = 4
    SPEED_KI = 5
    POSITION_KP = 7
    POSITION_KI = 8
    POSITION_KD = 9


@dataclass(frozen=True)
class Message:
    """Say something in 8 bytes; byte 0 is :attr:`command`, and this one says nothing else."""

    command: ClassVar[Command]

    def pack(self) -> bytes:
        """
        Return the 8 bytes.

        :raises CanProtocolError: if a value is not finite or no such value exists.
        """
        return struct.pack('<B7x', self.command)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """
        Return what 8 bytes say.

        :raises CanProtocolError: if they say nothing the protocol allows.
        """
        return cls()


# ---- commands without a payload; those the motor echoes are also its replies


@dataclass(frozen=True)
class Shutdown(Message):
    """0x80: output off, the joint is free; the motor echoes it."""

    command = Command.SHUTDOWN


@dataclass(frozen=True)
class Stop(Message):
    """0x81: speed to zero, the motor's own loop holds; the motor echoes it."""

    command = Command.STOP


@dataclass(frozen=True)
class ReleaseBrake(Message):
    """0x77: open the brake; echoed, which can take 150 ms."""

    command = Command.BRAKE_RELEASE


@dataclass(frozen=True)
class LockBrake(Message):
    """0x78: close the brake; echoed, which can take 150 ms."""

    command = Command.BRAKE_LOCK


@dataclass(frozen=True)
class Reset(Message):
    """0x76: reboot. Not answered; the motor is away for about 1.1 s."""

    command = Command.RESET


@dataclass(frozen=True)
class ReadAngle(Message):
    """0x92: ask for the multi-turn angle."""

    command = Command.ANGLE


@dataclass(frozen=True)
class ReadSingleTurnAngle(Message):
    """0x94: ask for the angle within one turn."""

    command = Command.SINGLE_TURN_ANGLE


@dataclass(frozen=True)
class ReadEncoder(Message):
    """0x60: ask for the encoder's position minus its zero."""

    command = Command.ENCODER


@dataclass(frozen=True)
class ReadEncoderRaw(Message):
    """0x61: ask for the encoder's raw position."""

    command = Command.ENCODER_RAW


@dataclass(frozen=True)
class ReadEncoderOffset(Message):
    """0x62: ask for the encoder's zero."""

    command = Command.ENCODER_OFFSET


@dataclass(frozen=True)
class SetZeroHere(Message):
    """0x64: write the present position to ROM as zero; effective after :class:`Reset`."""

    command = Command.ENCODER_ZERO_TO_ROM


@dataclass(frozen=True)
class ReadSingleTurnEncoder(Message):
    """0x90: ask a direct-drive motor for its encoder."""

    command = Command.SINGLE_TURN_ENCODER


@dataclass(frozen=True)
class ReadStatus(Message):
    """0x9A: ask for temperature, voltage and errors."""

    command = Command.STATUS


@dataclass(frozen=True)
class ReadMotion(Message):
    """0x9C: ask for current, speed and angle without changing the mode."""

    command = Command.MOTION


@dataclass(frozen=True)
class ReadPhaseCurrents(Message):
    """0x9D: ask for the currents of the phases."""

    command = Command.PHASE_CURRENTS


@dataclass(frozen=True)
class ReadMode(Message):
    """0x70: ask which loop runs."""

    command = Command.MODE


@dataclass(frozen=True)
class ReadPower(Message):
    """0x71: ask for the electrical power (V3; gone from V4.2)."""

    command = Command.POWER


@dataclass(frozen=True)
class ReadUptime(Message):
    """0xB1: ask how long the motor has been on."""

    command = Command.UPTIME


@dataclass(frozen=True)
class ReadVersion(Message):
    """0xB2: ask for the firmware's date."""

    command = Command.VERSION


@dataclass(frozen=True)
class ReadModel(Message):
    """0xB5: ask for the model; since V4.4 for one ``block`` of it, 1 to 3, else ``block`` 0."""

    command = Command.MODEL
    block: int = 0

    def pack(self) -> bytes:
        """Return ``B5``, or ``B5 01 block``."""
        if not self.block:
            return super().pack()
        return struct.pack('<BBB5x', self.command, 1, _integer('block', self.block, 8))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the block asked for."""
        return cls(data[2] if data[1] == 1 else 0)


# ---- commands with a payload


@dataclass(frozen=True)
class SetCurrent(Message):
    """0xA1: command the torque-producing current [A]; answered by :class:`Motion`."""

    command = Command.CURRENT
    current: float

    def pack(self) -> bytes:
        """Return the current in 0.01 A."""
        return struct.pack('<B3xhxx', self.command, _counts(self.current, CURRENT_RESOLUTION, 16))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the current."""
        return cls(struct.unpack_from('<h', data, 4)[0] / 100.0)


@dataclass(frozen=True)
class SetSpeed(Message):
    """0xA2: command the speed of the output shaft [rad/s]; answered by :class:`Motion`."""

    command = Command.SPEED
    speed: float

    def pack(self) -> bytes:
        """Return the speed in 0.01 degree/s."""
        return struct.pack('<B3xi', self.command, _counts(self.speed, ANGLE_RESOLUTION, 32))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the speed."""
        return cls(_angle(struct.unpack_from('<i', data, 4)[0]))


@dataclass(frozen=True)
class SetPosition(Message):
    """
    0xA4: command the multi-turn ``angle`` [rad] with ``max_speed`` [rad/s] on the way.

    Answered by :class:`Motion`. A speed of 0 means "no limit" to the motor: one below 1 degree/s
    is sent as 1 degree/s, and 0 itself is refused.
    """

    command = Command.POSITION
    angle: float
    max_speed: float

    def pack(self) -> bytes:
        """Return the speed in degrees/s and the angle in 0.01 degree."""
        return struct.pack(
            '<BxHi',
            self.command,
            _max_speed(self.max_speed),
            _counts(self.angle, ANGLE_RESOLUTION, 32),
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return angle and speed; a speed of 0, no limit, is infinite."""
        speed, angle = struct.unpack_from('<Hi', data, 2)
        return cls(_angle(angle), speed * _DEGREE if speed else math.inf)


@dataclass(frozen=True)
class SetIncrement(SetPosition):
    """0xA8: as :class:`SetPosition`, ``angle`` counted from where the motor is."""

    command = Command.INCREMENT


@dataclass(frozen=True)
class SetSingleTurnPosition(Message):
    """
    0xA6: go to ``angle`` [rad] within one turn, 0 to 359.99 degrees, ``clockwise`` or not.

    Answered by :class:`SingleTurnMotion`; ``max_speed`` as in :class:`SetPosition`.
    """

    command = Command.SINGLE_TURN_POSITION
    angle: float
    max_speed: float
    clockwise: bool = True

    def pack(self) -> bytes:
        """Return direction, speed in degrees/s and angle in 0.01 degree."""
        angle = _counts(self.angle, ANGLE_RESOLUTION, 16, signed=False)
        return struct.pack(
            '<BBHHxx',
            self.command,
            int(not self.clockwise),
            _max_speed(self.max_speed),
            min(angle, 35999),
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return angle, speed and direction."""
        direction, speed, angle = struct.unpack_from('<BHH', data, 1)
        if angle > 35999:
            raise CanProtocolError(f'0xA6 asks for {angle} hundredths of a degree within a turn')
        return cls(_angle(angle), speed * _DEGREE if speed else math.inf, direction == 0)


@dataclass(frozen=True)
class SetEncoderOffset(Message):
    """0x63: write the encoder's zero [counts] to ROM; answered by :class:`Encoder`."""

    command = Command.ENCODER_OFFSET_TO_ROM
    counts: int

    def pack(self) -> bytes:
        """Return the counts."""
        counts = _integer('encoder offset', self.counts, 32, signed=True)
        return struct.pack('<B3xi', self.command, counts)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the counts."""
        return cls(struct.unpack_from('<i', data, 4)[0])


@dataclass(frozen=True)
class SetTimeout(Message):
    """
    0xB3: the motor's watchdog [ms], 0 for off; echoed. Written to ROM: not at every start.

    On expiry the output goes off and the brake closes; with 0 the last command runs for ever.
    """

    command = Command.TIMEOUT
    milliseconds: int

    def pack(self) -> bytes:
        """Return the time."""
        return struct.pack('<B3xI', self.command, _integer('timeout', self.milliseconds, 32))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the time."""
        return cls(struct.unpack_from('<I', data, 4)[0])


@dataclass(frozen=True)
class SetBitrate(Message):
    """0xB4: 500000 or 1000000 bit/s after the next power-up; the answer is to be ignored."""

    command = Command.BITRATE
    bitrate: int

    def pack(self) -> bytes:
        """Return 0 or 1 in the last byte."""
        if self.bitrate not in (500_000, 1_000_000):
            raise CanProtocolError(
                f'bit rate {self.bitrate} cannot be set: an RMD-X has 500000 and 1000000 bit/s'
            )
        return struct.pack('<B6xB', self.command, self.bitrate == 1_000_000)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the bit rate."""
        if data[7] > 1:
            raise CanProtocolError(f'0xB4 has the unknown bit rate {data[7]}')
        return cls(1_000_000 if data[7] else 500_000)


@dataclass(frozen=True)
class SetActiveReply(Message):
    """
    0xB6: let the motor send the reply to ``of`` by itself every ``period`` [s], 10 ms at least.

    Not answered. The motor then no longer answers requests for that reply.
    """

    command = Command.ACTIVE_REPLY
    of: int
    enabled: bool
    period: float

    def pack(self) -> bytes:
        """Return command byte, switch and period in 10 ms."""
        return struct.pack(
            '<BBBH3x',
            self.command,
            _integer('command', self.of, 8),
            self.enabled,
            _counts(self.period, 0.01, 16, signed=False),
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return command byte, switch and period."""
        of, enabled, period = struct.unpack_from('<BBH', data, 1)
        return cls(of, enabled != 0, period / 100.0)


@dataclass(frozen=True)
class Function(Message):
    """0x20: set function ``index`` (:class:`FunctionIndex`) to ``value``; echoed."""

    command = Command.FUNCTION
    index: int
    value: int

    def pack(self) -> bytes:
        """Return index and value."""
        return struct.pack(
            '<BBxxI',
            self.command,
            _integer('index', self.index, 8),
            _integer('value', self.value, 32),
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return index and value."""
        return cls(*struct.unpack_from('<BxxI', data, 1))


@dataclass(frozen=True)
class ReadAcceleration(Message):
    """0x42: ask for an acceleration; answered by :class:`Acceleration`."""

    command = Command.READ_ACCELERATION
    index: int

    def pack(self) -> bytes:
        """Return the index."""
        return struct.pack('<BB6x', self.command, _integer('index', self.index, 8))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the index."""
        return cls(data[1])


@dataclass(frozen=True)
class Acceleration(Message):
    """The reply to 0x42: ``acceleration`` [rad/s^2] number ``index``."""

    command = Command.READ_ACCELERATION
    index: int
    acceleration: float

    def pack(self) -> bytes:
        """Return index and acceleration in degrees/s^2."""
        return struct.pack(
            '<BBxxI',
            self.command,
            _integer('index', self.index, 8),
            _counts(self.acceleration, _DEGREE, 32, signed=False),
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return index and acceleration."""
        index, value = struct.unpack_from('<BxxI', data, 1)
        return cls(index, value * _DEGREE)


@dataclass(frozen=True)
class SetAcceleration(Acceleration):
    """0x43: write an acceleration to ROM; echoed."""

    command = Command.ACCELERATION_TO_ROM


@dataclass(frozen=True)
class ReadGains(Message):
    """0x30 up to V4.1: ask for the gains of all loops; answered by :class:`Gains`."""

    command = Command.READ_GAINS


@dataclass(frozen=True)
class Gains(Message):
    """0x30 up to V4.1: the gains of all loops, 0 to 255 of the motor's own scale."""

    command = Command.READ_GAINS
    current_kp: int
    current_ki: int
    speed_kp: int
    speed_ki: int
    position_kp: int
    position_ki: int

    def pack(self) -> bytes:
        """Return the six gains."""
        values = (getattr(self, field.name) for field in fields(self))
        return struct.pack('<Bx6B', self.command, *(_integer('gain', v, 8) for v in values))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the six gains."""
        return cls(*data[2:8])


@dataclass(frozen=True)
class SetGains(Gains):
    """0x31 up to V4.1: write the gains to RAM; echoed. Never while the motor moves."""

    command = Command.GAINS_TO_RAM


@dataclass(frozen=True)
class StoreGains(Gains):
    """0x32 up to V4.1: write the gains to ROM; echoed. Never while the motor moves."""

    command = Command.GAINS_TO_ROM


@dataclass(frozen=True)
class ReadGain(Message):
    """0x30 since V4.2: ask for one gain (:class:`GainIndex`); answered by :class:`Gain`."""

    command = Command.READ_GAINS
    index: int

    def pack(self) -> bytes:
        """Return the index."""
        return struct.pack('<BB6x', self.command, _integer('index', self.index, 8))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the index."""
        return cls(data[1])


@dataclass(frozen=True)
class Gain(Message):
    """0x30 since V4.2: one gain (:class:`GainIndex`), a float32."""

    command = Command.READ_GAINS
    index: int
    value: float

    def pack(self) -> bytes:
        """Return index and value."""
        index = _integer('index', self.index, 8)
        if not math.isfinite(self.value) or abs(self.value) > 3.4e38:
            raise CanProtocolError(f'the gain {self.value} cannot be sent: it is no float32')
        return struct.pack('<BBxxf', self.command, index, self.value)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return index and value."""
        index, value = struct.unpack_from('<Bxxf', data, 1)
        if not math.isfinite(value):
            raise CanProtocolError(f'gain {index} is {value}: it must be finite')
        return cls(index, value)


@dataclass(frozen=True)
class SetGain(Gain):
    """0x31 since V4.2: write one gain to RAM; echoed. Never while the motor moves."""

    command = Command.GAINS_TO_RAM


@dataclass(frozen=True)
class StoreGain(Gain):
    """0x32 since V4.2: write one gain to ROM; echoed. Never while the motor moves."""

    command = Command.GAINS_TO_ROM


# ---- replies


@dataclass(frozen=True)
class Motion(Message):
    """
    The standard reply to 0x9C, 0xA1, 0xA2, 0xA4 and 0xA8, of which ``of`` is one.

    ``temperature`` [degC], ``current`` iq [A], ``speed`` [rad/s] and ``angle`` [rad] of the output
    shaft in whole degrees.
    """

    command = Command.CURRENT
    temperature: int
    current: float
    speed: float
    angle: float
    of: Command = Command.CURRENT

    def pack(self) -> bytes:
        """Return the four values."""
        if self.of not in MOTION_COMMANDS:
            raise CanProtocolError(
                f'command {self.of:#04x} is not answered with current and speed'
            )
        return struct.pack(
            '<Bbhhh',
            self.of,
            _counts(self.temperature, 1.0, 8),
            _counts(self.current, CURRENT_RESOLUTION, 16),
            _counts(self.speed, _DEGREE, 16),
            _counts(self.angle, _DEGREE, 16),
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the four values."""
        temperature, current, speed, angle = struct.unpack_from('<bhhh', data, 1)
        return cls(
            temperature, current / 100.0, speed * _DEGREE, angle * _DEGREE, Command(data[0])
        )


@dataclass(frozen=True)
class SingleTurnMotion(Message):
    """The reply to 0xA6: as :class:`Motion`, with the encoder [counts] in place of the angle."""

    command = Command.SINGLE_TURN_POSITION
    temperature: int
    current: float
    speed: float
    encoder: int

    def pack(self) -> bytes:
        """Return the four values."""
        return struct.pack(
            '<BbhhH',
            self.command,
            _counts(self.temperature, 1.0, 8),
            _counts(self.current, CURRENT_RESOLUTION, 16),
            _counts(self.speed, _DEGREE, 16),
            _integer('encoder', self.encoder, 16),
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the four values."""
        temperature, current, speed, encoder = struct.unpack_from('<bhhH', data, 1)
        return cls(temperature, current / 100.0, speed * _DEGREE, encoder)


@dataclass(frozen=True)
class Angle(Message):
    """The reply to 0x92: multi-turn ``angle`` of the output shaft [rad], in 0.01 degree."""

    command = Command.ANGLE
    angle: float

    def pack(self) -> bytes:
        """Return the angle."""
        return struct.pack('<B3xi', self.command, _counts(self.angle, ANGLE_RESOLUTION, 32))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the angle."""
        return cls(_angle(struct.unpack_from('<i', data, 4)[0]))


@dataclass(frozen=True)
class SingleTurnAngle(Message):
    """The reply to 0x94: ``angle`` within one turn [rad], clockwise, in 0.01 degree."""

    command = Command.SINGLE_TURN_ANGLE
    angle: float

    def pack(self) -> bytes:
        """Return the angle."""
        counts = _counts(self.angle, ANGLE_RESOLUTION, 16, signed=False)
        return struct.pack('<B5xH', self.command, counts)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the angle."""
        return cls(_angle(struct.unpack_from('<H', data, 6)[0]))


@dataclass(frozen=True)
class Encoder(Message):
    """The reply to 0x60 to 0x64, of which ``of`` is one: encoder ``counts``."""

    command = Command.ENCODER
    counts: int
    of: Command = Command.ENCODER

    def pack(self) -> bytes:
        """Return the counts."""
        if self.of not in ENCODER_COMMANDS:
            raise CanProtocolError(f'command {self.of:#04x} is not answered with encoder counts')
        return struct.pack('<B3xi', self.of, _integer('encoder', self.counts, 32, signed=True))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the counts."""
        return cls(struct.unpack_from('<i', data, 4)[0], Command(data[0]))


@dataclass(frozen=True)
class SingleTurnEncoder(Message):
    """The reply to 0x90: ``position``, ``raw`` and ``offset`` [counts], 0 to 65535."""

    command = Command.SINGLE_TURN_ENCODER
    position: int
    raw: int
    offset: int

    def pack(self) -> bytes:
        """Return the counts."""
        values = (self.position, self.raw, self.offset)
        return struct.pack('<Bx3H', self.command, *(_integer('encoder', v, 16) for v in values))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the counts."""
        return cls(*struct.unpack_from('<3H', data, 2))


@dataclass(frozen=True)
class Status(Message):
    """
    The reply to 0x9A.

    ``temperature`` [degC]; ``brake_released``: the command to the brake, not a sensor; ``voltage``
    [V]; ``errors``; ``mos_temperature`` [degC]: since V4.4, 0 before.
    """

    command = Command.STATUS
    temperature: int
    brake_released: bool
    voltage: float
    errors: ErrorFlag
    mos_temperature: int = 0

    def pack(self) -> bytes:
        """Return the values."""
        return struct.pack(
            '<BbbBHH',
            self.command,
            _counts(self.temperature, 1.0, 8),
            _counts(self.mos_temperature, 1.0, 8),
            int(self.brake_released),
            _counts(self.voltage, 0.1, 16, signed=False),
            int(self.errors) & 0xFFFF,
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the values."""
        temperature, mos, released, voltage, errors = struct.unpack_from('<bbBHH', data, 1)
        return cls(temperature, released != 0, voltage / 10.0, ErrorFlag(errors), mos)


@dataclass(frozen=True)
class PhaseCurrents(Message):
    """The reply to 0x9D: ``temperature`` [degC] and the currents of the phases [A]."""

    command = Command.PHASE_CURRENTS
    temperature: int
    a: float
    b: float
    c: float

    def pack(self) -> bytes:
        """Return the values."""
        currents = (_counts(x, CURRENT_RESOLUTION, 16) for x in (self.a, self.b, self.c))
        return struct.pack('<Bbhhh', self.command, _counts(self.temperature, 1.0, 8), *currents)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the values."""
        temperature, a, b, c = struct.unpack_from('<bhhh', data, 1)
        return cls(temperature, a / 100.0, b / 100.0, c / 100.0)


@dataclass(frozen=True)
class Mode(Message):
    """The reply to 0x70: which loop runs."""

    command = Command.MODE
    mode: ControlMode

    def pack(self) -> bytes:
        """Return the mode in the last byte."""
        return struct.pack('<B6xB', self.command, self.mode)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the mode."""
        if data[7] not in list(ControlMode):
            raise CanProtocolError(f'the motor is in the unknown mode {data[7]}')
        return cls(ControlMode(data[7]))


@dataclass(frozen=True)
class Power(Message):
    """The reply to 0x71: electrical ``power`` [W]."""

    command = Command.POWER
    power: float

    def pack(self) -> bytes:
        """Return the power in 0.1 W."""
        return struct.pack('<B5xH', self.command, _counts(self.power, 0.1, 16, signed=False))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the power."""
        return cls(struct.unpack_from('<H', data, 6)[0] / 10.0)


@dataclass(frozen=True)
class Uptime(Message):
    """The reply to 0xB1: time since power-up [ms]; it tells a reboot."""

    command = Command.UPTIME
    milliseconds: int

    def pack(self) -> bytes:
        """Return the time."""
        return struct.pack('<B3xI', self.command, _integer('uptime', self.milliseconds, 32))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the time."""
        return cls(struct.unpack_from('<I', data, 4)[0])


@dataclass(frozen=True)
class Version(Message):
    """The reply to 0xB2: the firmware's date as a decimal number, 20220206 or 2026042402."""

    command = Command.VERSION
    date: int

    def pack(self) -> bytes:
        """Return the number."""
        return struct.pack('<B3xI', self.command, _integer('version', self.date, 32))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the number."""
        return cls(struct.unpack_from('<I', data, 4)[0])


@dataclass(frozen=True)
class Model(Message):
    """The reply to 0xB5 up to V4.3: the model's name, up to 7 characters."""

    command = Command.MODEL
    name: str

    def pack(self) -> bytes:
        """Return the characters."""
        return struct.pack('<B7s', self.command, _ascii(self.name, 7))

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the name."""
        return cls(_text(data[1:8]))


@dataclass(frozen=True)
class ModelBlock(Message):
    """The reply to 0xB5 since V4.4: block 1 to 3 of the model's name, up to 5 characters."""

    command = Command.MODEL
    block: int
    text: str

    def pack(self) -> bytes:
        """Return block and characters."""
        return struct.pack(
            '<BBB5s', self.command, 1, _integer('block', self.block, 8), _ascii(self.text, 5)
        )

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return block and characters."""
        return cls(data[2], _text(data[3:8]))


@dataclass(frozen=True)
class TimeoutExpired(Message):
    """0xF1, unasked, about once a second: the motor's watchdog has switched its output off."""

    command = Command.TIMEOUT_EXPIRED


Request = Message
Reply = Message


def _by_command(*kinds: type[Message]) -> dict[int, type[Message]]:
    return {int(kind.command): kind for kind in kinds}


_ECHOED = (Shutdown, Stop, ReleaseBrake, LockBrake, SetTimeout, SetBitrate, Function)
_COMMON_REQUESTS = _by_command(
    *_ECHOED, Reset, ReadAngle, ReadSingleTurnAngle, ReadEncoder, ReadEncoderRaw,
    ReadEncoderOffset, SetZeroHere, SetEncoderOffset, ReadSingleTurnEncoder, ReadStatus,
    ReadMotion, ReadPhaseCurrents, ReadMode, ReadPower, ReadUptime, ReadVersion, ReadModel,
    SetCurrent, SetSpeed, SetPosition, SetIncrement, SetSingleTurnPosition, SetActiveReply,
    ReadAcceleration, SetAcceleration,
)  # fmt: skip
_COMMON_REPLIES = {
    **_by_command(
        *_ECHOED, Angle, SingleTurnAngle, SingleTurnEncoder, Status, PhaseCurrents, Mode, Power,
        Uptime, Version, SingleTurnMotion, Acceleration, SetAcceleration, TimeoutExpired,
    ),
    **{int(command): Motion for command in MOTION_COMMANDS},
    **{int(command): Encoder for command in ENCODER_COMMANDS},
}  # fmt: skip
_SIX_GAINS = _by_command(SetGains, StoreGains)
_ONE_GAIN = _by_command(SetGain, StoreGain)
_REQUESTS: dict[Protocol, dict[int, type[Message]]] = {
    Protocol.V3: {**_COMMON_REQUESTS, **_SIX_GAINS, **_by_command(ReadGains)},
    Protocol.V4_2: {**_COMMON_REQUESTS, **_ONE_GAIN, **_by_command(ReadGain)},
    Protocol.V4_4: {**_COMMON_REQUESTS, **_ONE_GAIN, **_by_command(ReadGain)},
}
_REPLIES: dict[Protocol, dict[int, type[Message]]] = {
    Protocol.V3: {**_COMMON_REPLIES, **_SIX_GAINS, **_by_command(Gains, Model)},
    Protocol.V4_2: {**_COMMON_REPLIES, **_ONE_GAIN, **_by_command(Gain, Model)},
    Protocol.V4_4: {**_COMMON_REPLIES, **_ONE_GAIN, **_by_command(Gain, ModelBlock)},
}


_REQUEST_KINDS = {protocol: frozenset(own.values()) for protocol, own in _REQUESTS.items()}
_REPLY_KINDS = {protocol: frozenset(own.values()) for protocol, own in _REPLIES.items()}


def encode_request(motor_id: int, request: Request, protocol: Protocol = Protocol.V3) -> Frame:
    """
    Return the frame the host sends.

    :raises CanProtocolError: if the id is not 1..32, a value is not finite, or the protocol has no
        such request.
    """
    return Frame(
        REQUEST_BASE + checked_id(motor_id), _pack(request, _REQUEST_KINDS[protocol], protocol)
    )


def encode_broadcast(request: Request, protocol: Protocol = Protocol.V3) -> Frame:
    """
    Return the frame for every motor at once (0x280); each answers from its own identifier.

    :raises CanProtocolError: as :func:`encode_request`.
    """
    return Frame(BROADCAST_ID, _pack(request, _REQUEST_KINDS[protocol], protocol))


def decode_request(frame: Frame, protocol: Protocol = Protocol.V3) -> tuple[int, Request]:
    """
    Return the motor's id, 0 for all of them, and what it is asked.

    :raises CanProtocolError: if the frame is none of the requests.
    """
    motor_id = 0 if frame.can_id == BROADCAST_ID else _id_of(frame, REQUEST_BASE)
    _check_length(frame)
    kind = _REQUESTS[protocol].get(frame.data[0])
    if kind is None:
        raise CanProtocolError(f'frame {frame} asks with the unknown command {frame.data[0]:#04x}')
    return motor_id, kind.unpack(frame.data)


def encode_reply(motor_id: int, reply: Reply, protocol: Protocol = Protocol.V3) -> Frame:
    """
    Return the frame the motor sends.

    :raises CanProtocolError: if the id is not 1..32, a value is not finite, or the protocol has no
        such reply.
    """
    return Frame(REPLY_BASE + checked_id(motor_id), _pack(reply, _REPLY_KINDS[protocol], protocol))


def decode_reply(frame: Frame, protocol: Protocol = Protocol.V3) -> tuple[int, Reply]:
    """
    Return the motor's id and what it says.

    :raises CanProtocolError: if the frame is none of the replies.
    """
    motor_id = _id_of(frame, REPLY_BASE)
    _check_length(frame)
    kind = _REPLIES[protocol].get(frame.data[0])
    if kind is None:
        raise CanProtocolError(
            f'frame {frame} answers with the unknown command {frame.data[0]:#04x}'
        )
    return motor_id, kind.unpack(frame.data)


def checked_id(motor_id: int) -> int:
    """
    Return ``motor_id``.

    :raises CanProtocolError: if it is not 1..32.
    """
    if motor_id not in MOTOR_IDS:
        raise CanProtocolError(f'motor id {motor_id} is not between 1 and 32')
    return motor_id


def _pack(message: Message, known: frozenset[type[Message]], protocol: Protocol) -> bytes:
    if type(message) not in known:
        raise CanProtocolError(
            f'{type(message).__name__} does not exist in the protocol {protocol.value}'
        )
    return message.pack()


def _id_of(frame: Frame, base: int) -> int:
    motor_id = frame.can_id - base
    if motor_id not in MOTOR_IDS:
        raise CanProtocolError(
            f'frame {frame} is outside {base + 1:#05x}..{base + 32:#05x}, where the RMD-X talks'
        )
    return motor_id


def _check_length(frame: Frame) -> None:
    if len(frame.data) != 8:
        raise CanProtocolError(f'frame {frame} has {len(frame.data)} bytes where RMD-X sends 8')


def _counts(value: float, resolution: float, bits: int, *, signed: bool = True) -> int:
    """Return the nearest count, saturated to what ``bits`` hold."""
    counts = value / resolution
    if not math.isfinite(counts):
        raise CanProtocolError(f'the value {value} cannot be sent: it is not finite')
    low, high = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if signed else (0, (1 << bits) - 1)
    return min(max(round(counts), low), high)


def _integer(what: str, value: int, bits: int, *, signed: bool = False) -> int:
    """Return ``value``; one that does not fit is a mistake, not something to saturate."""
    low, high = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if signed else (0, (1 << bits) - 1)
    if value != value or not low <= value <= high or int(value) != value:
        raise CanProtocolError(f'{what} {value} cannot be sent: it must be {low} to {high}')
    return int(value)


def _max_speed(speed: float) -> int:
    """Return [degrees/s]; 0 would mean "no limit", which nobody asks for by a small number."""
    if not speed > 0.0:
        raise CanProtocolError(f'the speed limit {speed} cannot be sent: it must be positive')
    return max(1, _counts(speed, _DEGREE, 16, signed=False))


def _angle(counts: int) -> float:
    return math.radians(counts / 100.0)


def _text(data: Iterable[int]) -> str:
    text = bytes(data).split(b'\0')[0].rstrip(b' ')
    if not all(0x20 <= byte < 0x7F for byte in text):
        raise CanProtocolError(f'the model {text.hex(" ").upper()} is no text')
    return text.decode('ascii')


def _ascii(text: str, length: int) -> bytes:
    if len(text) > length or not all(' ' <= character <= '~' for character in text):
        raise CanProtocolError(f'the model {text!r} cannot be sent: {length} ASCII characters fit')
    return text.encode('ascii')
