# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Inner parameters where the cost is least: what a fit and a diagnosis do alike."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.evidence import (
    Baseline,
    CandidateColumns,
    Score,
    System,
    Target,
    score,
)
from sosml_friction.regression.laboratory import Laboratory

FloatArray = NDArray[np.float64]

#: First steps of the search: of a size, as a natural logarithm, and of a frequency, in steps of
#: the grid on which it was found.
_STEP_OF_SIZE, _STEP_OF_FREQUENCY, _FREQUENCY_STEP = 0.3, 0.4, 2.5
#: Evaluations for each parameter, and what ends the search before: of the logarithm, of the cost.
_MOST, _SAME_PLACE, _SAME_COST = 25, 0.01, 0.5


def at_inner(
    laboratory: Laboratory, system: System, target: Target, baseline: Baseline, term: Term,
    joint: int, inner: Inner,
) -> tuple[Score, CandidateColumns]:  # fmt: skip
    """Return the evidence of a term at one value of its inner parameters, and its columns."""
    its = laboratory.single(term, joint, inner).beside(system)
    return score(system, target, baseline, its, its.products(system, target.y)), its


def refine(
    laboratory: Laboratory, system: System, target: Target, baseline: Baseline, term: Term,
    joint: int, start: Inner,
) -> tuple[Inner, Score, CandidateColumns]:  # fmt: skip
    """
    Return the inner parameters of a term where the cost is least, with score and columns.

    The continuous ones are searched from ``start`` by Nelder and Mead's simplex, within their
    physical range; sizes by their logarithm, a frequency by cycles over the range of motion.
    """
    bounds = term.inner_bounds(laboratory.signals[0], joint)
    names = [name for name in term.refined if name in bounds]

    def at(inner: Inner) -> tuple[Score, CandidateColumns]:
        return at_inner(laboratory, system, target, baseline, term, joint, inner)

    first, columns = at(start)
    if not names:
        return start, first, columns
    periodic = names == ['frequency']
    origin = np.array([float(start[name]) for name in names])
    low, high = (np.array([bounds[name][k] for name in names]) for k in (0, 1))
    span = float(laboratory.signals[0].scales.span[joint])
    seen: dict[tuple[float, ...], float] = {}

    def inner_of(u: FloatArray) -> dict[str, float]:
        x = origin + u * _FREQUENCY_STEP / span if periodic else origin * np.exp(u)
        return {**start, **dict(zip(names, np.clip(x, low, high).tolist(), strict=True))}

    def cost(u: FloatArray) -> float:
        inner = inner_of(u)
        key = tuple(inner[name] for name in names)
        if key not in seen:
            seen[key] = -at(inner)[0].gain
        return seen[key]

    size = _STEP_OF_FREQUENCY if periodic else _STEP_OF_SIZE
    simplex = np.vstack([np.zeros(len(names)), size * np.eye(len(names))])
    found = minimize(
        cost,
        np.zeros(len(names)),
        method='Nelder-Mead',
        options={'initial_simplex': simplex, 'maxfev': _MOST * len(names),
                 'xatol': _SAME_PLACE, 'fatol': _SAME_COST},
    )  # fmt: skip
    inner = inner_of(found.x)
    best, its = at(inner)
    return (inner, best, its) if best.gain >= first.gain else (start, first, columns)
