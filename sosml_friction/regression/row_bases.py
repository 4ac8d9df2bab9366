# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is not known in some rows of a joint, taken out of whatever has these rows."""

import math
from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import ColumnArray, FloatArray, IndexArray
from sosml_friction.compiled import compiled
from sosml_friction.regression.rest import Rest

#: In the place of a rank: nothing of these rows is known.
_ALL = -1


class RowBases:
    """Hold the bases of rests, those of a joint one after the other: no two share rows."""

    def __init__(self, rests: Sequence[Rest]) -> None:
        self._rests = tuple(rests)
        self._by_joint: dict[int, tuple[IndexArray, FloatArray]] = {}
        for joint in {rest.joint for rest in rests}:
            own = [rest for rest in rests if rest.joint == joint]
            shapes = [
                (r.rows.start, r.rows.stop - r.rows.start, _ALL if r.base is None else _rank(r))
                for r in own
            ]
            values = [rest.base.T.ravel() for rest in own if rest.base is not None]
            self._by_joint[joint] = np.array(shapes), np.concatenate([np.empty(0), *values])

    def rank(self, joint: int) -> int:
        """Return how many values of a joint's rows the bases take."""
        return sum(_rank(rest) for rest in self._rests if rest.joint == joint)

    def rows(self) -> list[tuple[int, slice]]:
        """Return the joint and the rows of each base."""
        return [(rest.joint, rest.rows) for rest in self._rests]

    def take_out(self, x: ColumnArray, joints: Sequence[int]) -> ColumnArray:
        """Take what the rests may be out of ``x`` (K, m, ...) of ``joints`` (m,), in place."""
        flat = x.reshape(len(x), len(joints), math.prod(x.shape[2:]))
        for k, joint in enumerate(joints):
            if joint in self._by_joint:
                _project(flat, k, *self._by_joint[joint])
        if not np.may_share_memory(flat, x):
            x[...] = flat.reshape(x.shape)
        return x


def _rank(rest: Rest) -> int:
    return 0 if rest.base is None else rest.base.shape[1]


@compiled
def _project(x: ColumnArray, k: int, shapes: IndexArray, values: FloatArray) -> None:
    """
    Take what bases span out of x[:, k], in place.

    :param shapes: (b, 3): first row, rows, rank, or ``_ALL``. ``values``: base by base,
        vector by vector.
    """
    share = np.empty(x.shape[2])
    at = 0
    for b in range(len(shapes)):
        first, rows, rank = shapes[b]
        if rank == _ALL:
            x[first : first + rows, k] = 0.0
        for _ in range(rank):
            share[:] = 0.0
            for t in range(rows):
                for c in range(len(share)):
                    share[c] += values[at + t] * x[first + t, k, c]
            for t in range(rows):
                for c in range(len(share)):
                    x[first + t, k, c] -= values[at + t] * share[c]
            at += rows
