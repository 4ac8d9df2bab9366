# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Laws that may be true beside the one that a search names."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.law_checks import (
    LawCheck,
    bend_check,
    in_place_check,
    knee_check,
    unfaded_check,
)
from sosml_friction.identification.law.law_in_place import LawInPlace
from sosml_friction.identification.law.law_problem import EXPONENT, LawSolution
from sosml_friction.identification.law.law_search import LawSearch
from sosml_friction.model.laws import FrictionLaw, law_definition, law_of
from sosml_friction.model.terms.nonlinear_viscous import NonlinearViscous
from sosml_friction.model.terms.viscous_asymmetry import ViscousAsymmetry
from sosml_friction.regression.rival import rival_probability

#: A law that is as probable as this is told.
_TOLD = 0.95
#: Variance of what is anywhere between two laws alike, in squares of their difference, on both
#: sides of one of them.
_BETWEEN = 1.0 / 3.0
#: What a law may have beside its terms.
_BESIDE = (NonlinearViscous.identifier, ViscousAsymmetry.identifier)
#: Speeds at which two laws are compared.
_COMPARED = 100


class OtherLaws:
    """
    Ask which laws explain more than a named one, or may be as true, and what they change.

    Those are what fits better by less than what shows it, the broad knee with its probability, and
    a power of speed in place of the Stribeck term with its own, where that is not told the nearest
    of them with one power of speed beside it, where the data show one, and viscous friction that
    differs by direction, with its probability. Of a law that is in place of a Stribeck term, the
    law with that term.

    ``is_faded``: whether the named law has a Stribeck term that no such power explains more than;
    ``curves``: each with its probability; ``checks``: what is to be said; ``moved``: by how much
    parameters differ from those of the named law, each law's times the root of its probability.
    """

    def __init__(
        self,
        search: LawSearch,
        named: LawSolution,
        shown: bool,
        effort_unit: str,
        in_place: LawInPlace | None = None,
    ) -> None:
        self.search, self.problem, self.named = search, search.problem, named
        self.curves: list[tuple[FrictionLaw, float]] = []
        self.checks: list[LawCheck] = []
        self.moved: list[dict[str, float]] = []
        self.found = search.found(named)
        if in_place is not None:
            self.problem, self.found = in_place.problem, in_place.found
            self._add_bend(in_place, effort_unit)
            if self.problem.power is not None:
                self.is_faded = False
                if self.problem.form.symmetric:
                    self._add_asymmetric()
                return
        for law in search.unshown(shown):
            self._add(law, self.problem.values_of(law), 1.0)
        nearest, broad = named, search.broad() if shown else None
        if broad is not None:
            law, probability = broad
            values = self.problem.values_of(law)
            self._add(law, values, probability)
            if probability > _TOLD:
                nearest = law
                self.checks.append(knee_check(values, effort_unit))
        self.is_faded = shown and not self._add_unfaded(nearest, effort_unit)
        if self.is_faded or not shown:
            self._add_bent(nearest, effort_unit)
        if self.problem.form.symmetric:
            self._add_asymmetric()

    def variance(self, name: str) -> float:
        """Return what the laws add to the variance of a parameter: the sum of p d^2."""
        return sum(d.get(name, 0.0) ** 2 for d in self.moved)

    def _add_bend(self, in_place: LawInPlace, effort_unit: str) -> None:
        """
        Add the law with the Stribeck term that is none.

        A term that is seen in part is Coulomb friction at standstill: there it counts in full, and
        what B is beside it no data tell. With a sign that is as wide, friction is anywhere between
        the laws.
        """
        full, named = self.search.full, self.problem.values_of(self.named)
        bend = self.search.problem.values_of(full)
        if self.problem.power is None:
            self._add(full, bend, _BETWEEN)
            return
        more = 1.0 - in_place.probability
        self.curves.append((self._curve(full, bend), more))
        if not self.search.is_smooth(full):
            level = bend['coulomb'] + bend['stribeck'] - named['coulomb']
            self.moved.append({'coulomb': float(np.sqrt(more)) * level})
        terms = ','.join(self._curve(self.named, named).definition.terms)
        self.checks.append(in_place_check(named, terms, effort_unit))

    def _add_unfaded(self, nearest: LawSolution, effort_unit: str) -> bool:
        """Add the law with a power of speed and no Stribeck term; tell whether it is likelier."""
        found = self.search.unfaded(nearest)
        if found is None:
            return False
        law, values, probability = found
        self._add(law, values, probability)
        if probability <= _TOLD:
            return False
        terms = ','.join(self._curve(law, values).definition.terms)
        self.checks.append(unfaded_check(values, terms, effort_unit))
        return True

    def _add_bent(self, nearest: LawSolution, effort_unit: str) -> None:
        """Add the law with a power of speed, where the data show one; and say so if it matters."""
        search = self.search
        found = search.bent(nearest, self.named)
        if found is None:
            return
        law, values = found
        speeds = np.geomspace(search.slowest, search.fastest, _COMPARED)
        # At standstill too, where Coulomb friction is what a law says of it.
        speeds = np.append(0.0, speeds)
        plain = self._friction(nearest, self.problem.values_of(nearest), speeds)
        bent = self._friction(law, values, speeds)
        check = bend_check(
            speeds,
            plain,
            bent,
            values['power'],
            ','.join(self._curve(nearest, self.problem.values_of(nearest)).definition.terms),
            effort_unit,
        )
        # A recording may be surer of friction than a bend that is not worth a sentence.
        self._add(law, values, _BETWEEN)
        if check is not None:
            self.checks.append(check)

    def _add_asymmetric(self) -> None:
        """
        Add the law with viscous friction B + D forwards and B - D backwards.

        D |v| is a bias where speeds are much the same. Friction is not negative either way: D is
        as likely 0 as anywhere from -B to B. With its error that makes a probability and a D^2.
        """
        law, (name,) = self.named, ViscousAsymmetry.amplitudes
        free = self.problem.asymmetric()
        best = free.solve(law.v_s, law.v0, law.alpha, law.weights)
        C, values = free.covariance(best, self.found), free.values_of(best)
        own, size = C[name, name], values[name]
        before = _BETWEEN * (values['viscous'] ** 2 + C['viscous', 'viscous'])
        if not (own > 0.0 and before > 0.0):
            return
        share = before / (before + own)
        excess = float(np.log1p(before / own)) - share * size**2 / own
        size = float(np.copysign(np.sqrt((share * size) ** 2 + share * own), size))
        rest = self.problem.less(size * self.problem.speed)
        other = rest.solve(law.v_s, law.v0, law.alpha, law.weights)
        self._add(other, {**rest.values_of(other), name: size}, rival_probability(excess))

    def _add(self, law: LawSolution, values: Mapping[str, float], probability: float) -> None:
        named, root = self.problem.values_of(self.named), float(np.sqrt(probability))
        self.curves.append((self._curve(law, values), probability))
        self.moved.append({n: root * (values[n] - named[n]) for n in named if n in values})

    def _friction(
        self, law: LawSolution, values: Mapping[str, float], speeds: FloatArray
    ) -> FloatArray:
        """Return the friction of a law at speeds, of which the first is standstill."""
        level = self._curve(replace(law, v0=0.0), values).torque(np.finfo(float).tiny)
        return np.append(level, self._curve(law, values).torque(speeds[1:]))

    def _curve(self, law: LawSolution, values: Mapping[str, float]) -> FrictionLaw:
        """Return the law of these parameters, with the knee and the sign of ``law``."""
        form, broad = self.problem.form, np.isnan(law.alpha)
        alpha = form.usual if broad else law.alpha
        known = {EXPONENT: alpha, **values}
        terms = law_definition(form.identifier(None if law.v_s is None else alpha)).terms
        more = [term for term in _BESIDE if term in values and term not in terms]
        definition = law_of([*terms, *more], known)
        curve = FrictionLaw(definition, {n: known[n] for n in definition.parameter_names}, law.v0)
        return curve.rival() if broad else curve
