# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
All JointState messages of a topic as arrays.

Those that name the same joints and have the same arrays differ in their numbers alone: the numbers
are then taken out of all of them at once, from where they are in the first. What is laid out in a
way of its own is decoded message by message, with the same result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_state_layout import FIELDS, JointStateLayout, stamps
from sosml_friction.bags.message_store import MessageStore
from sosml_friction.bags.serialization import stamp_ns
from sosml_friction.exceptions import BagError

#: Bytes of messages that are taken at once: they stay in a cache.
_BLOCK_BYTES = 2**20
#: Layouts that are looked for among the messages of a block that are equally long; what is left
#: is decoded one by one.
_LAYOUTS = 8

#: Names, and how many values there are of each of :data:`FIELDS`.
Kind = tuple[tuple[str, ...], tuple[int, ...]]


#: Rows (K,) and, of each of the fields that are wanted, values (K, count).
_Block = tuple[IndexArray, dict[str, FloatArray]]


@dataclass
class JointStates:
    """Hold N messages: stamps (N,) [ns], blocks by kind, the first row that is none and why."""

    t_ns: IndexArray
    blocks: dict[Kind, list[_Block]] = field(default_factory=dict)
    problem: tuple[int, BagError] | None = None

    def first(self, kind: Kind) -> int:
        """Return the first row that is of a kind."""
        return min(int(rows.min()) for rows, _ in self.blocks[kind])

    @property
    def names(self) -> tuple[str, ...]:
        """Return the joints, in the order in which they appear first."""
        kinds = sorted(self.blocks, key=self.first)
        return tuple(dict.fromkeys(name for names, _ in kinds for name in names))

    def table(self, name: str) -> FloatArray:
        """Return one of the fields (N, n), NaN where a message does not have it."""
        names = self.names
        table = np.full((len(self.t_ns), len(names)), np.nan)
        column = {joint: i for i, joint in enumerate(names)}
        for (joints, counts), blocks in self.blocks.items():
            if not counts[FIELDS.index(name)]:
                continue
            columns = np.array([column[joint] for joint in joints])
            for rows, values in blocks:
                if joints == names:
                    table[rows] = values[name]
                else:
                    table[np.ix_(rows, columns)] = values[name]
        return table


def read_joint_states(
    store: MessageStore,
    places: tuple[IndexArray, IndexArray, IndexArray],
    fields: Sequence[str],
    decode: Callable[[int, bytes], Any],
) -> JointStates:
    """
    Return the ``fields`` wanted of N messages, whose places are region, offset and length, (N,).

    ``decode`` makes the message of a row and its bytes, where they are laid out unusually; it
    raises a BagError where they are none.
    """
    region, offset, length = places
    found = JointStates(np.zeros(len(region), dtype=np.int64))
    layouts: dict[int, list[JointStateLayout]] = {}
    for rows in _blocks(region, length):
        size = int(length[rows[0]])
        content = store.fetch_all(int(region[rows[0]]), offset[rows], size)
        rest = _take_alike(found, rows, content, layouts.setdefault(size, []), fields)
        for row, cdr in zip(rows[rest].tolist(), content[rest], strict=True):
            try:
                _take_one(found, row, decode(row, cdr.tobytes()), fields)
            except BagError as error:
                if found.problem is None or row < found.problem[0]:
                    found.problem = row, error
    return found


def _blocks(region: IndexArray, length: IndexArray) -> Iterator[IndexArray]:
    """Yield rows of one region and one length: a chunk is decompressed once."""
    order = np.lexsort((length, region))
    ends = np.flatnonzero(np.diff(region[order]) | np.diff(length[order])) + 1
    for first, last in pairwise([0, *ends.tolist(), len(order)]):
        step = max(1, _BLOCK_BYTES // max(1, int(length[order[first]])))
        for begin in range(first, last, step):
            yield order[begin : min(begin + step, last)]


def _take_alike(
    found: JointStates,
    rows: IndexArray,
    content: NDArray[np.uint8],
    layouts: list[JointStateLayout],
    fields: Sequence[str],
) -> IndexArray:
    """Take the messages of known layouts, to which new ones are added; return the rest, (L,)."""
    rest = np.arange(len(rows))
    for attempt in range(_LAYOUTS):
        if not len(rest):
            break
        if attempt == len(layouts):
            layout = JointStateLayout.of(content[0].tobytes())
            if layout is None:
                break
            layouts.append(layout)
        layout = layouts[attempt]
        same = layout.shared_by(content)
        if same.any():
            # Mostly it is all of them.
            mine = content if same.all() else content[same]
            own = rows[rest[same]]
            found.t_ns[own] = stamps(mine)
            values = {name: layout.values(mine, FIELDS.index(name)) for name in fields}
            found.blocks.setdefault((layout.names, layout.counts), []).append((own, values))
            rest, content = rest[~same], content[~same]
    return rest


def _take_one(found: JointStates, row: int, message: Any, fields: Sequence[str]) -> None:
    found.t_ns[row] = stamp_ns(message.header.stamp)
    counts = tuple(len(getattr(message, name)) for name in FIELDS)
    values = {name: np.array([getattr(message, name)], dtype=float) for name in fields}
    kind = tuple(message.name), counts
    found.blocks.setdefault(kind, []).append((np.array([row]), values))
