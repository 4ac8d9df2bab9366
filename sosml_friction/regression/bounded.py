# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Least squares within bounds, from the normal equations."""

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled

#: A guess within this share of a bound is at the bound: rounding of double precision, and more.
AT = 1e-12
#: A bound that hurts by less [square root of the cost] holds.
SAME = 1e-9


@compiled
def bounded_least_squares(
    G: FloatArray, r: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """
    Return the x (p,) within bounds that makes x' G x / 2 - r' x least.

    An active-set method (as C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974,
    chapter 23, for two-sided bounds), on the normal equations: G (p, p) positive definite.
    """
    x = np.zeros(len(r))
    for i in range(len(r)):
        x[i] = min(max(0.0, low[i]), high[i])
    return bounded_from(G, r, low, high, x)


@compiled
def bounded_from(
    G: FloatArray, r: FloatArray, low: FloatArray, high: FloatArray, start: FloatArray
) -> FloatArray:
    """Return the same from a guess ``start`` (p,): one near the answer takes fewer steps."""
    p = len(r)
    x = start.copy()
    state = np.zeros(p, dtype=np.int64)
    for i in range(p):
        # Where the guess is at a bound, or past it by rounding, the answer is likely to be, too.
        if x[i] != 0.0 and x[i] <= low[i] + AT * abs(low[i]):
            x[i], state[i] = low[i], -1
        elif x[i] != 0.0 and x[i] >= high[i] - AT * abs(high[i]):
            x[i], state[i] = high[i], 1
    for _ in range(10 * p + 10):
        # Solve on the free set; where that leaves the bounds, go as far as they allow.
        for _ in range(p + 1):
            free = np.flatnonzero(state == 0)
            m = len(free)
            if m == 0:
                break
            A = np.empty((m, m))
            b = np.empty(m)
            for i in range(m):
                b[i] = r[free[i]]
                for j in range(p):
                    if state[j] != 0:
                        b[i] -= G[free[i], j] * x[j]
                for j in range(m):
                    A[i, j] = G[free[i], free[j]]
            y = np.linalg.solve(A, b)
            step = 1.0
            hit = -1
            for i in range(m):
                k = free[i]
                if y[i] < low[k] and x[k] - y[i] > 0.0:
                    share = (x[k] - low[k]) / (x[k] - y[i])
                    if share < step:
                        step, hit = share, k
                elif y[i] > high[k] and y[i] - x[k] > 0.0:
                    share = (high[k] - x[k]) / (y[i] - x[k])
                    if share < step:
                        step, hit = share, k
            for i in range(m):
                x[free[i]] += step * (y[i] - x[free[i]])
            if hit < 0:
                break
            state[hit] = -1 if y[np.searchsorted(free, hit)] < low[hit] else 1
            x[hit] = low[hit] if state[hit] < 0 else high[hit]
        # Release the bound that hurts most.
        worst, which = 0.0, -1
        for k in range(p):
            if state[k] != 0 and high[k] > low[k]:
                slope = r[k]
                for j in range(p):
                    slope -= G[k, j] * x[j]
                gain = slope * np.sqrt(1.0 / G[k, k])
                if state[k] > 0:
                    gain = -gain
                if gain > worst + SAME:
                    worst, which = gain, k
        if which < 0:
            break
        state[which] = 0
    return x
