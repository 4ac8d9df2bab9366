# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb-viscous friction that differs with direction."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sosml_friction.model.coulomb_viscous import CoulombViscous


class CoulombViscousAsymmetric(CoulombViscous):
    """
    tau_f = C s(v) + B v + bias + D |v|.

    D = ``viscous_asymmetry`` [Nm s/rad or N s/m]: viscous friction is B + D forwards and B - D
    backwards. Coulomb friction is C + bias and C - bias: a difference by direction and an offset
    are the same torque at every speed.
    """

    identifier: ClassVar[str] = 'coulomb_viscous_asymmetric'
    parameter_names: ClassVar[tuple[str, ...]] = (
        *CoulombViscous.parameter_names,
        'viscous_asymmetry',
    )

    def torque(self, v: ArrayLike) -> NDArray[np.float64]:
        """Return tau_f at velocity ``v``."""
        v = np.asarray(v, dtype=float)
        return np.array(super().torque(v) + self.parameters['viscous_asymmetry'] * np.abs(v))
