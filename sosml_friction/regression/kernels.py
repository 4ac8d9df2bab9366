# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Sums over the columns of a regression: filters, products, squares, hats, and runs of a mask."""

import numpy as np

from sosml_friction.arrays import BoolArray, ColumnArray, FloatArray
from sosml_friction.compiled import compiled

#: Rows, and points of a grid, of which arrays are made at a time: a few MB, which stay in the
#: cache of a processor. Sizes of memory, not of the answer.
ROWS_AT_ONCE, POINTS_AT_ONCE = 4096, 64


def convolve_rows(x: ColumnArray, weights: FloatArray) -> ColumnArray:
    """
    Return sum_l weights[i, l] x[k + L - 1 - l, i], (K - L + 1, m, c): a FIR filter along rows.

    What is of single precision is overwritten: there is too much of it to have it twice.

    :param x: (K, m, c); weights: (m, L), the newest sample's first.
    """
    count = max(len(x) - weights.shape[1] + 1, 0)
    result = x[:count] if x.dtype == np.float32 else np.empty((count, *x.shape[1:]))
    _convolve(x, weights, result)
    return result


@compiled
def _convolve(x: ColumnArray, weights: FloatArray, result: ColumnArray) -> None:
    m, c = x.shape[1:]
    length = weights.shape[1]
    row = np.empty(c)
    for k in range(len(result)):
        for i in range(m):
            for j in range(c):
                row[j] = weights[i, 0] * x[k + length - 1, i, j]
            for lag in range(1, length):
                w = weights[i, lag]
                for j in range(c):
                    row[j] += w * x[k + length - 1 - lag, i, j]
            # No later row needs this one of x.
            result[k, i] = row


def products(left: FloatArray, columns: ColumnArray) -> FloatArray:
    """Return left @ columns, (a, c), of (a, rows) and (rows, c), in double precision."""
    if columns.dtype == left.dtype:
        return np.asarray(left @ columns)
    result = np.zeros((len(left), columns.shape[1]))
    for k in range(0, len(columns), ROWS_AT_ONCE):
        result += left[:, k : k + ROWS_AT_ONCE] @ columns[k : k + ROWS_AT_ONCE].astype(np.float64)
    return result


def squares(part: ColumnArray) -> FloatArray:
    """Return sum over rows and joints of part' part at each point of a grid, (g, k, k)."""
    points = part.reshape(-1, *part.shape[2:]).transpose(1, 2, 0).astype(np.float64)
    return np.asarray(points @ points.swapaxes(1, 2))


def hats(x: FloatArray, knots: FloatArray) -> FloatArray:
    """Return hats of x, (N, knots): 1 at their knot, 0 at others, lines between, 1 beyond ends."""
    number = np.arange(len(knots))
    return np.maximum(1.0 - np.abs(np.interp(x, knots, number)[:, None] - number), 0.0)


def runs(mask: BoolArray) -> list[tuple[int, int]]:
    """Return where a mask (N,) is true, as half-open intervals [from, to)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))
