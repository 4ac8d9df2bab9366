# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""LIN2: the linear second-order momentum observer, SOSML without its sliding terms."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.kinds.sosml import Sosml
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer, Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace


class LinearSecondOrder(Observer):
    """
    Track the momentum by a linear second-order observer, stepped implicitly.

    With e = p_hat - p: p_hat' = tau + C^T q' - g + sigma - 2 zeta wn e, sigma' = -wn^2 e,
    tau_e = sigma, so tau_e_hat = wn^2 / (s^2 + 2 zeta wn s + wn^2) tau_e. It is SOSML with
    S1 = T1 = 0, S2 = wn^2, T2 = 2 zeta wn and runs as that: what SOSML gains over it is what the
    sliding terms are worth. White position noise of standard deviation s_q gives about
    wn^2 |row of M| s_q for zeta = 0.5.

    Gains: ``natural_frequency`` wn [rad/s] > 0, ``damping_ratio`` zeta [1].
    """

    identifier = 'linear_second_order'
    label = 'LIN2'
    place = 4.0
    gain_units: ClassVar[Mapping[str, str]] = {'natural_frequency': 'rad/s', 'damping_ratio': '1'}
    positive_gains: ClassVar[tuple[str, ...]] = ('natural_frequency',)
    causal = True
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'linear_second_order': SearchSpace(
            {'natural_frequency': SearchRange(1.0, 1e5), 'damping_ratio': SearchRange(0.05, 2.0)},
            ('natural_frequency', 1.0),
        )
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        wn, zeta = self.gains['natural_frequency'], self.gains['damping_ratio']
        zero = np.zeros(self.n).tolist()
        self._sosml = Sosml(
            {
                'sliding': zero,
                'sliding_root': zero,
                'linear': (wn**2).tolist(),
                'linear_damping': (2.0 * zeta * wn).tolist(),
            }
        )

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """
        Return wn = (D^2 / (4 T s_X^2))^(1/5) and zeta = 1/2.

        The noise is wn^2 s_X, and J = zeta + 1 / (4 zeta) = 1 at zeta = 1/2: the integral of the
        square of the error of a unit step, in units of 1/wn.
        """
        return {'natural_frequency': conditions.second_order_frequency, 'damping_ratio': 0.5}

    @classmethod
    def bandwidth_recipe(cls, w: FloatArray, momentum_noise: FloatArray) -> Recipe | None:
        """Return wn = w and zeta = 1/2."""
        return {'natural_frequency': w, 'damping_ratio': 0.5}

    def start(self, p: FloatArray) -> None:
        """Begin afresh at momentum ``p`` with the estimate zero."""
        self._sosml.start(p)

    def run(self, samples: MomentumSamples) -> FloatArray:
        """Advance over the intervals and return tau_e at the end of each, (N, n)."""
        return self._sosml.run(samples)

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return the filter of the implicit step, as Sosml does for its linear part."""
        return self._sosml.lag_filter(h, joint)
