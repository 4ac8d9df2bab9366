# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Read and write the identifier of an RMD-X (0x79 on 0x300): bytes and values, no input or output.

It reaches every motor on the bus, so only one may be connected; and only with the motors' filter
of identifiers off (0x20, index 2, value 0). Request and reply share the identifier 0x300.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x.codec import REPLY_BASE, checked_id
from sosml_friction.exceptions import CanProtocolError

ID_CHANNEL = 0x300
_COMMAND = 0x79


@dataclass(frozen=True)
class ReadId:
    """Ask the one motor on the bus for its id; answered by :class:`MotorId`."""


@dataclass(frozen=True)
class SetId:
    """Give the one motor on the bus ``motor_id``; echoed, effective after a restart."""

    motor_id: int


@dataclass(frozen=True)
class MotorId:
    """The reply to :class:`ReadId`."""

    motor_id: int


def encode_id(message: ReadId | SetId | MotorId) -> Frame:
    """
    Return the frame on 0x300.

    :raises CanProtocolError: if the id is not 1..32.
    """
    if isinstance(message, ReadId):
        data = struct.pack('<BxB5x', _COMMAND, 1)
    elif isinstance(message, SetId):
        data = struct.pack('<B6xB', _COMMAND, checked_id(message.motor_id))
    else:
        data = struct.pack('<BxB3xH', _COMMAND, 1, REPLY_BASE + checked_id(message.motor_id))
    return Frame(ID_CHANNEL, data)


def decode_id(frame: Frame) -> ReadId | SetId | MotorId:
    """
    Return what a frame on 0x300 says.

    :raises CanProtocolError: if it says nothing the protocol allows.
    """
    data = frame.data
    if frame.can_id != ID_CHANNEL or len(data) != 8 or data[0] != _COMMAND or data[2] > 1:
        raise CanProtocolError(f'frame {frame} is no reading or writing of an identifier')
    if data[2] == 0:
        return SetId(checked_id(data[7]))
    (number,) = struct.unpack_from('<H', data, 6)
    return MotorId(checked_id(number - REPLY_BASE)) if number else ReadId()
