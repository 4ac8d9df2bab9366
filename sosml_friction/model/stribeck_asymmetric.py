# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Stribeck friction that differs with direction."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.stribeck import Stribeck


class StribeckAsymmetric(Stribeck):
    """
    tau_f = s(v) (C + S e) + B v + bias + D_B |v| + D_S |s(v)| e, e = exp(-(|v| / v_s)^alpha).

    D_B = ``viscous_asymmetry`` and D_S = ``stribeck_asymmetry``: forwards B + D_B and S + D_S,
    backwards B - D_B and S - D_S. Coulomb friction is C + bias and C - bias: a difference by
    direction and an offset are the same torque at every speed. v_s is one for both.
    """

    identifier: ClassVar[str] = 'stribeck_asymmetric'
    parameter_names: ClassVar[tuple[str, ...]] = (
        *Stribeck.parameter_names,
        'viscous_asymmetry',
        'stribeck_asymmetry',
    )

    def torque(self, v: ArrayLike) -> NDArray[np.float64]:
        """Return tau_f at velocity ``v``."""
        v = np.asarray(v, dtype=float)
        p = self.parameters
        fade = np.exp(-((np.abs(v) / p['stribeck_velocity']) ** self.alpha))
        size = np.abs(smooth_sign(v, self.smoothing_velocity))
        even = p['viscous_asymmetry'] * np.abs(v) + p['stribeck_asymmetry'] * size * fade
        return np.array(super().torque(v) + even)
