# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that follows the law over a distance, as bristles do, and not at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.identification.law.jackknife import (
    jackknife_covariance,
    jackknife_freedom,
    t_95,
)
from sosml_friction.identification.law.law_problem import (
    EXPONENT,
    SIGN_WIDTH,
    LawProblem,
    LawSolution,
)
from sosml_friction.identification.law.law_search import LawSearch
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.kinds.fading_term import EXPONENTS, fade
from sosml_friction.regression.column_norms import column_norms

#: The longest distance is what v_s goes in this time [s], that of a test function; a search begins
#: at the best of some shares of it. One below the first is none. Chosen, no measurement.
_LONGEST_S, _SHARES = 0.1, np.geomspace(1e-3, 0.3, 6)
#: Step of the derivative by the distance, as a share of it; that of the search, and where it ends.
_STEP, _DIFFERENCE, _CLOSE = 0.05, 1e-3, 1e-4
#: A sign as narrow as this share of the one that was found is the sign itself; a search begins as
#: far as this within its ends.
_FLAT, _INSIDE = 1e-2, 1e-6


@dataclass(frozen=True)
class FrictionMemory:
    """
    Hold over which distance friction follows its law.

    Bristles of stiffness s_0 (LuGre without damping) have F' = s_0 (1 - F / f(v)) |v|: over
    the distance x = f / s_0 friction becomes what the law f says,

        x dF / d|q| = f(v) - F,        F = f(v) - x f'(v) a / |v| where x is short.

    Where the knee is crossed slowly F is f. Where it is crossed within x, as after each start, F
    is larger than f when the joint gets faster, and smaller when it gets slower.

    ``distance`` and ``std_error`` [rad or m]; ``shown``: whether it is more than chance, in 5 %;
    ``dry`` (N,): f at all velocities; ``effort`` (K,): means of F - f if x is alike at
    all speeds; ``bristles`` (K,): if it is one standard error more, and goes with f.
    """

    distance: float
    std_error: float
    shown: bool
    dry: FloatArray
    effort: FloatArray
    bristles: FloatArray


@compiled
def followed(column: FloatArray, moved: FloatArray, first: BoolArray) -> FloatArray:
    """
    Return means over each interval of what follows a column (N,).

    :param moved: in each interval, in units of the distance over which it follows.
    :param first: where a stretch begins: there it is the column itself.
    """
    result, state = np.empty_like(column), column[0]
    for k in range(len(column)):
        if first[k]:
            state = column[k]
        behind, left = state - column[k], np.exp(-moved[k])
        mean = (1.0 - left) / moved[k] if moved[k] > 1e-9 else 1.0
        result[k] = column[k] + behind * mean
        state = column[k] + behind * left
    return result


def friction_memory(
    search: LawSearch, following: Callable[[FloatArray, FloatArray], FloatArray], keep: BoolArray
) -> FrictionMemory | None:
    """
    Find the distance over which dry friction follows, beside all parameters of its law.

    :param following: the means (K,) of what follows a column at all velocities over a distance.
    :param keep: rows that take part (K,).
    :return: None where the law has no knee, or friction follows at once.
    """
    best = search.full
    if best.v_s is None or not search.shows_stribeck():
        return None
    longest = _LONGEST_S * best.v_s
    ends = {'distance': (0.0, 1.0), 'stribeck_velocity': (search.grid[0], search.grid[-1])}
    begin = {'distance': 0.0, 'stribeck_velocity': best.v_s}
    if search.finds_alpha:
        ends[EXPONENT], begin[EXPONENT] = EXPONENTS, best.alpha
    if search.finds_v0 and best.v0 > 0.0:
        ends[SIGN_WIDTH], begin[SIGN_WIDTH] = (_FLAT * best.v0, search.widest), best.v0
    # The distance may be none; the others are searched by their logarithms.
    low, high = (np.array([k[0], *np.log(k[1:])]) for k in zip(*ends.values(), strict=True))
    start = np.clip([0.0, *np.log(list(begin.values())[1:])], low + _INSIDE, high - _INSIDE)

    alike = np.ones_like(search.problem.v)

    def over(distance: float) -> LawProblem:
        return search.problem.made_by(lambda column: following(column, distance * alike)[keep])

    def solved(u: FloatArray) -> LawSolution:
        p = dict(zip(ends, [u[0], *np.exp(u[1:])], strict=True))
        v0, alpha = p.get(SIGN_WIDTH, best.v0), p.get(EXPONENT, best.alpha)
        law = over(longest * p['distance'])
        return law.solve(p['stribeck_velocity'], v0, alpha, best.weights)

    size = max(float(np.linalg.norm(search.problem.y)), np.finfo(float).tiny)
    root = np.sqrt(best.weights) / size
    tried = [np.array([share, *start[1:]]) for share in _SHARES]
    u = least_squares(
        lambda u: root * solved(u).residual,
        min(tried, key=lambda u: solved(u).cost),
        bounds=(low, high),
        x_scale=np.where(np.arange(len(low)) > 0, 1.0, _SHARES[len(_SHARES) // 2]),
        diff_step=_DIFFERENCE,
        xtol=_CLOSE,
        max_nfev=30,
    ).x
    law, x = solved(u), float(longest * u[0])
    if not u[0] > _SHARES[0]:
        return None
    level, step = _level(search.problem, law), _STEP * x
    dry = smooth_sign(search.problem.v, law.v0) * level

    def effort(distance: float) -> FloatArray:
        return following(dry, distance * alike)

    slope = (effort(x + step) - effort(x - step))[keep] / (2.0 * step)
    X = np.column_stack([over(x).jacobian(law, tuple(ends))[1], slope])
    norms, groups = column_norms(X), search.problem.groups
    C = jackknife_covariance(X / norms, law.residual, groups, law.weights)
    freedom = jackknife_freedom(X / norms, groups, law.weights)[-1]
    error, at_once = float(np.sqrt(C[-1, -1]) / norms[-1]), effort(0.0)
    shown = x > t_95(freedom) * error
    # Of bristles x is f / s_0, of friction at v_s as it was found.
    p = search.problem.values_of(law)
    as_friction = level / (p['coulomb'] + p['stribeck'] / math.e)
    bristles = following(dry, (x + error) * as_friction)
    return FrictionMemory(x, error, shown, dry, effort(x) - at_once, bristles - at_once)


def _level(problem: LawProblem, law: LawSolution) -> FloatArray:
    """Return how much dry friction of a law is at all velocities, whatever the sign's width."""
    p = problem.values_of(law)
    assert law.v_s is not None
    size = p['stribeck'] + p.get('stribeck_asymmetry', 0.0) * np.sign(problem.v)
    return np.asarray(p['coulomb'] + size * fade(problem.speed, law.v_s, law.alpha))
