# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The RMD-X motor protocol: bytes to physical values and back, no input or output.

Protocol V3/V4 of MyActuator ("Servo Motor Control Protocol" V4.2): always 8 bytes, little endian,
two's complement, byte 0 is the command and comes back in the reply. 11-bit identifiers: the host
sends to 0x140 + id (0x280 for all motors), the motor answers from 0x240 + id. Both directions are
here: the driver needs one, the emulator the other. Replies that depend on the firmware take a
:class:`Protocol`. The sign is the motor's own; which way that turns the joint is the driver's
``direction``.

What the wire can carry (unit here, counts there): angle 0.01 degree int32, current 0.01 A int16,
speed command 0.01 degree/s int32, angle and speed of the standard reply 1 degree and 1 degree/s
int16, voltage 0.1 V uint16. Values are rounded to the nearest count and saturated.

Not coded, as nothing here sends it: the motion mode (0x400 + id), gains and accelerations (0x30
to 0x43), functions, identifiers and bit rate (0x20, 0x79, 0xB4), angles, positions and encoder
values within a turn (0x94, 0xA6, 0x90), increments (0xA8), mode, power and phase currents (0x70,
0x71, 0x9D), writing the zero (0x63, 0x64), and unasked replies (0xB6).
"""

from collections.abc import Mapping

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x import layout as wire
from sosml_friction.actuators.rmd_x.commands import *  # noqa: F403
from sosml_friction.actuators.rmd_x.commands import (
    MOTION_COMMANDS,
    Command,
    ErrorFlag,
    Protocol,
)
from sosml_friction.actuators.rmd_x.layout import ANGLE_RESOLUTION as ANGLE_RESOLUTION
from sosml_friction.actuators.rmd_x.layout import DEGREE, Message, at, bare, by_command
from sosml_friction.exceptions import CanProtocolError

# ---- commands without a payload; the motor echoes the first four, the brake's after up to 150 ms

Shutdown = bare('Shutdown', Command.SHUTDOWN)  # The joint is free.
Stop = bare('Stop', Command.STOP)  # The motor's own loop holds.
ReleaseBrake = bare('ReleaseBrake', Command.BRAKE_RELEASE)
LockBrake = bare('LockBrake', Command.BRAKE_LOCK)
# Not answered; the motor is away for about 1.1 s.
Reset = bare('Reset', Command.RESET)
ReadAngle = bare('ReadAngle', Command.ANGLE)
ReadEncoder = bare('ReadEncoder', Command.ENCODER)
ReadStatus = bare('ReadStatus', Command.STATUS)
ReadMotion = bare('ReadMotion', Command.MOTION)  # The mode stays.
ReadUptime = bare('ReadUptime', Command.UPTIME)
ReadVersion = bare('ReadVersion', Command.VERSION)


class ReadModel(Message, command=Command.MODEL):
    """0xB5: ask for the model; since V4.4 for one ``block`` of it, 1 to 3, else ``block`` 0."""

    block: int = at(2, 'B', int, default=0)

    def pack(self) -> bytes:
        data = bytearray(super().pack())
        data[1] = self.block != 0
        return bytes(data)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        return super().unpack(data) if data[1] == 1 else cls()


# ---- commands with a payload


class SetCurrent(Message, command=Command.CURRENT):
    """0xA1: command the torque-producing current [A]; answered by :class:`Motion`."""

    current: float = at(4, 'h', wire.CURRENT)


class SetSpeed(Message, command=Command.SPEED):
    """0xA2: command the speed of the output shaft [rad/s]; answered by :class:`Motion`."""

    speed: float = at(4, 'i', wire.ANGLE)


class SetPosition(Message, command=Command.POSITION):
    """
    0xA4: command the multi-turn ``angle`` [rad] with ``max_speed`` [rad/s] on the way.

    Answered by :class:`Motion`. A speed of 0 means "no limit" to the motor: one below 1 degree/s
    is sent as 1 degree/s, and 0 itself is refused.
    """

    angle: float = at(4, 'i', wire.ANGLE)
    max_speed: float = at(2, 'H', wire.MAX_SPEED)

    def pack(self) -> bytes:
        if not self.max_speed > 0.0:
            raise CanProtocolError(
                f'the speed limit {self.max_speed} cannot be sent: it must be positive'
            )
        if self.max_speed < DEGREE:
            return SetPosition(self.angle, DEGREE).pack()
        return super().pack()


class SetTimeout(Message, command=Command.TIMEOUT):
    """
    0xB3: the motor's watchdog [ms], 0 for off; echoed. Written to ROM: not at every start.

    On expiry the output goes off and the brake closes; with 0 the last command runs for ever.
    """

    milliseconds: int = at(4, 'I', int)


ECHOED = (Shutdown, Stop, ReleaseBrake, LockBrake, SetTimeout)
"""What is answered by itself."""

REQUESTS = by_command(
    *ECHOED, Reset, ReadAngle, ReadEncoder, ReadStatus, ReadMotion, ReadUptime, ReadVersion,
    ReadModel, SetCurrent, SetSpeed, SetPosition,
)  # fmt: skip


class Motion(Message, command=Command.CURRENT):
    """
    The standard reply to 0x9C, 0xA1, 0xA2 and 0xA4, of which ``of`` is one.

    ``temperature`` [degC], ``current`` iq [A], ``speed`` [rad/s] and ``angle`` [rad] of the output
    shaft in whole degrees.
    """

    temperature: int = at(1, 'b', wire.TEMPERATURE)
    current: float = at(2, 'h', wire.CURRENT)
    speed: float = at(4, 'h', wire.DEGREES)
    angle: float = at(6, 'h', wire.DEGREES)
    of: Command = at(0, 'B', Command, default=Command.CURRENT)


class Angle(Message, command=Command.ANGLE):
    """The reply to 0x92: multi-turn ``angle`` of the output shaft [rad], in 0.01 degree."""

    angle: float = at(4, 'i', wire.ANGLE)


class Encoder(Message, command=Command.ENCODER):
    """The reply to 0x60: encoder ``counts``, from its zero."""

    counts: int = at(4, 'i', int)


class Status(Message, command=Command.STATUS):
    """
    The reply to 0x9A.

    ``temperature`` [degC]; ``brake_released``: the command to the brake, not a sensor; ``voltage``
    [V]; ``errors``; ``mos_temperature`` [degC]: since V4.4, 0 before.
    """

    temperature: int = at(1, 'b', wire.TEMPERATURE)
    brake_released: bool = at(3, 'B', bool)
    voltage: float = at(4, 'H', wire.TENTHS)
    errors: ErrorFlag = at(6, 'H', ErrorFlag)
    mos_temperature: int = at(2, 'b', wire.TEMPERATURE, default=0)


class Uptime(Message, command=Command.UPTIME):
    """The reply to 0xB1: time since power-up [ms]; it tells a reboot."""

    milliseconds: int = at(4, 'I', int)


class Version(Message, command=Command.VERSION):
    """The reply to 0xB2: the firmware's date as a decimal number, 20220206 or 2026042402."""

    date: int = at(4, 'I', int)


class Model(Message, command=Command.MODEL):
    """The reply to 0xB5 up to V4.3: the model's name, up to 7 characters."""

    name: str = at(1, '7s', str)


class ModelBlock(Message, command=Command.MODEL):
    """The reply to 0xB5 since V4.4: block 1 to 3 of the model's name, up to 5 characters."""

    block: int = at(2, 'B', int)
    text: str = at(3, '5s', str)

    def pack(self) -> bytes:
        data = bytearray(super().pack())
        data[1] = 1
        return bytes(data)


TimeoutExpired = bare('TimeoutExpired', Command.TIMEOUT_EXPIRED)
"""0xF1, unasked, about once a second: the motor's watchdog has switched its output off."""


_COMMON = {
    **by_command(
        *ECHOED, Angle, Encoder, Status, Uptime, Version, Model, TimeoutExpired,
    ),
    **{int(command): Motion for command in MOTION_COMMANDS},
}  # fmt: skip
REPLIES = {
    Protocol.V3: _COMMON,
    Protocol.V4_4: {**_COMMON, **by_command(ModelBlock)},
}


REQUEST_BASE = 0x140
REPLY_BASE = 0x240
BROADCAST_ID = 0x280
MOTION_REQUEST_BASE = 0x400
"""Of the motion mode, which is not coded."""
MOTOR_IDS = range(1, 33)

Request = Message
Reply = Message


def encode_request(motor_id: int, request: Request) -> Frame:
    """
    Return the frame the host sends.

    :raises CanProtocolError: if the id is not 1..32, a value is not finite, or ``request`` is a
        reply.
    """
    return Frame(REQUEST_BASE + checked_id(motor_id), _pack(request, REQUESTS, 'request'))


def decode_request(frame: Frame) -> tuple[int, Request]:
    """
    Return the motor's id, 0 for all of them, and what it is asked.

    :raises CanProtocolError: if the frame is none of the requests.
    """
    motor_id = 0 if frame.can_id == BROADCAST_ID else _id_of(frame, REQUEST_BASE)
    return motor_id, _unpack(frame, REQUESTS, 'asks')


def encode_reply(motor_id: int, reply: Reply, protocol: Protocol = Protocol.V3) -> Frame:
    """
    Return the frame the motor sends.

    :raises CanProtocolError: if the id is not 1..32, a value is not finite, or the protocol has no
        such reply.
    """
    return Frame(
        REPLY_BASE + checked_id(motor_id),
        _pack(reply, REPLIES[protocol], f'reply of {protocol.value}'),
    )


def decode_reply(frame: Frame, protocol: Protocol = Protocol.V3) -> tuple[int, Reply]:
    """
    Return the motor's id and what it says.

    :raises CanProtocolError: if the frame is none of the replies.
    """
    return _id_of(frame, REPLY_BASE), _unpack(frame, REPLIES[protocol], 'answers')


def checked_id(motor_id: int) -> int:
    """
    Return ``motor_id``.

    :raises CanProtocolError: if it is not 1..32.
    """
    if motor_id not in MOTOR_IDS:
        raise CanProtocolError(f'motor id {motor_id} is not between 1 and 32')
    return motor_id


def _pack(message: Message, kinds: Mapping[int, type[Message]], what: str) -> bytes:
    # A command byte may stand for another message in another protocol.
    if type(message) not in kinds.values():
        raise CanProtocolError(f'{type(message).__name__} is no {what}')
    return message.pack()


def _unpack(frame: Frame, kinds: Mapping[int, type[Message]], does: str) -> Message:
    if len(frame.data) != 8:
        raise CanProtocolError(f'frame {frame} has {len(frame.data)} bytes where RMD-X sends 8')
    kind = kinds.get(frame.data[0])
    if kind is None:
        raise CanProtocolError(
            f'frame {frame} {does} with the unknown command {frame.data[0]:#04x}'
        )
    return kind.unpack(frame.data)


def _id_of(frame: Frame, base: int) -> int:
    motor_id = frame.can_id - base
    if motor_id not in MOTOR_IDS:
        raise CanProtocolError(
            f'frame {frame} is outside {base + 1:#05x}..{base + 32:#05x}, where the RMD-X talks'
        )
    return motor_id
