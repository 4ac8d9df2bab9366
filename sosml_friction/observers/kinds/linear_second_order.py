# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""LIN2: the linear second-order momentum observer, SOSML without its sliding terms."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.kinds.sosml import Sosml
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace


class LinearSecondOrder(Sosml):
    """
    Track the momentum by a linear second-order observer, stepped implicitly.

    With e = p_hat - p: p_hat' = tau + C^T q' - g + sigma - 2 zeta wn e, sigma' = -wn^2 e,
    tau_e = sigma, so tau_e_hat = wn^2 / (s^2 + 2 zeta wn s + wn^2) tau_e. It is SOSML with
    S1 = T1 = 0, S2 = wn^2, T2 = 2 zeta wn and runs as that. White position noise of standard
    deviation s_q gives about wn^2 |row of M| s_q for zeta = 0.5.

    Gains: ``natural_frequency`` wn [rad/s] > 0, ``damping_ratio`` zeta [1].
    """

    identifier = 'linear_second_order'
    label = 'LIN2'
    place = 4.0
    gain_units: ClassVar[Mapping[str, str]] = {'natural_frequency': 'rad/s', 'damping_ratio': '1'}
    positive_gains: ClassVar[tuple[str, ...]] = ('natural_frequency',)
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'linear_second_order': SearchSpace(
            {'natural_frequency': SearchRange(1.0, 1e5), 'damping_ratio': SearchRange(0.05, 2.0)},
            ('natural_frequency', 1.0),
        )
    }

    def _of_gains(self) -> tuple[FloatArray, ...]:
        wn, zeta = self.gains['natural_frequency'], self.gains['damping_ratio']
        zero = np.zeros(self.n)
        return zero, zero, wn**2, 2.0 * zeta * wn

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return wn = (D^2 / (4 T s_X^2))^(1/5), zeta = 1/2 and so J = zeta + 1 / (4 zeta) = 1."""
        return {'natural_frequency': conditions.second_order_frequency, 'damping_ratio': 0.5}

    @classmethod
    def bandwidth_recipe(cls, w: FloatArray, momentum_noise: FloatArray) -> Recipe | None:
        """Return wn = w and zeta = 1/2."""
        return {'natural_frequency': w, 'damping_ratio': 0.5}
