# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One power of speed in the place of the causes by speed of a joint."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.regression.curves.speed_power import SpeedPower
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.whitened import WhitenedRegression


@dataclass(frozen=True)
class OnePower:
    """
    Compare one power of speed, s |q'|^p, with the causes by speed of a joint.

    ``causes``: those that one power could stand for; ``named`` and ``gain``: what they, and it,
    explain beside all others; ``price``: of the parameters that it has less, k - 2 of k.
    """

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
            tuple(causes),
            fit.baseline.cost - whole.baseline.cost,
            max(fit.score(laboratory.single(power, joint, inner)).gain for inner in grid),
            (sum(1 + len(f.effect.refined) for f in causes) - 2)
            * float(np.log(len(laboratory.y))),
        )

    @property
    def floor(self) -> float:
        """Return what one power has to explain to be as likely, by its BIC."""
        return self.named - self.price
