# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Loops over columns, compiled: whitening, sums of squares, lines in position, hats."""

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


@compiled
def squares(part: ColumnArray) -> FloatArray:
    """Return sum over rows and joints of part' part at each point of a grid, (g, k, k)."""
    rows, m, g, k = part.shape
    result = np.zeros((g, k, k))
    for t in range(rows):
        for i in range(m):
            for j in range(g):
                for a in range(k):
                    x = np.float64(part[t, i, j, a])
                    for b in range(a + 1):
                        result[j, a, b] += x * part[t, i, j, b]
    for j in range(g):
        for a in range(k):
            for b in range(a):
                result[j, b, a] = result[j, a, b]
    return result


@compiled
def hats(x: FloatArray, knots: FloatArray) -> FloatArray:
    """Return hats of x, (N, knots): 1 at their knot, 0 at others, lines between, 1 beyond ends."""
    count = len(knots)
    result = np.zeros((len(x), count))
    for t in range(len(x)):
        if x[t] <= knots[0]:
            result[t, 0] = 1.0
        elif x[t] >= knots[count - 1]:
            result[t, count - 1] = 1.0
        else:
            k = 0
            while x[t] > knots[k + 1]:
                k += 1
            share = (x[t] - knots[k]) / (knots[k + 1] - knots[k])
            result[t, k] = 1.0 - share
            result[t, k + 1] = share
    return result


def quantile_knots(x: FloatArray, count: int) -> FloatArray:
    """Return quantiles of x (N,) in even steps, at most ``count``: fewer where they are equal."""
    return np.unique(np.quantile(x, np.linspace(0.01, 0.99, count)))


def runs(mask: BoolArray) -> list[tuple[int, int]]:
    """Return where a mask (N,) is true, as half-open intervals [from, to)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))
