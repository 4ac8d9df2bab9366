# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""FO: the first-order momentum observer, equations (11)-(12) of the paper corrected."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.observer import FloatArray, Observer


@njit(cache=True)
def _step(
    r: FloatArray,
    p_previous: FloatArray,
    p: FloatArray,
    forcing: FloatArray,
    h: float,
    c0: FloatArray,
) -> FloatArray:
    estimate = np.empty_like(r)
    for i in range(len(r)):
        a = np.exp(-c0[i] * h)
        r[i] = a * r[i] + (1.0 - a) * ((p[i] - p_previous[i]) / h - forcing[i])
        p_previous[i] = p[i]
        estimate[i] = r[i]
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

    identifier: ClassVar[str] = 'first_order'
    gain_units: ClassVar[Mapping[str, str]] = {'cutoff': '1/s'}

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        if not np.all(self.gains['cutoff'] > 0.0):
            raise ConfigurationError('gain cutoff of observer first_order must be positive')
        self._r = np.full(self.n, np.nan)
        self._p = np.full(self.n, np.nan)

    def start(self, p: FloatArray, joints: NDArray[np.bool_]) -> None:
        """Begin afresh at momentum ``p`` with the estimate zero."""
        self._r[joints] = 0.0
        self._p[joints] = p[joints]

    def step(self, p: FloatArray, forcing: FloatArray, h: float) -> FloatArray:
        """Advance by one interval and return tau_e at its end."""
        return _step(self._r, self._p, p, forcing, h, self.gains['cutoff'])

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return r_k = a r_{k-1} + (1 - a) d_k."""
        a = float(np.exp(-self.gains['cutoff'][joint] * h))
        return np.array([1.0 - a]), np.array([1.0, -a])
