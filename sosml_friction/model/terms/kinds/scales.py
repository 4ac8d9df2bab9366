# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is characteristic of a robot and its data: what sizes of terms are measured against."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray


@dataclass(frozen=True)
class Scales:
    """
    Hold what is characteristic of a robot and its data, per joint (n,).

    ``displacement`` [rad or m] over which the sign of motion changes, and ``sign_limit``, the
    largest that still counts as a sign; ``speed`` [rad/s or m/s]: the 99 % quantile; ``span``
    [rad or m]: the range of motion; ``effort`` [Nm or N]: root mean square of the measured
    effort; ``coulomb``, ``viscous``, ``stribeck``, ``stribeck_velocity``, ``bias``: nominal
    friction, NaN where the model has none; ``width`` [rad/s or m/s]: v0 of its sign, 0 for the
    sign itself.
    """

    displacement: FloatArray
    sign_limit: FloatArray
    speed: FloatArray
    span: FloatArray
    effort: FloatArray
    coulomb: FloatArray
    viscous: FloatArray
    stribeck: FloatArray
    stribeck_velocity: FloatArray
    bias: FloatArray
    width: FloatArray

    def level(self, joint: int) -> float:
        """Return what a friction term of a joint is measured against [Nm or N]."""
        coulomb = float(self.coulomb[joint])
        return coulomb if np.isfinite(coulomb) and coulomb > 0.0 else float(self.effort[joint])
