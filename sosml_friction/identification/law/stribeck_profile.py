# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The profile of the cost of a law over its Stribeck velocity."""

from __future__ import annotations

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.law_problem import EXPONENT, SIGN_WIDTH
from sosml_friction.identification.law.law_profile import LawProfile
from sosml_friction.identification.law.law_search import LawSearch, within

#: Number of points of the profile near the best fit.
_NEAR = 13


def stribeck_profile(
    search: LawSearch, limit: float, near: FloatArray | None = None
) -> LawProfile:
    """
    Return the profile over v_s: v0 moves along where it is found, the exponent unless it is told.

    :param limit: rise of the cost up to which it is within.
    :param near: more v_s to ask for: the grid may be wider than the interval.
    """
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
    return LawProfile(grid, rise / safe, np.array(best), np.array(half), np.array(exponents))


def about_best(search: LawSearch, v_s: float, half: float) -> FloatArray:
    """
    Return v_s of the best fit, and about where its interval should end.

    :param half: half of that interval, as a share of v_s.
    """
    # Further than the grid it says nothing.
    half = min(half, float(np.log(search.grid[-1] / search.grid[0])))
    near = v_s * np.exp(half * np.linspace(-1.6, 1.6, _NEAR))
    return np.unique(near[(near > search.grid[0]) & (near < search.grid[-1])])
