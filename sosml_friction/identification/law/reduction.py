# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Few rows and few columns that stand for many."""

import numpy as np
from scipy.linalg import qr

from sosml_friction.arrays import FloatArray, IndexArray

#: Part of the largest column that is left of columns that others stand for: the square root of
#: rounding, so that sums of squares are exact.
_LEFT = 1e-8
#: Rows that are reduced at a time; it bounds the memory.
_BLOCK = 20_000


def spanning(columns: FloatArray) -> IndexArray:
    """
    Return which of the columns (M, F) all others are combinations of.

    By QR with pivoting (the interpolative decomposition); the rest is below 1e-8 of the largest.
    """
    R, order = qr(columns, mode='r', pivoting=True)
    size = np.abs(np.diag(R))
    return np.asarray(order[: int(np.sum(size > _LEFT * size[0]))])


def triangle(root: FloatArray, *columns: FloatArray) -> FloatArray:
    """Return R of the QR decomposition of root (M,) times columns, from blocks of their rows."""
    R = np.empty((0, sum(each.shape[1] for each in columns)))
    for first in range(0, len(columns[0]), _BLOCK):
        rows = slice(first, first + _BLOCK)
        block = np.column_stack([each[rows] for each in columns]) * root[rows, None]
        R = np.asarray(np.linalg.qr(np.vstack([R, block]) if first else block, mode='r'))
    return R
