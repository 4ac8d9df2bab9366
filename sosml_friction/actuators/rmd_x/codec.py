# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The RMD-X motor protocol: bytes to physical values and back, no input or output.

11-bit identifiers: the host sends to 0x140 + id (0x280 for all motors), the motor answers from
0x240 + id. Replies that depend on the firmware take a :class:`Protocol`. The messages can be had
from here.
"""

from collections.abc import Mapping

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x.commands import *  # noqa: F403
from sosml_friction.actuators.rmd_x.layout import ANGLE_RESOLUTION as ANGLE_RESOLUTION
from sosml_friction.actuators.rmd_x.message import Message
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.actuators.rmd_x.replies import *  # noqa: F403
from sosml_friction.actuators.rmd_x.replies import REPLIES
from sosml_friction.actuators.rmd_x.requests import *  # noqa: F403
from sosml_friction.actuators.rmd_x.requests import REQUESTS
from sosml_friction.exceptions import CanProtocolError

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
