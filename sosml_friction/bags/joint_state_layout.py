# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where in the CDR bytes of a JointState its numbers are."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray

#: The arrays of a JointState, in the order of its fields.
FIELDS = ('position', 'velocity', 'effort')

_COUNT = struct.Struct('<I')
#: Little-endian, plain: the only CDR that is read here.
_ENCAPSULATION = b'\x00\x01'
#: First byte behind the encapsulation; alignment counts from it.
ORIGIN = 4


@dataclass(frozen=True)
class JointStateLayout:
    """
    Hold what two JointState messages share that differ in their numbers alone.

    ``counts`` of the values of each of :data:`FIELDS`, and the bytes at which these start;
    ``fixed``: bytes that are the same in all, where they begin and what they are: lengths and
    names. Left out are the stamp, the frame_id, the numbers and what fills gaps.
    """

    names: tuple[str, ...]
    counts: tuple[int, ...]
    starts: tuple[int, ...]
    fixed: tuple[tuple[int, bytes], ...]

    @classmethod
    def of(cls, cdr: bytes) -> JointStateLayout | None:
        """Return the layout of a message, None where it is not plain: it is then for rclpy."""
        try:
            return cls._parse(cdr)
        except (struct.error, UnicodeDecodeError, _UnusualError):
            return None

    @classmethod
    def _parse(cls, cdr: bytes) -> JointStateLayout:
        if cdr[:2] != _ENCAPSULATION:
            raise _UnusualError
        frame = ORIGIN + 8
        at = _end_of_text(cdr, frame)
        first, names = _aligned(at, 4), []
        (count,) = _COUNT.unpack_from(cdr, first)
        at = first + 4
        for _ in range(count):
            begin = _aligned(at, 4)
            at = _end_of_text(cdr, begin)
            names.append(cdr[begin + 4 : at - 1].decode())
        fixed = [(0, cdr[:2]), (frame, cdr[frame : frame + 4]), (first, cdr[first:at])]
        counts, starts = [], []
        for _ in FIELDS:
            at = _aligned(at, 4)
            fixed.append((at, cdr[at : at + 4]))
            (count,) = _COUNT.unpack_from(cdr, at)
            at += 4
            if count:
                at = _aligned(at, 8)
            counts.append(count)
            starts.append(at)
            at += 8 * count
        if at > len(cdr):
            raise _UnusualError
        return cls(tuple(names), tuple(counts), tuple(starts), tuple(fixed))

    def shared_by(self, rows: NDArray[np.uint8]) -> BoolArray:
        """Return which messages of this one's length have its layout, (K,); rows (K, length)."""
        same = np.ones(len(rows), dtype=bool)
        for at, pattern in self.fixed:
            block = rows[:, at : at + len(pattern)]
            same &= (block == np.frombuffer(pattern, dtype=np.uint8)).all(axis=1)
        return same

    def values(self, rows: NDArray[np.uint8], field: int) -> FloatArray:
        """Return the values of one of :data:`FIELDS` of messages of this layout, (K, count)."""
        start, count = self.starts[field], self.counts[field]
        block = np.ascontiguousarray(rows[:, start : start + 8 * count])
        return block.view('<f8').reshape(len(rows), count)


def stamps(rows: NDArray[np.uint8]) -> IndexArray:
    """Return the stamps of messages [ns], (K,)."""
    parts = np.ascontiguousarray(rows[:, ORIGIN : ORIGIN + 8])
    nanoseconds = parts.view('<u4')[:, 1].astype(np.int64)
    return parts.view('<i4')[:, 0].astype(np.int64) * 1_000_000_000 + nanoseconds


class _UnusualError(Exception):
    """A message that is not laid out as every publisher does it."""


def _end_of_text(cdr: bytes, at: int) -> int:
    """Return where a text ends whose length stands at a byte; its last byte is its only NUL."""
    end = at + 4 + int(_COUNT.unpack_from(cdr, at)[0])
    if cdr.find(b'\0', at + 4, end) != end - 1:
        raise _UnusualError
    return end


def _aligned(at: int, size: int) -> int:
    return at + (ORIGIN - at) % size
