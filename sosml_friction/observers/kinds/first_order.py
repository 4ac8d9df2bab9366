# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""FO: the first-order momentum observer, equations (11)-(12) of the paper corrected."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer, Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace

#: Where the study searches a cutoff [1/s].
CUTOFF = SearchRange(0.3, 1e4)


@compiled
def run_first_order(
    state: FloatArray,
    h: FloatArray,
    p: FloatArray,
    forcing: FloatArray,
    c0: FloatArray,
) -> FloatArray:
    """Advance r and the last p, (2, n), in place and return r after each interval, (N, n)."""
    r, p_previous = state
    estimate = np.empty_like(p)
    for k in range(len(p)):
        for i in range(len(r)):
            a = np.exp(-c0[i] * h[k])
            r[i] = a * r[i] + (1.0 - a) * ((p[k, i] - p_previous[i]) / h[k] - forcing[k, i])
            p_previous[i] = p[k, i]
            estimate[k, i] = r[i]
            if not np.isfinite(r[i]):
                estimate[k, i] = np.nan
                r[i] = 0.0
    return estimate


class FirstOrder(Observer):
    """
    Filter the momentum residual by c0 / (s + c0), discretised exactly.

    Continuous: z' = c0 (tau_e + tau + C^T q' - g), tau_e = c0 p - z (one gain: k0 = c0). With the
    forcing u constant over an interval the exact step is ::

        r_k = a r_{k-1} + (1 - a) ((p_k - p_{k-1}) / h - u_k),   a = exp(-c0 h)

    White momentum noise of standard deviation s gives (1 - a) / h sqrt(2 / (1 + a)) s, about c0 s
    while c0 h << 1. Gain: ``cutoff`` = c0 [1/s] > 0.
    """

    identifier = 'first_order'
    label = 'FO'
    place = 2.0
    gain_units: ClassVar[Mapping[str, str]] = {'cutoff': '1/s'}
    positive_gains: ClassVar[tuple[str, ...]] = ('cutoff',)
    causal = True
    study: ClassVar[Mapping[str, SearchSpace]] = {
        # The reference of the paper's comparison: a first-order observer that is kept slow.
        'first_order_capped': SearchSpace(
            {'cutoff': SearchRange(0.3, 300.0)},
            ('cutoff', 1.0),
            label='FO capped',
            remark='cutoff at most 300 1/s, as slow as in the paper',
        ),
        'first_order': SearchSpace({'cutoff': CUTOFF}, ('cutoff', 1.0)),
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._state = np.full((2, self.n), np.nan)

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return c0 = (D^2 / (4 T s_p^2))^(1/3): the least c0^2 s_p^2 + D^2 / (2 c0 T)."""
        return {'cutoff': conditions.first_order_cutoff}

    @classmethod
    def bandwidth_recipe(cls, w: FloatArray, momentum_noise: FloatArray) -> Recipe | None:
        """Return c0 = w."""
        return {'cutoff': w}

    def start(self, p: FloatArray) -> None:
        self._state[0] = 0.0
        self._state[1] = p

    def run(self, samples: MomentumSamples) -> FloatArray:
        # Array by array: a tuple costs numba a microsecond in each call.
        s = samples
        return run_first_order(self._state, s.h, s.p, s.forcing, self.gains['cutoff'])

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return r_k = a r_{k-1} + (1 - a) d_k."""
        a = float(np.exp(-self.gains['cutoff'][joint] * h))
        return np.array([1.0 - a]), np.array([1.0, -a])
