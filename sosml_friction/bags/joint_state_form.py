# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Joint states on line: numbers out of CDR bytes, and into them, without a message object."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_state_layout import FIELDS, ORIGIN, JointStateLayout
from sosml_friction.bags.message_definitions import JOINT_STATE
from sosml_friction.bags.serialization import deserialize, serialize_joint_state, stamp_ns

_STAMP = struct.Struct('<iI')
#: Where the stamp is, and the frame_id behind it.
_FROM, _TO = ORIGIN, ORIGIN + _STAMP.size


class JointStateForm:
    """
    Hold what messages of one publisher share: all but their stamp, their numbers and their gaps.

    :param cdr: one of them, as :func:`plain` has it.
    :param joints: whose numbers are taken, in this order.
    """

    def __init__(self, cdr: bytes, joints: Sequence[str]) -> None:
        layout = JointStateLayout.of(cdr)
        assert layout is not None
        self.names = layout.names
        (length,) = struct.unpack_from('<I', cdr, _TO)
        self.frame_id = cdr[_TO + 4 : _TO + 3 + length].decode(errors='replace')
        #: What messages of one publisher have alike, and those of another may not.
        self.source = self.names, self.frame_id
        #: Whether all ``joints`` are among the names; without them nothing else is there.
        self.is_known = set(joints) <= set(self.names)
        #: Whether one of them is there twice; the first is taken.
        self.is_twice = any(self.names.count(name) > 1 for name in joints)
        self._length = len(cdr)
        first, *counts = (at for at, _ in layout.fixed[-len(FIELDS) :])
        self._alike = [(_TO, first + 4), *((at, at + 4) for at in counts)]
        self._bytes = [cdr[begin:end] for begin, end in self._alike]
        if not self.is_known:
            return
        # The message is read as if it were all doubles: those of it lie on one grid.
        self._count = (len(cdr) - ORIGIN) // 8
        columns = np.array([self.names.index(name) for name in joints])
        has = [count == len(self.names) for count in layout.counts]
        starts = (np.array(layout.starts) - ORIGIN) // 8
        self._index = np.add.outer(starts, columns) * np.array(has)[:, np.newaxis]
        self._lacking = np.flatnonzero(~np.array(has))
        zeros = [0.0] * len(joints)
        own = serialize_joint_state(0, joints, zeros, zeros, zeros, self.frame_id)
        shape = JointStateLayout.of(own)
        assert shape is not None
        position, velocity, _ = shape.starts
        self._head, self._middle = own[:_FROM], own[_TO:position]
        self._gap = own[position + 8 * len(joints) : velocity]

    def fits(self, cdr: bytes) -> bool:
        """Tell whether a message has this form."""
        return len(cdr) == self._length and all(
            cdr[begin:end] == own
            for (begin, end), own in zip(self._alike, self._bytes, strict=True)
        )

    def read(self, cdr: bytes) -> tuple[int, FloatArray]:
        """
        Return the stamp [ns] and position, velocity and effort of the joints, (3, n).

        NaN where a message does not have a number for each of its names.
        """
        sec, nanosec = _STAMP.unpack_from(cdr, _FROM)
        numbers = np.frombuffer(cdr, '<f8', self._count, ORIGIN)[self._index]
        if len(self._lacking):
            numbers[self._lacking] = np.nan
        return sec * 1_000_000_000 + nanosec, numbers

    def write(self, cdr: bytes, position: bytes, velocity: bytes, effort: bytes) -> bytes:
        """Return a message of the joints with a message's stamp and frame_id; numbers as bytes."""
        stamp, gap = cdr[_FROM:_TO], self._gap
        return b''.join((self._head, stamp, self._middle, position, gap, velocity, gap, effort))


def of_message(message: Any) -> bytes:
    """Return the plain CDR bytes of a sensor_msgs/JointState."""
    return serialize_joint_state(
        stamp_ns(message.header.stamp),
        message.name,
        message.position,
        message.velocity,
        message.effort,
        message.header.frame_id,
    )


def plain(cdr: bytes) -> bytes:
    """
    Return a JointState as every publisher lays it out, which :class:`JointStateForm` takes.

    What is laid out otherwise is decoded by rclpy, and written anew.

    :raises BagError: if the bytes are no such message.
    """
    if JointStateLayout.of(cdr) is not None:
        return cdr
    return of_message(deserialize(cdr, JOINT_STATE))
