# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort less gravity, low-passed: what friction is while nothing accelerates. A baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numba import njit

from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import FloatArray, Observer


@njit(cache=True)
def _run(r: FloatArray, h: FloatArray, forcing: FloatArray, cutoff: FloatArray) -> FloatArray:
    estimate = np.empty_like(forcing)
    for k in range(len(forcing)):
        for i in range(len(r)):
            a = np.exp(-cutoff[i] * h[k])
            r[i] = a * r[i] - (1.0 - a) * forcing[k, i]
            estimate[k, i] = r[i]
            if not np.isfinite(r[i]):
                estimate[k, i] = np.nan
                r[i] = 0.0
    return estimate


class QuasiStatic(Observer):
    """
    Take the forcing for friction and filter it by w / (s + w), discretised exactly.

    With u = tau + C^T q' - g it is tau_e = -u as long as p' = 0: no velocity is differentiated, so
    there is next to no noise, and whatever the joint accelerates, M q'', is taken for friction.
    The baseline that every observer has to beat on slow motion; of no use in fast.

    The filter is there for noise of the effort. Gain: ``cutoff`` = w [1/s] > 0.
    """

    identifier: ClassVar[str] = 'quasi_static'
    gain_units: ClassVar[Mapping[str, str]] = {'cutoff': '1/s'}
    positive_gains: ClassVar[tuple[str, ...]] = ('cutoff',)

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._r = np.full(self.n, np.nan)

    def start(self, p: FloatArray) -> None:
        """Begin afresh with the estimate zero; the momentum is not used."""
        self._r[:] = 0.0

    def run(self, samples: MomentumSamples) -> FloatArray:
        """Advance over the intervals and return tau_e at the end of each, (N, n)."""
        return _run(self._r, samples.h, samples.forcing, self.gains['cutoff'])

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return r_k = a r_{k-1} + (1 - a) d_k: true while the joint does not accelerate."""
        a = float(np.exp(-self.gains['cutoff'][joint] * h))
        return np.array([1.0 - a]), np.array([1.0, -a])
