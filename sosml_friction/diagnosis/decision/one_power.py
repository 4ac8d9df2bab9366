# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One power of speed in the place of the causes by speed of a joint."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.regression.curves.speed_power import SpeedPower
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.whitened import WhitenedRegression

#: By how much more one power of speed has to explain, beside ``VERY_STRONG``, as a share of what
#: is named: by so much an effect of the catalogue in other equations may differ.
_MORE_SHARE = 0.005


@dataclass(frozen=True)
class OnePower:
    """
    Compare one power of speed, s |q'|^p, with the causes by speed of a joint.

    ``causes``: those that one power could stand for; ``named`` and ``gain``: what they, and it,
    explain beside all others; ``price``: of the parameters that it has less, k - 2 of k.
    """

    joint: int
    causes: tuple[Finding, ...]
    named: float
    gain: float
    price: float

    @classmethod
    def of(
        cls, laboratory: WhitenedRegression, accepted: Sequence[Finding], joint: int
    ) -> 'OnePower | None':
        """Return the comparison of a joint, None if it has no such cause."""
        causes = [f for f in accepted if f.joint == joint and f.effect.one_power]
        if not causes:
            return None
        # By place and not by equality: arrays have no one truth value.
        others = [f.columns for f in accepted if all(f is not own for own in causes)]
        fit = Fit.make(laboratory.system.extended(others), laboratory.y)
        whole = Fit.make(fit.system.extended([f.columns for f in causes]), laboratory.y)
        power = SpeedPower()
        grid = power.grid(laboratory.signals[0], joint)
        return cls(
            joint,
            tuple(causes),
            fit.baseline.cost - whole.baseline.cost,
            max(fit.score(laboratory.single(power, joint, inner)).gain for inner in grid),
            (sum(1 + len(f.effect.refined) for f in causes) - 2)
            * float(np.log(len(laboratory.y))),
        )

    @property
    def _even(self) -> float:
        """Return what it has to explain to be as likely as they are, by its BIC."""
        return self.named - self.price

    @property
    def floor(self) -> float:
        """
        Return what it has to explain to be true in their place.

        In that of one cause, or of a friction that is off, Coulomb and viscous, it has to be the
        surer one; in that of three causes or more it need only be no worse than a rival.
        """
        if len(self.causes) > 2:
            return self._even - VERY_STRONG
        share = _MORE_SHARE * self.named if len(self.causes) == 1 else 0.0
        return self._even + max(VERY_STRONG, share)

    def is_rival(self, finding: Finding) -> bool:
        """Tell whether it is as likely as a lone cause whose curve over speed was searched."""
        alone = [cause.key for cause in self.causes] == [finding.key]
        searched = bool(finding.effect.refined)
        return alone and searched and self.gain >= self._even - VERY_STRONG
