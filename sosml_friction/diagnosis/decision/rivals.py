# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which candidates of one round of the search explain the same."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.regression.chance import NEGLIGIBLE
from sosml_friction.regression.evidence import Fit, System
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.whitened import WhitenedRegression

#: A rival explains what the best explains: beside the best, less than this share of the rival's
#: gain is left. Halved and doubled, no answer of ``python -m validation.sensitivity --seed 1``
#: changes.
_OVERLAP = 0.5
#: An alias has at least this share of its twin's evidence. Of 0.5, a bias would be a rival of an
#: asymmetry of 30 % of viscous friction (``test/cli/test_diagnose.py -k hidden_asymmetry``).
_ALIAS = 0.8
#: A joint stands still below this share of its top speed. Halved and doubled, no answer of
#: ``python -m validation.sensitivity --seed 1`` changes.
_AT_REST = 2e-3
#: A cause is a constant if each form of its grid, those without speed too, explains this share of
#: what the best form explains. Halved and doubled, no answer of ``python -m validation.sensitivity
#: --seed 1`` changes.
_CONSTANT = 0.9
#: A rival's evidence is within VERY_STRONG of the best, or within this share of the residual
#: energy beyond noise that the best leaves: what neither explains could have decided between them.
#: Halved and doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes.
_RIVAL = 0.05


def same_term(one: Finding, other: Finding) -> bool:
    """Tell whether two candidates are one term in one joint."""
    return (one.effect.identifier, one.joint) == (other.effect.identifier, other.joint)


class Rivals:
    """
    Compare the candidates of one round.

    :param system: of the causes accepted before.
    :param top: the best candidates, refined, best first.
    :param found: all candidates, best first.
    """

    def __init__(
        self,
        laboratory: WhitenedRegression,
        system: System,
        top: Sequence[Finding],
        found: Sequence[Finding],
    ) -> None:
        self.top = top
        self._laboratory = laboratory
        self._system = system
        self._found = found

    def with_rivals(self, best: Finding) -> Finding:
        """
        Return a candidate with those that explain as much, and the aliases of each.

        As much: in evidence, or where nominal parameters within their tolerance cost nothing, or
        but for what neither explains.
        """
        beside = Fit.make(self._system.extended([best.columns]), self._laboratory.y)
        excess = max(beside.baseline.cost - float(self._laboratory.noise_energy.sum()), 0.0)
        free = self._free_evidence()
        most = free(best)

        def as_much(other: Finding) -> bool:
            behind = best.delta_bic - other.delta_bic
            if min(behind, most - free(other)) < VERY_STRONG:
                return True
            if behind >= _RIVAL * excess:
                return False
            return bool(beside.score(other.columns).gain < _OVERLAP * other.score.gain)

        # A candidate that reduces to the best is no rival of it; of any other one it is.
        rivals = [
            other
            for other in self.top
            if not same_term(other, best)
            and (other.reduced not in ('', best.effect.identifier) or not other.objection)
            and as_much(other)
        ]
        rivals.sort(key=lambda other: bool(other.objection))
        unique = {best.key: best}
        for finding in (best, *rivals):
            for other in (finding, *self._aliases(finding)):
                unique.setdefault(other.key, other)
        del unique[best.key]
        return replace(best, rivals=tuple(unique.values()))

    def _aliases(self, finding: Finding) -> list[Finding]:
        """
        Return the aliases of a candidate that explain most of what it does.

        Where the joint never stands still, those of a constant in any case: only reversals tell
        them apart then, and how friction turns around there is not known.
        """
        # Where a dependence on speed is seen too, a constant alone is no alias.
        constant = finding.score.gains.min() > _CONSTANT * finding.score.gains.max()
        least = max(_ALIAS * finding.delta_bic, VERY_STRONG)
        if constant and not self._stands_still(finding.joint):
            least = -np.inf
        return [
            other
            for other in self._found
            if other.joint == finding.joint
            and other.effect.identifier in finding.effect.aliases
            and not other.objection
            and other.delta_bic > least
        ]

    def _free_evidence(self) -> Callable[[Finding], float]:
        """
        Return the evidence of candidates where deviations of the nominal cost nothing.

        Within its bounds a nominal parameter is as likely here as there: that a candidate needs
        more of them to be off speaks against it only as far as it needs more than the tolerance.
        """
        prior = np.full(self._system.prior.shape, np.inf)
        fit = Fit.make(replace(self._system, prior=prior), self._laboratory.y)

        def evidence(finding: Finding) -> float:
            return finding.delta_bic - finding.score.gain + fit.score(finding.columns).gain

        return evidence

    def _stands_still(self, joint: int) -> bool:
        """Tell whether a joint stands for some of the time, so that its friction is known."""
        slow = [
            np.abs(signals.v[:, joint]) < _AT_REST * signals.scales.speed[joint]
            for signals in self._laboratory.signals
            if not any(rest.joint == joint for rest in signals.rests)
        ]
        return bool(slow) and bool(np.concatenate(slow).mean() > NEGLIGIBLE)
