# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The RMD-X motion mode (0x400 + id to 0x500 + id): bytes and values, no input or output.

Big endian and packed in bits, unlike every other command, and without a command byte. A value x
in [-r, r] of n bits is round((x + r) / (2 r) (2^n - 1)): zero is between two counts. The ranges
depend on the firmware (:class:`MotionRanges`): with the wrong ones the torque is silently wrong,
by 2.5 from 24 to 60 Nm. The driver does not use this mode; reports of users about it disagree on
the side of the gear the velocity is on.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x.codec import MOTOR_IDS, checked_id
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.exceptions import CanProtocolError

MOTION_REQUEST_BASE = 0x400
MOTION_REPLY_BASE = 0x500


@dataclass(frozen=True)
class MotionRanges:
    """
    Say what full scale means.

    Position +-``position`` [rad], velocity +-``velocity`` [rad/s], torque +-``torque`` [Nm], gains
    0 to ``kp`` and 0 to ``kd``.
    """

    position: float
    kd: float
    torque: float
    velocity: float = 45.0
    kp: float = 500.0

    @classmethod
    def of(cls, protocol: Protocol, max_torque: float = math.nan) -> MotionRanges:
        """
        Return the ranges of ``protocol``.

        :param max_torque: the model's greatest torque [Nm], full scale since V4.4.
        :raises CanProtocolError: if V4.4 is not told ``max_torque``.
        """
        if protocol is not Protocol.V4_4:
            return cls(position=12.5, kd=5.0, torque=24.0)
        if not (math.isfinite(max_torque) and max_torque > 0.0):
            raise CanProtocolError(
                "the torque of V4.4's motion mode has the model's greatest torque as its full "
                f'scale: give it, not {max_torque}'
            )
        return cls(position=12.566, kd=50.0, torque=max_torque)


class MotionCommand(NamedTuple):
    """tau = kp (position - q) + kd (velocity - q') + torque, in the motor's own direction."""

    position: float
    velocity: float
    kp: float
    kd: float
    torque: float


class MotionState(NamedTuple):
    """The reply: position [rad], velocity [rad/s], torque [Nm], in the motor's own direction."""

    position: float
    velocity: float
    torque: float


def encode_motion_command(motor_id: int, command: MotionCommand, ranges: MotionRanges) -> Frame:
    """
    Return the frame to the motor: p 16, v 12, kp 12, kd 12, t 12 bits; values saturate.

    :raises CanProtocolError: if the id is not 1..32 or a value is not finite.
    """
    word = _pack(0, command, _places(ranges, MotionCommand))
    return Frame(MOTION_REQUEST_BASE + checked_id(motor_id), word.to_bytes(8, 'big'))


def decode_motion_command(frame: Frame, ranges: MotionRanges) -> tuple[int, MotionCommand]:
    """
    Return the motor's id and the command.

    :raises CanProtocolError: if the frame is none.
    """
    motor_id = _id_of(frame, MOTION_REQUEST_BASE)
    word = int.from_bytes(frame.data, 'big')
    return motor_id, MotionCommand(*_unpack(word, _places(ranges, MotionCommand)))


def encode_motion_state(motor_id: int, state: MotionState, ranges: MotionRanges) -> Frame:
    """
    Return the frame from the motor: id, then p 16, v 12, t 12 bits; values saturate.

    :raises CanProtocolError: if the id is not 1..32 or a value is not finite.
    """
    word = _pack(checked_id(motor_id), state, _places(ranges, MotionState))
    return Frame(MOTION_REPLY_BASE + motor_id, (word << 16).to_bytes(8, 'big'))


def decode_motion_state(frame: Frame, ranges: MotionRanges) -> tuple[int, MotionState]:
    """
    Return the motor's id and its state.

    :raises CanProtocolError: if the frame is none, or names another motor than its identifier.
    """
    motor_id = _id_of(frame, MOTION_REPLY_BASE)
    if frame.data[0] != motor_id:
        raise CanProtocolError(f'frame {frame} names motor {frame.data[0]}, not {motor_id}')
    word = int.from_bytes(frame.data, 'big') >> 16
    return motor_id, MotionState(*_unpack(word, _places(ranges, MotionState)))


def _id_of(frame: Frame, base: int) -> int:
    motor_id = frame.can_id - base
    if motor_id not in MOTOR_IDS or len(frame.data) != 8:
        raise CanProtocolError(
            f'frame {frame} is no motion mode of 8 bytes from {base + 1:#05x} to {base + 32:#05x}'
        )
    return motor_id


def _places(
    ranges: MotionRanges, kind: type[MotionCommand] | type[MotionState]
) -> list[tuple[int, float, float]]:
    """Return bits, lowest and highest value of each of its places, in their order."""
    spans = {
        'position': (16, -ranges.position, ranges.position),
        'velocity': (12, -ranges.velocity, ranges.velocity),
        'kp': (12, 0.0, ranges.kp),
        'kd': (12, 0.0, ranges.kd),
        'torque': (12, -ranges.torque, ranges.torque),
    }
    return [spans[name] for name in kind._fields]


def _pack(word: int, values: Iterable[float], places: list[tuple[int, float, float]]) -> int:
    for value, (bits, low, high) in zip(values, places, strict=True):
        if not math.isfinite(value):
            raise CanProtocolError(f'the value {value} cannot be sent: it is not finite')
        share = (min(max(value, low), high) - low) / (high - low)
        word = word << bits | round(share * ((1 << bits) - 1))
    return word


def _unpack(word: int, places: list[tuple[int, float, float]]) -> list[float]:
    values = []
    for bits, low, high in reversed(places):
        top = (1 << bits) - 1
        values.append(low + (word & top) / top * (high - low))
        word >>= bits
    return values[::-1]
