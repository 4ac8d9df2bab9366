# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The values of given terms: sizes, inner parameters and one covariance of everything fitted."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.evidence import CandidateColumns, Fit
from sosml_friction.regression.inner_search import refine
from sosml_friction.regression.whitened import WhitenedRegression

#: Step of an inner parameter for the slope of the columns, as a share of it: the error of the
#: central difference is of the order of its square.
_STEP = 1e-3
#: The search is over where a round moves no inner parameter by more than this share of itself.
_SETTLED, _MOST_ROUNDS = 1e-3, 8


@dataclass(frozen=True)
class Placed:
    """Hold a term in a joint (0 or ``ROBOT``: in the whole robot) with its inner parameters."""

    term: Term
    joint: int
    inner: Inner
    columns: CandidateColumns


@dataclass(frozen=True)
class Estimate:
    """
    Hold the values of terms beside the nominal model.

    ``fit``: of the nominal's deviations, then the amplitudes of ``placed`` in order; ``errors``:
    their standard errors (p + k,); ``inner_errors``: of each term, those of its inner parameters.
    """

    placed: tuple[Placed, ...]
    fit: Fit
    errors: FloatArray
    inner_errors: tuple[Mapping[str, float], ...]

    def fitted(self, laboratory: WhitenedRegression) -> list[Fitted]:
        """Return what was found of each term, as the term is asked about it."""
        result = []
        for k, part in enumerate(slices(laboratory, self.placed)):
            placed = self.placed[k]
            result.append(
                Fitted(
                    laboratory.signals[0],
                    placed.joint,
                    placed.inner,
                    self.fit.baseline.x[part],
                    self.errors[part],
                    self.inner_errors[k],
                )
            )
        return result

    def parameters(self, laboratory: WhitenedRegression) -> list[dict[str, Parameter]]:
        """Return the parameters of each term."""
        return [
            placed.term.parameters(fitted)
            for placed, fitted in zip(self.placed, self.fitted(laboratory), strict=True)
        ]


def slices(laboratory: WhitenedRegression, placed: Sequence[Placed]) -> list[slice]:
    """Return where the amplitudes of each term are among the parameters."""
    result = []
    first = len(laboratory.nominal.bound)
    for each in placed:
        count = each.columns.C.shape[3]
        result.append(slice(first, first + count))
        first += count
    return result


def settle(
    laboratory: WhitenedRegression,
    placed: Sequence[Placed],
    step: Callable[[str], None] = lambda text: None,
) -> list[Placed]:
    """
    Return terms with the inner parameters that are best beside one another.

    Each is searched with all others as they are, round after round, until none moves.
    """
    result = list(placed)
    if len(result) < 2 or not any(each.term.refined for each in result):
        return result
    for number in range(_MOST_ROUNDS):
        step(f'settling the inner parameters, round {number + 1}')
        moved = 0.0
        for k, each in enumerate(result):
            if not each.term.refined:
                continue
            others = [other.columns for j, other in enumerate(result) if j != k]
            fit = Fit.make(laboratory.system.extended(others), laboratory.y)
            inner, _, columns = refine(laboratory, fit, each.term, each.joint, each.inner)
            for name in each.term.refined:
                size = max(abs(each.inner[name]), np.finfo(float).tiny)
                moved = max(moved, abs(inner[name] - each.inner[name]) / size)
            result[k] = replace(each, inner=inner, columns=columns)
        if moved < _SETTLED:
            break
    return result


def estimate(laboratory: WhitenedRegression, placed: Sequence[Placed]) -> Estimate:
    """Return sizes and errors of terms whose inner parameters are settled."""
    columns = [each.columns for each in placed]
    fit = Fit.make(laboratory.system.extended(columns), laboratory.y)
    errors, inner_errors = _errors(laboratory, placed, fit)
    return Estimate(tuple(placed), fit, errors, inner_errors)


def _errors(
    laboratory: WhitenedRegression, placed: Sequence[Placed], fit: Fit
) -> tuple[FloatArray, tuple[Mapping[str, float], ...]]:
    """
    Return the standard errors of all parameters, and of the inner ones.

    From the whitened normal equations of deviations, amplitudes and inner parameters together,
    these by the slope of their columns times the amplitudes; scaled by what is left where that is
    more than noise.
    """
    system, found = fit.system, fit.baseline
    known = system.Z.shape[2]
    slopes: list[CandidateColumns] = []
    owners: list[tuple[int, str]] = []
    for k, (each, part) in enumerate(zip(placed, slices(laboratory, placed), strict=True)):
        bounds = each.term.inner_bounds(laboratory.signals[0], each.joint)
        for name in each.term.refined:
            if name in bounds:
                slopes.append(_slope(laboratory, each, name, found.x[part]))
                owners.append((k, name))
    wide = system.extended(slopes)
    G = wide.G.sum(axis=(0, 1)) + np.diag(wide.penalty())
    scale = 1.0 / np.sqrt(np.diag(G))
    covariance = np.linalg.pinv(G * scale * scale[:, None]) * scale * scale[:, None]
    left = max(found.cost / float(laboratory.known.sum()), 1.0)
    errors = np.sqrt(np.maximum(np.diag(covariance) * left, 0.0))
    inner: list[dict[str, float]] = [{} for _ in placed]
    for (k, name), error in zip(owners, errors[known:], strict=True):
        inner[k][name] = float(error)
    return errors[:known], tuple(inner)


def _slope(
    laboratory: WhitenedRegression, each: Placed, name: str, amplitude: FloatArray
) -> CandidateColumns:
    """Return the slope over an inner parameter of what a term explains, as one column."""
    own = float(each.inner[name])
    h = _STEP * max(abs(own), np.finfo(float).tiny)
    ahead, behind = (
        laboratory.single(each.term, each.joint, {**each.inner, name: own + sign * h})
        for sign in (1.0, -1.0)
    )
    change = (ahead.C - behind.C) @ amplitude / (2.0 * h)
    return CandidateColumns.make(laboratory.system, each.columns.rows, change[..., None])


def place(
    laboratory: WhitenedRegression,
    wanted: Sequence[tuple[str, int]],
    step: Callable[[str], None] = lambda text: None,
) -> list[Placed]:
    """
    Return candidates with their inner parameters, in the order of what they explain.

    As a diagnosis accepts causes: the one that explains most at the best point of its grid first,
    refined beside those before it.

    :param wanted: identifier and joint of candidates of the laboratory.
    """
    left = [
        (candidate, columns)
        for candidate, columns in zip(laboratory.candidates, laboratory.columns, strict=True)
        if (candidate.effect.identifier, candidate.joint) in wanted
    ]
    placed: list[Placed] = []
    while left:
        fit = Fit.make(laboratory.system.extended([each.columns for each in placed]), laboratory.y)
        scores = [fit.score(columns) for _, columns in left]
        k = int(np.argmax([s.gain for s in scores]))
        candidate, _ = left.pop(k)
        term, joint = candidate.effect, candidate.joint
        step(f'fitting {term.identifier}')
        start = candidate.grid[scores[k].best]
        inner, _, columns = refine(laboratory, fit, term, joint, start)
        placed.append(Placed(term, joint, inner, columns))
    return placed
