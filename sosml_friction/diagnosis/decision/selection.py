# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the search for causes ends with."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.remainder import Remainder, remainder
from sosml_friction.regression.estimate import system_with
from sosml_friction.regression.evidence import Baseline, Fit, System
from sosml_friction.regression.whitened import WhitenedRegression


@dataclass(frozen=True)
class Selection:
    """
    Hold what was accepted, in order, and what the search was left with.

    ``before``: the fit without causes; ``fit``: with the accepted ones. ``ranking``: the first
    round's candidates, best first; ``rejected``: the best that was not accepted, with the gates
    it failed. ``refused``: the best of the last round against which nothing speaks but that it is
    impossible, None for none. ``remainder``: what is left beside the accepted that is not noise.
    ``laboratory``: with the load of the bodies that were found, None where the nominal's is meant.
    """

    before: Baseline
    fit: Fit
    accepted: tuple[Finding, ...] = ()
    ranking: tuple[Finding, ...] = ()
    rejected: Finding | None = None
    refused: Finding | None = None
    remainder: Remainder = field(default_factory=Remainder)
    laboratory: WhitenedRegression | None = None

    @property
    def after(self) -> Baseline:
        """Return the parameters with the accepted causes: the nominal's, then amplitudes."""
        return self.fit.baseline

    @property
    def system(self) -> System:
        """Return the normal equations with the accepted causes."""
        return self.fit.system

    def others(self, k: int) -> tuple[Finding, ...]:
        """Return the accepted causes but for one."""
        return (*self.accepted[:k], *self.accepted[k + 1 :])

    def refitted(self, laboratory: WhitenedRegression, accepted: Iterable[Finding]) -> 'Selection':
        """Return it with these causes accepted, fitted together."""
        accepted = tuple(accepted)
        system = system_with(laboratory, [finding.columns for finding in accepted])
        return replace(self, accepted=accepted, fit=Fit.make(system, laboratory.y))

    def taken_back(self, finding: Finding) -> 'Selection':
        """Return it with a cause that was accepted as the rejected one, but for a tone's place."""
        if self.rejected is not None and self.rejected.instead:
            return self
        return replace(self, rejected=finding)

    def with_remainder(self, laboratory: WhitenedRegression) -> 'Selection':
        """Return it with what is left beside the causes that are accepted now."""
        return replace(self, remainder=remainder(laboratory, self.fit, self.accepted))
