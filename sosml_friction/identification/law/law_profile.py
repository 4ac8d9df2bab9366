# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The profile of the cost over the Stribeck velocity, and what it leaves open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.law_problem import EXPONENT, SIGN_WIDTH
from sosml_friction.identification.law.law_search import LawSearch, within
from sosml_friction.model.terms.kinds.fading_term import fade

#: Number of points of the profile near the best fit.
_NEAR = 13


@dataclass(frozen=True)
class LawProfile:
    """
    Hold the profile of the cost.

    ``excess`` (K,) is the least cost at each ``stribeck_velocity`` (K,) [rad/s or m/s] above the
    least of all, in units of the 95 % limit: up to 1 is within. ``stribeck`` (K,) is the best S
    there, ``half`` (K,) [Nm or N] half of the range of S within the limit, NaN outside, and
    ``exponent`` (K,) the best alpha, the same at all v_s where it was not found.
    """

    stribeck_velocity: FloatArray
    excess: FloatArray
    stribeck: FloatArray
    half: FloatArray
    exponent: FloatArray

    @classmethod
    def over(cls, search: LawSearch, limit: float, near: FloatArray | None = None) -> LawProfile:
        """Return the profile within ``limit`` of cost; v0 moves, and the exponent, if not told."""
        problem, full = search.few, search.full
        sought = [SIGN_WIDTH] if SIGN_WIDTH in search.found(full) else []
        sought += [EXPONENT] if search.finds_alpha else []
        least = search.solve(full.v_s, full.v0, full.alpha).cost
        costs, best, half, exponents = [], [], [], []
        grid = search.grid if near is None else np.sort(np.append(search.grid, near))
        for v_s in grid.tolist():
            fit = search.at(v_s)
            X = problem.columns(v_s, fit.v0, fit.alpha)
            names, J = problem.jacobian(fit, tuple(sought))
            bends = within(fit.alpha, search.exponents)
            free = [name for name in sought if name != EXPONENT or bends]
            moves = [names.index(name) for name in free]
            X = np.column_stack([X, J[:, [j for j in moves if J[:, j].any()]]])
            rest = fit.residual
            k = problem.names(v_s).index('stribeck')
            others = [j for j in range(X.shape[1]) if j != k]
            Q = np.linalg.qr(X[:, others])[0]
            own = X[:, k] - Q @ (Q.T @ X[:, k])
            left = rest - Q @ (Q.T @ rest) if moves else rest
            size = float(own @ own)
            cost = float(left @ left)
            S = problem.stribeck_at(fit)
            if size > 1e-24 * float(X[:, k] @ X[:, k]):
                # From the bound S >= 0, or with v0 moved, it may go on.
                step = max(float(own @ left) / size, -S)
                S, cost = S + step, cost - step * (2.0 * float(own @ left) - step * size)
                room = least + limit - cost
                half.append(float(np.sqrt(room / size)) if room >= 0.0 else np.nan)
            else:
                half.append(np.inf if least + limit >= cost else np.nan)
            exponents.append(fit.alpha)
            costs.append(cost)
            best.append(S)
        rise = np.array(costs) - min(least, min(costs))
        safe = limit if limit > 0.0 else 1e-300
        return cls(grid, rise / safe, np.array(best), np.array(half), np.array(exponents))

    def velocity_interval(self, limits: float = 1.0) -> tuple[float, float]:
        """Return the range of v_s of an excess below ``limits``; an open end is 0 or infinite."""
        u, best = np.log(self.stribeck_velocity), int(np.argmin(self.excess))
        below = _crossing(u[: best + 1][::-1], self.excess[: best + 1][::-1] / limits)
        above = _crossing(u[best:], self.excess[best:] / limits)
        return (
            0.0 if below is None else float(np.exp(below)),
            np.inf if above is None else float(np.exp(above)),
        )

    def stribeck_interval(self, speed: float = 0.0) -> tuple[float, float]:
        """
        Return the range of S exp(-(speed / v_s)^alpha) within the limit, over all v_s; S >= 0.

        At speed 0, which is S itself, it has no upper end where v_s may be next to nothing.
        """
        within = np.isfinite(self.half)
        if not within.any():
            return 0.0, np.inf
        faded = fade(np.asarray(speed), self.stribeck_velocity[within], self.exponent[within])
        best, half = self.stribeck[within], self.half[within]
        low = float(np.min((best - half) * faded))
        high = float(np.max((best + half) * faded))
        open_ = speed == 0.0 and bool(within[0])
        return max(low, 0.0), np.inf if open_ else max(high, 0.0)

    def with_best(self, drawn: Mapping[str, float]) -> tuple[FloatArray, ...]:
        """Return v_s, excess, S and half its range, the best fit ``drawn`` among the points."""
        v, own = self.stribeck_velocity, (self.excess, self.stribeck, self.half)
        v_s, size = drawn.get('stribeck_velocity', np.nan), drawn.get('stribeck', np.nan)
        if not np.isfinite([v_s, size]).all() or np.isclose(v, v_s, rtol=1e-9, atol=0.0).any():
            return v, *own
        k = int(np.searchsorted(v, v_s))
        best = (0.0, size, self.half[min(k, len(v) - 1)])
        more = (np.insert(x, k, its) for x, its in zip(own, best, strict=True))
        return np.insert(v, k, v_s), *more


def _crossing(u: FloatArray, excess: FloatArray) -> float | None:
    """Return where ``excess``, from its least on, exceeds 1, or None."""
    # A cost is a parabola about its minimum: its root is nearly straight.
    root = np.sqrt(np.maximum(excess, 0.0))
    beyond = np.flatnonzero(root > 1.0)
    if not len(beyond):
        return None
    k = max(int(beyond[0]), 1)
    return float(u[k - 1] + (u[k] - u[k - 1]) * (1.0 - root[k - 1]) / (root[k] - root[k - 1]))


def about_best(search: LawSearch, v_s: float, half: float) -> FloatArray:
    """Return v_s of the best fit, and about where its interval ends, ``half`` to each side."""
    # Further than the grid it says nothing.
    half = min(half, float(np.log(search.grid[-1] / search.grid[0])))
    near = v_s * np.exp(half * np.linspace(-1.6, 1.6, _NEAR))
    return np.unique(near[(near > search.grid[0]) & (near < search.grid[-1])])
