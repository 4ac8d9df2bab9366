# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Laws that may be true beside the one that a search names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sosml_friction.identification.law.bent_law import BentLaw
from sosml_friction.identification.law.law_checks import LawCheck, bend_check, knee_check
from sosml_friction.identification.law.law_problem import LawSolution
from sosml_friction.identification.law.law_search import LawSearch
from sosml_friction.model.laws import FrictionLaw, law_definition

#: A law that is as probable as this is told.
_TOLD = 0.95
#: Variance of what is anywhere between two laws alike, in squares of their difference, on both
#: sides of one of them.
_BETWEEN = 1.0 / 3.0
#: Speeds at which two laws are compared.
_COMPARED = 100


class OtherLaws:
    """
    Ask which laws explain more than a named one, or may be as true, and what they change.

    Those are what fits better by less than what shows it, the broad knee with its probability, and
    the nearest of them with one power of speed, where the data show one.

    ``curves``: each with its probability; ``checks``: what is to be said; ``moved``: by how much
    parameters differ from those of the named law, each law's times the root of its probability.
    """

    def __init__(
        self, search: LawSearch, named: LawSolution, shown: bool, effort_unit: str
    ) -> None:
        self.search, self.problem, self.named = search, search.problem, named
        self.curves: list[tuple[FrictionLaw | BentLaw, float]] = []
        self.checks: list[LawCheck] = []
        self.moved: list[dict[str, float]] = []
        for law in search.unshown(shown):
            self._add(law, self._curve(law), 1.0)
        nearest, broad = named, search.broad() if shown else None
        if broad is not None:
            law, probability = broad
            self._add(law, self._curve(law), probability)
            if probability > _TOLD:
                nearest = law
                self.checks.append(knee_check(self.problem.values_of(law), effort_unit))
        self._add_bent(nearest, effort_unit)

    def variance(self, name: str) -> float:
        """Return what the laws add to the variance of a parameter: the sum of p d^2."""
        return sum(d.get(name, 0.0) ** 2 for d in self.moved)

    def _add_bent(self, nearest: LawSolution, effort_unit: str) -> None:
        """Add the law with a power of speed, where the data show one that matters."""
        search, where = self.search, len(self.problem.base)
        found = search.bent(nearest, self.named)
        if found is None:
            return
        law, power = found
        plain = replace(law, theta=np.delete(law.theta, where))
        bent = BentLaw(self._curve(plain), float(law.theta[where]), power, search.fastest)
        speeds = np.geomspace(search.slowest, search.fastest, _COMPARED)
        straight = self._curve(nearest).torque(speeds)
        terms = ','.join(self._curve(nearest).definition.terms)
        check = bend_check(speeds, straight, bent.torque(speeds), power, terms, effort_unit)
        if check is not None:
            self.checks.append(check)
            self._add(plain, bent, _BETWEEN)

    def _add(self, law: LawSolution, curve: FrictionLaw | BentLaw, probability: float) -> None:
        own, named = self.problem.values_of(law), self.problem.values_of(self.named)
        root = float(np.sqrt(probability))
        self.curves.append((curve, probability))
        self.moved.append({n: root * (own[n] - named[n]) for n in named if n in own})

    def _curve(self, law: LawSolution) -> FrictionLaw:
        values, broad = self.problem.values_of(law), np.isnan(law.alpha)
        form = self.problem.form
        alpha = form.usual if broad else law.alpha
        definition = law_definition(form.identifier(None if law.v_s is None else alpha))
        own = {name: values[name] for name in definition.parameter_names}
        curve = FrictionLaw(definition, own, law.v0)
        return curve.rival() if broad else curve
