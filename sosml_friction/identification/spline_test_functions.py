# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The test functions of the weak form over one stretch of a recording."""

import numpy as np
from scipy.sparse import csr_array

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.momentum_sampler import Stretch

#: Test functions overlap: each begins a quarter of the support after the one before, which makes
#: them a basis of cubic splines.
PIECES = 4


class SplineTestFunctions:
    """
    Hold cubic B-splines phi over a stretch, each divided by its integral.

    ``rows`` (N,) end the intervals of the stretch and ``before`` (N,) begin them; ``middle`` (K,)
    [s] of each phi; ``weights`` (K, N) integrate phi x; ``momentum`` (K, n) [Nm or N] is the
    integral of phi' p.
    """

    def __init__(self, time: FloatArray, stretch: Stretch, support: float) -> None:
        rows, samples = stretch.rows, stretch.samples
        end = time[rows]
        # Of the first interval, the sample that begins it may be no neighbour.
        self.rows, self.before = rows, np.append(rows[0], rows[:-1])
        begin = float(end[0] - samples.h[0])
        step = support / PIECES
        fits = np.floor((float(end[-1]) - begin - support) / step + 1e-9)
        self.count = max(0, int(fits) + 1)
        starts = begin + step * np.arange(self.count, dtype=float)
        self.middle = starts + 0.5 * support
        self.weights, slopes = _matrices(starts, support, end, samples.h)
        self.momentum = slopes @ samples.integral


def _matrices(
    starts: FloatArray, support: float, end: FloatArray, h: FloatArray
) -> tuple[csr_array, csr_array]:
    """
    Return the matrices (K, N) that integrate phi x and phi' x / h, over the integral of phi.

    By the means of phi and phi' over each interval: at its middle, intervals of unequal length
    would leave of a momentum that does not change M v h^3 phi''' / 24 each, not nothing.
    """
    piece = support / PIECES
    begin = end - h
    first = np.searchsorted(end, starts, side='right')
    count = np.searchsorted(begin, starts + support) - first
    # Products with a matrix are memory read: short indices are less of it.
    bounds = np.append(0, np.cumsum(count)).astype(np.int32)
    row = np.repeat(np.arange(len(starts)), count)
    index = (np.arange(bounds[-1]) - bounds[row] + first[row]).astype(np.int32)
    (below, lower), (above, upper) = (
        cubic_spline((t[index] - starts[row]) / piece - 2.0) for t in (begin, end)
    )
    shape = (len(starts), len(end))
    weights, slopes = upper - lower, (above - below) / h[index] / piece
    return csr_array((weights, index, bounds), shape), csr_array((slopes, index, bounds), shape)


def cubic_spline(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Return the cubic B-spline of the knots -2, -1, 0, 1, 2 at x, and its integral from -2 to x.

    ((2 - |x|)_+^3 - 4 (1 - |x|)_+^3) / 6, whose whole integral is 1.
    """
    far = np.abs(x)
    outer, inner = np.maximum(2.0 - far, 0.0), np.maximum(1.0 - far, 0.0)
    cubes, inner_cubes = outer * outer * outer, 4.0 * inner * inner * inner
    beyond = (cubes * outer - inner_cubes * inner) / 24.0
    return (cubes - inner_cubes) / 6.0, np.where(x > 0.0, 1.0 - beyond, beyond)
