# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that grows or falls from the beginning to the end of a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.identification.law.jackknife import t_95
from sosml_friction.identification.law.law_checks import MATTERS, LawCheck
from sosml_friction.identification.law.law_problem import LawSolution
from sosml_friction.identification.law.law_search import LawSearch
from sosml_friction.regression.chance import CHANCE

TREND = 'trend'


@dataclass(frozen=True)
class FrictionTrend:
    """
    Hold how friction changes over a recording: f(v) (1 + r u + s (u^2 - its mean)).

    u goes with time and grows by 1; its mean is 0, so that f is the mean over the recording.
    ``share``: r, by which friction changes from beginning to end, and ``std_error`` of it;
    ``effort`` (K,): means of what changes [Nm or N]; ``unsure`` (K, 2): what it may be off by,
    each column as a whole by one standard deviation.
    """

    share: float
    std_error: float
    effort: FloatArray
    unsure: FloatArray

    def check(self) -> LawCheck | None:
        """Say how friction changes, None if that is too little to matter."""
        if abs(self.share) < MATTERS:
            return None
        way = 'grows' if self.share > 0.0 else 'falls'
        return LawCheck(
            TREND,
            False,
            f'Friction {way} by {100.0 * abs(self.share):.2g} +- {100.0 * self.std_error:.1g} % '
            'from the beginning of the recording to its end, as that of a joint does that warms '
            f'up or cools down (by chance alone: p < {CHANCE:g}). The law is its mean; to have '
            'that of a warm joint, move it until it is warm, then record.',
        )


def friction_trend(search: LawSearch, clusters: IndexArray) -> FrictionTrend | None:
    """
    Find how friction changes with time, beside all parameters of its law.

    A ladder that climbs once has fast motion late: what its Stribeck term explains may be the
    trend. So a law without the term stands where that explains no more than chance beside it.

    :param clusters: of the rows that take part (M,), numbers that go with time.
    :return: None where friction changes by no more than chance.
    """
    u = (clusters - np.mean(clusters)) / max(float(np.ptp(clusters)), 1.0)
    shapes = np.column_stack([u, u**2 - np.mean(u**2)])
    law = search.full if search.shows_stribeck() else search.plain
    line, C, freedom, _ = _beside(search, law, shapes[:, :1])
    if abs(line[0]) <= t_95(freedom[0], CHANCE) * float(np.sqrt(C[0, 0])):
        return None
    factors, C, _, cost = _beside(search, law, shapes)
    if law is search.full:
        plain = _beside(search, search.plain, shapes)
        if plain[-1] - cost <= search.knee_limit:
            law, (factors, C, _, _) = search.plain, plain
    columns = shapes * _friction(search, law)[:, None]
    variance, axes = np.linalg.eigh(C)
    # Of few clusters one of them may be none, but for rounding.
    root = axes * np.sqrt(np.maximum(variance, 0.0))
    return FrictionTrend(
        float(factors[0]), float(np.sqrt(C[0, 0])), columns @ factors, columns @ root
    )


def _friction(search: LawSearch, law: LawSolution) -> FloatArray:
    """Return the rows of friction by a law, without its bias."""
    problem = search.problem
    return np.asarray(problem.y - law.residual - problem.values_of(law)['bias'])


def _beside(
    search: LawSearch, law: LawSolution, shapes: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """
    Fit the friction of a law times ``shapes`` (K, M) beside its parameters.

    Return the factors (M,), their covariance and degrees of freedom, and the cost.
    """
    columns = shapes * _friction(search, law)[:, None]
    factors, C, freedom, left = search.problem.beside(law, search.found(law), columns)
    own = slice(-shapes.shape[1], None)
    cost = float(np.sum(law.weights * left**2))
    return factors[own], C[own, own], freedom[own], cost
