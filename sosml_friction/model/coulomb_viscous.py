# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb-viscous friction, equation (9) of the paper, with a constant offset."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sosml_friction.model.friction_law import FrictionLaw
from sosml_friction.model.smooth_sign import smooth_sign


class CoulombViscous(FrictionLaw):
    """
    tau_f = C s(v) + B v + bias.

    C = ``coulomb`` [Nm or N], B = ``viscous`` [Nm s/rad or N s/m], ``bias`` [Nm or N]: what does
    not change with direction, an offset of gravity or effort rather than friction.
    """

    identifier: ClassVar[str] = 'coulomb_viscous'
    parameter_names: ClassVar[tuple[str, ...]] = ('coulomb', 'viscous', 'bias')

    def torque(self, v: ArrayLike) -> NDArray[np.float64]:
        """Return tau_f at velocity ``v``."""
        v = np.asarray(v, dtype=float)
        p = self.parameters
        return (
            p['coulomb'] * smooth_sign(v, self.smoothing_velocity) + p['viscous'] * v + p['bias']
        )
