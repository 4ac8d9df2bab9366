# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction laws of all joints at once, with a state in the place of the sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from sosml_friction.model.friction_law import FrictionLaw

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ForwardFriction:
    """
    Hold the parameters of the laws as arrays (n,), 0 where a law has none.

        tau_f = z (C + S e) + B v + bias + D_B |v| + D_S |z| e,  e = exp(-(|v| / v_s)^alpha),

    every law of :mod:`sosml_friction.model.friction_laws` with z for its smooth sign.
    """

    coulomb: FloatArray
    viscous: FloatArray
    bias: FloatArray
    stribeck: FloatArray
    stribeck_velocity: FloatArray
    alpha: FloatArray
    viscous_asymmetry: FloatArray
    stribeck_asymmetry: FloatArray

    @classmethod
    def of(cls, laws: Sequence[FrictionLaw | None]) -> ForwardFriction:
        """Return the friction of the laws; a joint without one (None) has none."""
        own = {'stribeck_velocity': 1.0, 'alpha': 1.0}
        values = {
            name: np.array(
                [
                    getattr(law, 'alpha', 1.0)
                    if name == 'alpha'
                    else (law.parameters if law else {}).get(name, own.get(name, 0.0))
                    for law in laws
                ],
                dtype=float,
            )
            for name in (field.name for field in fields(cls))
        }
        return cls(**values)

    def torque(self, v: FloatArray, z: FloatArray) -> FloatArray:
        """Return tau_f (..., n) [Nm or N] at velocities and signs (..., n)."""
        speed = np.abs(v)
        level, even = self.coulomb, self.bias
        if self.stribeck.any() or self.stribeck_asymmetry.any():
            fade = np.exp(-((speed / self.stribeck_velocity) ** self.alpha))
            level = level + self.stribeck * fade
            if self.stribeck_asymmetry.any():
                even = even + self.stribeck_asymmetry * np.abs(z) * fade
        if self.viscous_asymmetry.any():
            even = even + self.viscous_asymmetry * speed
        return np.asarray(level * z + self.viscous * v + even)

    @property
    def level(self) -> FloatArray:
        """Return the most that z is multiplied with, (n,)."""
        return np.asarray(
            np.abs(self.coulomb) + np.abs(self.stribeck) + np.abs(self.stribeck_asymmetry)
        )
