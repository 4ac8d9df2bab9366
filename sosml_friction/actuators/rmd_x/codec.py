# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The RMD-X motor protocol: bytes to physical values and back, no input or output.

Protocol V3/V4 of MyActuator ("Servo Motor Control Protocol" V4.2): 11-bit identifiers, always 8
bytes, little endian, two's complement; the host sends to 0x140 + id (0x280 for all motors), the
motor answers from 0x240 + id with the command byte repeated. Both directions are coded: the driver
needs one, the emulator the other. The sign is the motor's own; which way that turns the joint is
the driver's ``direction``. Layouts that depend on the firmware take a :class:`Protocol`. The
motion mode (0x400 + id) is in :mod:`~sosml_friction.actuators.rmd_x.motion_mode`, the identifiers
themselves (0x300) in :mod:`~sosml_friction.actuators.rmd_x.identifier`.

What the wire can carry (unit here, counts there): angle 0.01 degree int32, current 0.01 A int16,
speed command 0.01 degree/s int32, angle and speed of the standard reply 1 degree and 1 degree/s
int16, voltage 0.1 V uint16. Values are rounded to the nearest count and saturated.

Not coded: 0x9B (gone since V3), 0xA3 and 0xA5 (V3.4 to V3.6 only), 0xC0 and 0xC1 (undocumented).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x.commands import (
    ENCODER_COMMANDS,
    MOTION_COMMANDS,
    Command,
    ControlMode,
    ErrorFlag,
)
from sosml_friction.actuators.rmd_x.commands import AccelerationIndex as AccelerationIndex
from sosml_friction.actuators.rmd_x.commands import FunctionIndex as FunctionIndex
from sosml_friction.actuators.rmd_x.commands import GainIndex as GainIndex
from sosml_friction.actuators.rmd_x.commands import flag_names as flag_names
from sosml_friction.actuators.rmd_x.layout import (
    ANGLE,
    ANGLE_IN_TURN,
    BITRATE,
    CURRENT,
    DEGREES,
    ERRORS,
    FLOAT32,
    INVERSE_SWITCH,
    MAX_SPEED,
    MODE,
    PERIOD,
    SWITCH,
    TEMPERATURE,
    TENTHS,
    Layout,
    answered_command,
    characters,
    whole,
)
from sosml_friction.actuators.rmd_x.layout import ANGLE_RESOLUTION as ANGLE_RESOLUTION
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.exceptions import CanProtocolError

REQUEST_BASE = 0x140
REPLY_BASE = 0x240
BROADCAST_ID = 0x280
MOTOR_IDS = range(1, 33)


@dataclass(frozen=True)
class Message:
    """
    Say something in 8 bytes; this one says nothing but its command.

    ``command`` is byte 0, ``layout`` says where the values lie and how they are coded.
    """

    command: ClassVar[Command]
    layout: ClassVar[Layout] = Layout('B7x')

    def pack(self) -> bytes:
        """
        Return the 8 bytes.

        :raises CanProtocolError: if a value is not finite or no such value exists.
        """
        return self.layout.pack(self, self.command)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """
        Return what 8 bytes say.

        :raises CanProtocolError: if they say nothing the protocol allows.
        """
        return cls(**cls.layout.unpack(data))


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
    layout = Layout('BxB5x', block=whole('block'))
    block: int = 0

    def pack(self) -> bytes:
        """Return ``B5``, or ``B5 01 block``."""
        data = bytearray(super().pack())
        data[1] = self.block != 0
        return bytes(data)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the block asked for."""
        return super().unpack(data) if data[1] == 1 else cls()


# ---- commands with a payload


@dataclass(frozen=True)
class SetCurrent(Message):
    """0xA1: command the torque-producing current [A]; answered by :class:`Motion`."""

    command = Command.CURRENT
    layout = Layout('B3xh2x', current=CURRENT)
    current: float


@dataclass(frozen=True)
class SetSpeed(Message):
    """0xA2: command the speed of the output shaft [rad/s]; answered by :class:`Motion`."""

    command = Command.SPEED
    layout = Layout('B3xi', speed=ANGLE)
    speed: float


@dataclass(frozen=True)
class SetPosition(Message):
    """
    0xA4: command the multi-turn ``angle`` [rad] with ``max_speed`` [rad/s] on the way.

    Answered by :class:`Motion`. A speed of 0 means "no limit" to the motor: one below 1 degree/s
    is sent as 1 degree/s, and 0 itself is refused.
    """

    command = Command.POSITION
    layout = Layout('BxHi', max_speed=MAX_SPEED, angle=ANGLE)
    angle: float
    max_speed: float


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
    layout = Layout('BBHH2x', clockwise=INVERSE_SWITCH, max_speed=MAX_SPEED, angle=ANGLE_IN_TURN)
    angle: float
    max_speed: float
    clockwise: bool = True


@dataclass(frozen=True)
class SetEncoderOffset(Message):
    """0x63: write the encoder's zero [counts] to ROM; answered by :class:`Encoder`."""

    command = Command.ENCODER_OFFSET_TO_ROM
    layout = Layout('B3xi', counts=whole('encoder offset'))
    counts: int


@dataclass(frozen=True)
class SetTimeout(Message):
    """
    0xB3: the motor's watchdog [ms], 0 for off; echoed. Written to ROM: not at every start.

    On expiry the output goes off and the brake closes; with 0 the last command runs for ever.
    """

    command = Command.TIMEOUT
    layout = Layout('B3xI', milliseconds=whole('timeout'))
    milliseconds: int


@dataclass(frozen=True)
class SetBitrate(Message):
    """0xB4: 500000 or 1000000 bit/s after the next power-up; the answer is to be ignored."""

    command = Command.BITRATE
    layout = Layout('B6xB', bitrate=BITRATE)
    bitrate: int


@dataclass(frozen=True)
class SetActiveReply(Message):
    """
    0xB6: let the motor send the reply to ``of`` by itself every ``period`` [s], 10 ms at least.

    Not answered. The motor then no longer answers requests for that reply.
    """

    command = Command.ACTIVE_REPLY
    layout = Layout('BBBH3x', of=whole('command'), enabled=SWITCH, period=PERIOD)
    of: int
    enabled: bool
    period: float


@dataclass(frozen=True)
class Function(Message):
    """0x20: set function ``index`` (:class:`FunctionIndex`) to ``value``; echoed."""

    command = Command.FUNCTION
    layout = Layout('BB2xI', index=whole('index'), value=whole('value'))
    index: int
    value: int


@dataclass(frozen=True)
class ReadAcceleration(Message):
    """0x42: ask for an acceleration; answered by :class:`Acceleration`."""

    command = Command.READ_ACCELERATION
    layout = Layout('BB6x', index=whole('index'))
    index: int


@dataclass(frozen=True)
class Acceleration(Message):
    """The reply to 0x42: ``acceleration`` [rad/s^2] number ``index``."""

    command = Command.READ_ACCELERATION
    layout = Layout('BB2xI', index=whole('index'), acceleration=DEGREES)
    index: int
    acceleration: float


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
    layout = Layout(
        'Bx6B',
        current_kp=whole('gain'),
        current_ki=whole('gain'),
        speed_kp=whole('gain'),
        speed_ki=whole('gain'),
        position_kp=whole('gain'),
        position_ki=whole('gain'),
    )
    current_kp: int
    current_ki: int
    speed_kp: int
    speed_ki: int
    position_kp: int
    position_ki: int


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
    layout = Layout('BB6x', index=whole('index'))
    index: int


@dataclass(frozen=True)
class Gain(Message):
    """0x30 since V4.2: one gain (:class:`GainIndex`), a float32."""

    command = Command.READ_GAINS
    layout = Layout('BB2xf', index=whole('index'), value=FLOAT32)
    index: int
    value: float

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return index and value."""
        index, value = cls.layout.unpack(data).values()
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
    layout = Layout(
        'Bbhhh',
        of=answered_command(MOTION_COMMANDS, 'current and speed'),
        temperature=TEMPERATURE,
        current=CURRENT,
        speed=DEGREES,
        angle=DEGREES,
    )
    temperature: int
    current: float
    speed: float
    angle: float
    of: Command = Command.CURRENT


@dataclass(frozen=True)
class SingleTurnMotion(Message):
    """The reply to 0xA6: as :class:`Motion`, with the encoder [counts] in place of the angle."""

    command = Command.SINGLE_TURN_POSITION
    layout = Layout(
        'BbhhH', temperature=TEMPERATURE, current=CURRENT, speed=DEGREES, encoder=whole('encoder')
    )
    temperature: int
    current: float
    speed: float
    encoder: int


@dataclass(frozen=True)
class Angle(Message):
    """The reply to 0x92: multi-turn ``angle`` of the output shaft [rad], in 0.01 degree."""

    command = Command.ANGLE
    layout = Layout('B3xi', angle=ANGLE)
    angle: float


@dataclass(frozen=True)
class SingleTurnAngle(Message):
    """The reply to 0x94: ``angle`` within one turn [rad], clockwise, in 0.01 degree."""

    command = Command.SINGLE_TURN_ANGLE
    layout = Layout('B5xH', angle=ANGLE)
    angle: float


@dataclass(frozen=True)
class Encoder(Message):
    """The reply to 0x60 to 0x64, of which ``of`` is one: encoder ``counts``."""

    command = Command.ENCODER
    layout = Layout(
        'B3xi', of=answered_command(ENCODER_COMMANDS, 'encoder counts'), counts=whole('encoder')
    )
    counts: int
    of: Command = Command.ENCODER


@dataclass(frozen=True)
class SingleTurnEncoder(Message):
    """The reply to 0x90: ``position``, ``raw`` and ``offset`` [counts], 0 to 65535."""

    command = Command.SINGLE_TURN_ENCODER
    layout = Layout(
        'Bx3H', position=whole('encoder'), raw=whole('encoder'), offset=whole('encoder')
    )
    position: int
    raw: int
    offset: int


@dataclass(frozen=True)
class Status(Message):
    """
    The reply to 0x9A.

    ``temperature`` [degC]; ``brake_released``: the command to the brake, not a sensor; ``voltage``
    [V]; ``errors``; ``mos_temperature`` [degC]: since V4.4, 0 before.
    """

    command = Command.STATUS
    layout = Layout(
        'BbbBHH',
        temperature=TEMPERATURE,
        mos_temperature=TEMPERATURE,
        brake_released=SWITCH,
        voltage=TENTHS,
        errors=ERRORS,
    )
    temperature: int
    brake_released: bool
    voltage: float
    errors: ErrorFlag
    mos_temperature: int = 0


@dataclass(frozen=True)
class PhaseCurrents(Message):
    """The reply to 0x9D: ``temperature`` [degC] and the currents of the phases [A]."""

    command = Command.PHASE_CURRENTS
    layout = Layout('Bbhhh', temperature=TEMPERATURE, a=CURRENT, b=CURRENT, c=CURRENT)
    temperature: int
    a: float
    b: float
    c: float


@dataclass(frozen=True)
class Mode(Message):
    """The reply to 0x70: which loop runs."""

    command = Command.MODE
    layout = Layout('B6xB', mode=MODE)
    mode: ControlMode


@dataclass(frozen=True)
class Power(Message):
    """The reply to 0x71: electrical ``power`` [W]."""

    command = Command.POWER
    layout = Layout('B5xH', power=TENTHS)
    power: float


@dataclass(frozen=True)
class Uptime(Message):
    """The reply to 0xB1: time since power-up [ms]; it tells a reboot."""

    command = Command.UPTIME
    layout = Layout('B3xI', milliseconds=whole('uptime'))
    milliseconds: int


@dataclass(frozen=True)
class Version(Message):
    """The reply to 0xB2: the firmware's date as a decimal number, 20220206 or 2026042402."""

    command = Command.VERSION
    layout = Layout('B3xI', date=whole('version'))
    date: int


@dataclass(frozen=True)
class Model(Message):
    """The reply to 0xB5 up to V4.3: the model's name, up to 7 characters."""

    command = Command.MODEL
    layout = Layout('B7s', name=characters(7))
    name: str


@dataclass(frozen=True)
class ModelBlock(Message):
    """The reply to 0xB5 since V4.4: block 1 to 3 of the model's name, up to 5 characters."""

    command = Command.MODEL
    layout = Layout('BxB5s', block=whole('block'), text=characters(5))
    block: int
    text: str

    def pack(self) -> bytes:
        """Return block and characters."""
        data = bytearray(super().pack())
        data[1] = 1
        return bytes(data)


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
