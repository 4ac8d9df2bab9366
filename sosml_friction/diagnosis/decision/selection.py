# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the search for causes ends with."""

from dataclasses import dataclass, field

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.leftover import Leftover
from sosml_friction.regression.evidence import Baseline, Fit, System
from sosml_friction.regression.whitened import WhitenedRegression


@dataclass
class Selection:
    """
    Hold what was accepted, in order, and what the search was left with.

    ``before``: the fit without causes; ``fit``: with the accepted ones. ``ranking``: the first
    round's candidates, best first; ``rejected``: the best that was not accepted, with the gates
    it failed; ``masked``: the impossible one that explains more than the best possible one.
    ``structure_*``: what free curves without physics still explain of each joint on data left out
    (n,), as a share, its floor, and as energy; ``leftovers``: what free curves along the axes of
    the accepted still explain; ``named_energy``: what the accepted explain on data left out.
    """

    before: Baseline
    fit: Fit
    accepted: list[Finding] = field(default_factory=list)
    ranking: list[Finding] = field(default_factory=list)
    rejected: Finding | None = None
    masked: Finding | None = None
    structure_gain: FloatArray = field(default_factory=lambda: np.zeros(0))
    structure_floor: FloatArray = field(default_factory=lambda: np.zeros(0))
    structure_energy: FloatArray = field(default_factory=lambda: np.zeros(0))
    named_energy: float = 0.0
    leftovers: tuple[Leftover, ...] = ()

    @property
    def after(self) -> Baseline:
        """Return the parameters with the accepted causes: the nominal's, then amplitudes."""
        return self.fit.baseline

    @property
    def system(self) -> System:
        """Return the normal equations with the accepted causes."""
        return self.fit.system

    def refit(self, laboratory: WhitenedRegression) -> None:
        """Fit the causes that are accepted now."""
        system = laboratory.system.extended([f.columns for f in self.accepted])
        self.fit = Fit.make(system, laboratory.y)
