# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The law that stands in place of one whose Stribeck term is a bend."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.optimize import minimize_scalar

from sosml_friction.identification.law.law_problem import (
    POWER,
    SIGN_WIDTH,
    LawProblem,
    LawSolution,
)
from sosml_friction.identification.law.law_search import LEVEL, LawSearch
from sosml_friction.model.terms.nonlinear_viscous import POWERS

#: A power of speed is found to this. Chosen, no measurement.
_SAME_POWER = 1e-3


@dataclass(frozen=True)
class LawInPlace:
    """
    Hold the law that stands in place of one whose Stribeck term is a bend.

    ``problem`` is that of its ``solution``: of a power of speed, or of no term besides C and B.
    ``probability`` of it beside the law that it stands for, ``found``: parameters that are not
    linear and that were found.
    """

    problem: LawProblem
    solution: LawSolution
    probability: float
    found: tuple[str, ...] = ()

    @classmethod
    def of(cls, search: LawSearch) -> LawInPlace | None:
        """
        Return the law that is named in place of one whose Stribeck term is none, None if it is.

        A Stribeck term fades from Coulomb friction and more to Coulomb friction. One that has not
        faded at the fastest speed, or fades to nothing, or is no wider than its sign is a curve:
        C beside it is friction at speeds that no data have. A power of speed in its place, whose
        C is friction at standstill, is named unless the data refuse it; in place of a knee, only
        if its probability is 0.95.
        """
        full = search.full
        if search.form.law != 'auto' or full.v_s is None:
            return None
        near = search.unfaded(full)
        if near is not None:
            law = cls._near(search, near[0], near[1][POWER])
            if law.probability > (LEVEL if search.is_knee(full) else 1.0 - LEVEL):
                return law
        if not search.is_smooth(full):
            return None
        return cls(search.problem, search.plain, 0.0, search.found(search.plain))

    @classmethod
    def at_power(cls, search: LawSearch, power: float) -> LawInPlace:
        """Return the law of a power of speed that is known."""
        return cls(*_bent(search, power, search.plain), 1.0)

    @classmethod
    def _near(cls, search: LawSearch, law: LawSolution, power: float) -> LawInPlace:
        """
        Return the law of the power that explains most, near the best of those that are published.

        It has as many numbers as a law with a Stribeck term.
        """
        k = POWERS.index(power)
        v0, alpha, few = law.v0, law.alpha, search.few
        best = minimize_scalar(
            lambda power: few.bent(power).solve(None, v0, alpha, few.ones).cost,
            bounds=(POWERS[max(k - 1, 0)], POWERS[min(k + 1, len(POWERS) - 1)]),
            method='bounded',
            options={'xatol': _SAME_POWER},
        )
        tried = [_bent(search, each, law) for each in (power, float(best.x))]
        problem, solution = min(tried, key=lambda one: one[1].cost)
        found = (*((SIGN_WIDTH,) if search.finds_v0 and law.v0 > 0.0 else ()), POWER)
        return cls(problem, solution, search.probability(solution), found)


def _bent(search: LawSearch, power: float, like: LawSolution) -> tuple[LawProblem, LawSolution]:
    """Return the problem with a power of speed, and its law without a Stribeck term."""
    problem = search.problem.bent(power)
    return problem, problem.solve(None, like.v0, like.alpha, search.weights)
