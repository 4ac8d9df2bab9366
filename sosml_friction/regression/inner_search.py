# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Inner parameters where the cost is least: what a fit and a diagnosis do alike."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.evidence import ANY, CandidateColumns, Fit, Score, possible
from sosml_friction.regression.inner_scale import moved
from sosml_friction.regression.placed import Placed
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.whitened import WhitenedRegression

#: First step of the search: of a frequency in units of 2.5 cycles over the joint's range, of any
#: other parameter as of inner_scale.py. About the distance of two grid points; no measurement.
_CYCLES, _FREQUENCY_STEP, _LOG_STEP = 2.5, 0.4, 0.3
#: A frequency is looked for this far to both sides first, in these steps, half a grid's [of that
#: unit]: where a joint passes a range in pieces, the cost has many minima of nearly the same
#: depth, and the grid may have missed the deepest. Halved and doubled, no answer of ``python -m
#: validation.sensitivity --seed 1`` changes.
_AROUND, _FINER = 10.0, 0.5
#: Evaluations for each parameter, and the difference of cost that ends the search before them
#: [noise variances]: a parameter is sqrt(0.05) of its standard error off then.
_MOST, _SAME_COST = 25, 0.05


def refine(
    laboratory: WhitenedRegression,
    fit: Fit,
    term: Term,
    joint: int,
    start: Inner,
    beside: Sequence[Placed] = (),
) -> tuple[Term, Inner, Score, CandidateColumns]:
    """
    Return a term with its inner parameters where the cost is least, its score and columns.

    The continuous ones are searched from ``start``, a frequency from the best around it, by Nelder
    and Mead's simplex, within their physical range, as of inner_scale.py; a frequency by cycles
    over the range of motion. A term that has one more (:meth:`Term.further`) is taken where it
    explains very strongly more, in units of what is left.

    :param beside: the terms of the fit.
    """
    inner, s, columns = _refined(laboratory, fit, term, joint, start)
    further = term.further(turning_displacement(laboratory, joint, beside))
    if further is None:
        return term, inner, s, columns
    other, more = further
    its = _refined(laboratory, fit, other, joint, {**inner, **more})
    left = max((fit.baseline.cost - s.gain) / float(laboratory.noise_energy.sum()), 1.0)
    if its[1].gain - s.gain > VERY_STRONG * left:
        return other, *its
    return term, inner, s, columns


def turning_displacement(
    laboratory: WhitenedRegression, joint: int, beside: Sequence[Placed]
) -> float:
    """Return over which displacement the friction of a joint turns around [rad or m]."""
    slow = [
        float(each.inner['displacement'])
        for each in beside
        if each.joint == joint and each.term.reversals_alone and 'displacement' in each.inner
    ]
    return max(float(laboratory.signals[0].scales.displacement[joint]), *slow, 0.0)


def _refined(
    laboratory: WhitenedRegression, fit: Fit, term: Term, joint: int, start: Inner
) -> tuple[Inner, Score, CandidateColumns]:
    bounds = term.searched_inner(laboratory.signals[0], joint)

    def at(inner: Inner) -> tuple[Score, CandidateColumns]:
        its = laboratory.single(term, joint, inner).beside(fit.system)
        return fit.score(its), its

    first, columns = at(start)
    if not bounds:
        return start, first, columns
    names = list(bounds)
    ends = list(bounds.values())
    low, high = np.array(ends).T
    periodic = names == ['frequency']
    span = float(laboratory.signals[0].scales.span[joint])
    if periodic:
        around = float(start['frequency']) + _CYCLES / span * np.arange(
            -_AROUND, _AROUND + _FINER, _FINER
        )
        inside = around[(around >= low[0]) & (around <= high[0])]
        grid = [start, *({**start, 'frequency': float(w)} for w in inside)]
        start = grid[fit.score(laboratory.on_grid(term, joint, grid).beside(fit.system)).best]
        first, columns = at(start)
    # What is possible stays so.
    within = term.amplitude_range if possible(first.amplitude, term.amplitude_range) else ANY
    origin = np.array([float(start[name]) for name in names])
    seen: dict[tuple[float, ...], float] = {}

    def inner_of(u: FloatArray) -> dict[str, float]:
        if periodic:
            x = np.clip(origin + u * _CYCLES / span, low, high).tolist()
        else:
            x = list(map(moved, origin.tolist(), u.tolist(), ends))
        return {**start, **dict(zip(names, x, strict=True))}

    def cost(u: FloatArray) -> float:
        inner = inner_of(u)
        key = tuple(inner[name] for name in names)
        if key not in seen:
            s, _ = at(inner)
            seen[key] = -s.gain if possible(s.amplitude, within) else -first.gain
        return seen[key]

    size = _FREQUENCY_STEP if periodic else _LOG_STEP
    inner = inner_of(_lowest(cost, len(names), size))
    best, its = at(inner)
    better = best.gain >= first.gain and possible(best.amplitude, within)
    return (inner, best, its) if better else (start, first, columns)


def _lowest(cost: Callable[[FloatArray], float], count: int, size: float) -> FloatArray:
    """Return where a cost is least, by Nelder and Mead's simplex, begun at 0 with a size."""
    simplex = np.vstack([np.zeros(count), size * np.eye(count)])
    left = _MOST * count
    while True:
        found = minimize(
            cost, simplex[0], method='Nelder-Mead',
            options={'initial_simplex': simplex, 'maxfev': left, 'xatol': np.inf,
                     'fatol': _SAME_COST},
        )  # fmt: skip
        left -= found.nfev
        # Equal on both sides of a minimum is no end.
        corners = found.final_simplex[0]
        middle = corners.mean(axis=0)
        if left < count + 1 or cost(middle) > found.fun - _SAME_COST:
            return np.asarray(found.x)
        simplex = np.vstack([middle, middle + 0.5 * (corners[1:] - middle)])
