# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Loops over columns, compiled: whitening, sums of squares, lines in position, hats."""

import numpy as np
from numba import njit

from sosml_friction.arrays import BoolArray, FloatArray


@njit(cache=True)
def convolve_rows(x: FloatArray, weights: FloatArray) -> FloatArray:
    """
    Return sum_l weights[i, l] x[k + L - 1 - l, i], (K - L + 1, m, c): a FIR filter along rows.

    :param x: (K, m, c); weights: (m, L), the newest sample's first.
    """
    rows, m, c = x.shape
    length = weights.shape[1]
    result = np.empty((max(rows - length + 1, 0), m, c))
    for k in range(len(result)):
        for i in range(m):
            for j in range(c):
                result[k, i, j] = weights[i, 0] * x[k + length - 1, i, j]
            for lag in range(1, length):
                w = weights[i, lag]
                for j in range(c):
                    result[k, i, j] += w * x[k + length - 1 - lag, i, j]
    return result


@njit(cache=True)
def squares(part: FloatArray) -> FloatArray:
    """Return sum over rows and joints of part' part at each point of a grid, (g, k, k)."""
    rows, m, g, k = part.shape
    result = np.zeros((g, k, k))
    for t in range(rows):
        for i in range(m):
            for j in range(g):
                for a in range(k):
                    for b in range(a + 1):
                        result[j, a, b] += part[t, i, j, a] * part[t, i, j, b]
    for j in range(g):
        for a in range(k):
            for b in range(a):
                result[j, b, a] = result[j, a, b]
    return result


@njit(cache=True)
def hats(x: FloatArray, knots: FloatArray) -> FloatArray:
    """
    Return hat functions of x, (N, knots): 1 at their knot, 0 at the others, lines between.

    Beyond the ends the first and the last stay 1.
    """
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


def acts(columns: FloatArray) -> bool:
    """Tell whether any number of an array is not zero, a sample of its rows first."""
    return bool(columns[:: max(1, len(columns) // 64)].any()) or bool(columns.any())


def runs(mask: BoolArray) -> list[tuple[int, int]]:
    """Return where a mask (N,) is true, as half-open intervals [from, to)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]))).tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))
