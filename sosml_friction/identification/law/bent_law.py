# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A friction law with a power of speed beside it."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.laws import FrictionLaw


@dataclass(frozen=True)
class BentLaw:
    """
    Add ``size`` sign(v) |v / top|^power to a law: friction that bends as the law cannot.

    ``size`` [Nm or N]; ``top`` [rad/s or m/s].
    """

    law: FrictionLaw
    size: float
    power: float
    top: float

    def torque(self, v: FloatArray) -> FloatArray:
        """Return tau_f at velocity ``v`` [rad/s or m/s], same shape."""
        bend = self.size * np.sign(v) * np.abs(v / self.top) ** self.power
        return np.asarray(self.law.torque(v) + bend)
