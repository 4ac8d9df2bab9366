# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The columns of a law from a few speeds, however long the recording is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray

#: Polynomials of this many nodes over each factor e of speed. Their largest error, measured by
#: test/identification/law/test_speed_table.py: 3e-9 for exp(-w), 2e-6 for exp(-w^2), 2e-8 for
#: tanh(w).
_NODES = 10
#: Rows that are reduced at a time; it bounds the memory.
_BLOCK = 20_000


@dataclass(frozen=True)
class SpeedTable:
    """
    Make columns of a regression from what a law is at a few velocities.

    A law f enters the rows by a linear map L of its values at all samples. f is smooth over the
    logarithm of speed, so that a polynomial through its values at the nodes ``v`` (B,) [rad/s or
    m/s] gives it at every sample, and L f(v of all samples) = ``rows`` f(v), with ``rows``
    (K, B).
    """

    v: FloatArray
    rows: FloatArray

    @classmethod
    def of(
        cls,
        v: FloatArray,
        made: Callable[[FloatArray], FloatArray],
        floor: float,
        one_sided: bool,
    ) -> SpeedTable | None:
        """
        Return the table, None where there are not more samples than nodes.

        :param v: velocity of all samples (N,).
        :param made: the linear map, from (N,) to (K,).
        :param one_sided: whether laws are odd: they are taken at positive nodes only.
        :param floor: speed below which a law has the value that it has there, but 0 for v = 0.
        """
        moving = np.flatnonzero(v != 0.0)
        u = np.log(np.maximum(np.abs(v[moving]), floor) / floor)
        if not len(u):
            return None
        panels = np.minimum(u.astype(np.int64), int(u.max()))
        used = np.unique(panels)
        sides = [1.0] if one_sided else [1.0, -1.0]
        if len(v) <= len(used) * _NODES * len(sides):
            return None
        angle = (2.0 * np.arange(_NODES) + 1.0) * np.pi / (2.0 * _NODES)
        x, signs = np.cos(angle), np.sign(v[moving])
        # The barycentric formula at Chebyshev nodes.
        distance = 2.0 * (u - panels)[:, None] - 1.0 - x
        hit = np.abs(distance) < np.finfo(float).eps
        weights = (-1.0) ** np.arange(_NODES) * np.sin(angle) / np.where(hit, 1.0, distance)
        exact = hit.any(axis=1)
        weights[exact] = hit[exact]
        weights /= weights.sum(axis=1, keepdims=True)
        nodes, rows = [], []
        for panel in used:
            inside = np.flatnonzero(panels == panel)
            at = moving[inside]
            for side in sides:
                own = signs[inside] if one_sided else (signs[inside] == side).astype(float)
                nodes.append(side * floor * np.exp(panel + 0.5 * (x + 1.0)))
                for k in range(_NODES):
                    column = np.zeros_like(v)
                    column[at] = own * weights[inside, k]
                    rows.append(made(column))
        if not one_sided:
            nodes.append(np.zeros(1))
            rows.append(made((v == 0.0).astype(float)))
        return cls(np.concatenate(nodes), np.column_stack(rows))


def triangle(*columns: FloatArray) -> FloatArray:
    """Return R of the QR decomposition of columns side by side, from blocks of their rows."""
    R = np.empty((0, sum(each.shape[1] for each in columns)))
    for first in range(0, len(columns[0]), _BLOCK):
        block = np.column_stack([each[first : first + _BLOCK] for each in columns])
        R = np.asarray(np.linalg.qr(np.vstack([R, block]), mode='r'))
    return R
