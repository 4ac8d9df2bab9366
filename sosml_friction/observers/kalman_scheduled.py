# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The Kalman observer that expects friction to jump where the velocity may have changed sign."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sosml_friction.observers.crossing import crossing_probability, mobility
from sosml_friction.observers.kalman import Kalman
from sosml_friction.observers.momentum_kalman import (
    begin,
    estimate_or_restart,
    measurement_variance,
    predict,
    update,
)
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import FloatArray


@njit(cache=True)
def _run(
    x: FloatArray,
    P: FloatArray,
    begun: NDArray[np.bool_],
    h: FloatArray,
    p: FloatArray,
    integral: FloatArray,
    forcing: FloatArray,
    inertia: FloatArray,
    mobilities: FloatArray,
    position_noise: FloatArray,
    disturbance_rate: FloatArray,
    crossing_jump: FloatArray,
) -> FloatArray:
    n = len(x)
    estimate = np.empty_like(p)
    crossing = np.empty(n)
    for k in range(len(p)):
        for i in range(n):
            if not begun[i]:
                R = measurement_variance(inertia[k, i], position_noise)
                begin(
                    x[i], P[i], x[i, 1], R, h[k], disturbance_rate[i] ** 2 + crossing_jump[i] ** 2
                )
                begun[i] = True
        for i in range(n):
            crossing[i] = crossing_probability(x, P, mobilities[k, i], forcing[k], h[k])
        for i in range(n):
            R = measurement_variance(inertia[k, i], position_noise)
            q = disturbance_rate[i] ** 2 + crossing_jump[i] ** 2 * crossing[i] / h[k]
            predict(x[i], P[i], h[k], forcing[k, i], integral[k, i], q)
            update(x[i], P[i], R)
            estimate[k, i] = estimate_or_restart(x[i], begun, i, p[k, i])
    return estimate


class KalmanScheduled(Kalman):
    """
    Raise the process noise by the chance that friction has jumped.

    A :class:`~sosml_friction.observers.kalman.Kalman` observer whose random walk has over an
    interval of length h the intensity q = disturbance_rate^2 + crossing_jump^2 pi / h, where pi is
    the chance that the joint's velocity changes its sign in it, by the filter's own estimate and
    covariance (:mod:`~sosml_friction.observers.crossing`). One passage through zero so brings the
    variance crossing_jump^2, spread over the time in which it may have happened: short in a fast
    reversal, long in a slow one, with the same gains. Between passages it may be a slow observer.

    Good for friction that depends on velocity; a torque that jumps while the joint moves (a
    contact) is followed at the slow rate of ``disturbance_rate``. With ``crossing_jump`` zero it
    is the plain Kalman observer.

    Gains: ``position_noise`` [rad] > 0 and ``disturbance_rate`` [Nm/sqrt(s)] > 0 as there;
    ``crossing_jump`` [Nm], standard deviation of the change of friction at a passage.
    """

    identifier: ClassVar[str] = 'kalman_scheduled'
    gain_units: ClassVar[Mapping[str, str]] = {
        'position_noise': 'rad',
        'disturbance_rate': 'Nm/sqrt(s)',
        'crossing_jump': 'Nm',
    }

    def run(self, samples: MomentumSamples) -> FloatArray:
        """Advance over the intervals and return tau_e at the end of each, (N, n)."""
        self._remember(samples)
        return _run(
            self._x,
            self._P,
            self._begun,
            *samples.columns,
            mobility(samples.inertia),
            *self.gains.values(),
        )
