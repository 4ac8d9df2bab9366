# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The integrated-momentum Kalman observer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sosml_friction.observers.momentum_kalman import (
    begin,
    estimate_or_restart,
    measurement_variance,
    predict,
    steady_lag_filter,
    update,
)
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import FloatArray, Observer


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
    position_noise: FloatArray,
    disturbance_rate: FloatArray,
) -> FloatArray:
    estimate = np.empty_like(p)
    for k in range(len(p)):
        for i in range(len(x)):
            R = measurement_variance(inertia[k, i], position_noise)
            q = disturbance_rate[i] * disturbance_rate[i]
            if not begun[i]:
                begin(x[i], P[i], x[i, 1], R, h[k], q)
                begun[i] = True
            predict(x[i], P[i], h[k], forcing[k, i], integral[k, i], q)
            update(x[i], P[i], R)
            estimate[k, i] = estimate_or_restart(x[i], begun, i, p[k, i])
    return estimate


class Kalman(Observer):
    """
    Estimate tau_e, a random walk, from the integral of the momentum by a Kalman filter.

    The model is that of :mod:`~sosml_friction.observers.momentum_kalman`. Where the first- and
    second-order observers take the differentiated position for the momentum, this one takes its
    sum, in which encoder noise is white: it needs to be told the noise, and has then one gain to
    choose. Its steady bandwidth is (q / (R h))^(1/6) with R the squared row of M times
    ``position_noise``; inertia that changes with posture is followed.

    Gains: ``position_noise`` [rad] > 0, standard deviation of an encoder reading, quantisation
    included (step / sqrt(12)); ``disturbance_rate`` sqrt(q) [Nm/sqrt(s)] > 0, the change of the
    disturbance in one second.
    """

    identifier: ClassVar[str] = 'kalman'
    gain_units: ClassVar[Mapping[str, str]] = {
        'position_noise': 'rad',
        'disturbance_rate': 'Nm/sqrt(s)',
    }
    positive_gains: ClassVar[tuple[str, ...]] = ('position_noise', 'disturbance_rate')

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._x = np.full((self.n, 3), np.nan)
        self._P = np.full((self.n, 3, 3), np.nan)
        self._begun = np.zeros(self.n, dtype=np.bool_)
        self._inertia = np.eye(self.n)

    def start(self, p: FloatArray) -> None:
        """Begin afresh at momentum ``p`` with the estimate zero."""
        self._x[:, 1] = p
        # The covariance at the start depends on the first interval.
        self._begun[:] = False

    def run(self, samples: MomentumSamples) -> FloatArray:
        """Advance over the intervals and return tau_e at the end of each, (N, n)."""
        self._remember(samples)
        return _run(self._x, self._P, self._begun, *samples.columns, *self.gains.values())

    def _remember(self, samples: MomentumSamples) -> None:
        """Keep the last inertia, for :meth:`lag_filter`."""
        if len(samples):
            self._inertia = samples.inertia[-1].copy()

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """
        Return the filter with its steady gain, at the inertia seen last.

        Before any sample the inertia is taken for the identity.
        """
        R = measurement_variance(self._inertia[joint], self.gains['position_noise'])
        q = float(self.gains['disturbance_rate'][joint]) ** 2
        return steady_lag_filter(R, h, q)
