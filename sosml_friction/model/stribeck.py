# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Stribeck friction, equation (17) of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.friction_law import FrictionLaw
from sosml_friction.model.smooth_sign import smooth_sign


class Stribeck(FrictionLaw):
    """
    tau_f = s(v) (C + S exp(-(|v| / v_s)^alpha)) + B v + bias.

    S = ``stribeck`` adds to C near standstill (breakaway C + S), v_s = ``stribeck_velocity`` > 0;
    the exponent alpha of equation (10) is 1: plateau data cannot separate it from S and v_s.
    """

    identifier: ClassVar[str] = 'stribeck'
    alpha: ClassVar[float] = 1.0
    parameter_names: ClassVar[tuple[str, ...]] = (
        'coulomb',
        'viscous',
        'stribeck',
        'stribeck_velocity',
        'bias',
    )

    def __init__(self, parameters: Mapping[str, float], smoothing_velocity: float) -> None:
        super().__init__(parameters, smoothing_velocity)
        if not self.parameters['stribeck_velocity'] > 0.0:
            raise ConfigurationError(
                f'stribeck_velocity is {self.parameters["stribeck_velocity"]}: it must be positive'
            )

    def torque(self, v: ArrayLike) -> NDArray[np.float64]:
        """Return tau_f at velocity ``v``."""
        v = np.asarray(v, dtype=float)
        p = self.parameters
        fade = np.exp(-((np.abs(v) / p['stribeck_velocity']) ** self.alpha))
        level = p['coulomb'] + p['stribeck'] * fade
        return level * smooth_sign(v, self.smoothing_velocity) + p['viscous'] * v + p['bias']
