# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The integrated-momentum Kalman observer."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.momentum_kalman import (
    measurement_variance,
    run_filter,
    steady_lag_filter,
)
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer, Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace

#: Where the study searches the rate [Nm/sqrt(s)] and a jump [Nm]; the bandwidth goes with the cube
#: root of the rate.
RATE, JUMP = SearchRange(1e-3, 1e6), SearchRange(0.01, 100.0)
SWEEP = ('disturbance_rate', 3.0)


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

    identifier = 'kalman'
    label = 'Kalman'
    place = 7.0
    gain_units: ClassVar[Mapping[str, str]] = {
        'position_noise': 'rad',
        'disturbance_rate': 'Nm/sqrt(s)',
    }
    positive_gains: ClassVar[tuple[str, ...]] = ('position_noise', 'disturbance_rate')
    causal = True
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'kalman': SearchSpace({'disturbance_rate': RATE}, SWEEP)
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._x = np.full((self.n, 3), np.nan)
        self._P = np.full((self.n, 3, 3), np.nan)
        self._begun = np.zeros(self.n, dtype=np.bool_)
        self._inertia = np.eye(self.n)

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return D / sqrt(T): a jump D every T seconds, as a random walk."""
        return {
            'position_noise': conditions.position_noise,
            'disturbance_rate': conditions.random_walk,
        }

    @classmethod
    def _between_jumps(cls, conditions: Conditions) -> Recipe:
        """Return a tenth of that rate, for an observer that goes faster where friction jumps."""
        return {
            'position_noise': conditions.position_noise,
            'disturbance_rate': 0.1 * conditions.random_walk,
        }

    def start(self, p: FloatArray) -> None:
        self._x[:, 1] = p
        # The covariance at the start depends on the first interval.
        self._begun[:] = False

    def run(self, samples: MomentumSamples) -> FloatArray:
        # For the lag.
        if len(samples):
            self._inertia = samples.inertia[-1].copy()
        return self._filter(samples)

    def _filter(self, samples: MomentumSamples) -> FloatArray:
        gains = (*self.gains.values(), np.zeros(self.n))
        return run_filter(self._x, self._P, self._begun, samples.columns, samples.inertia, gains)

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """
        Return the filter with its steady gain, at the inertia seen last.

        Before any sample the inertia is taken for the identity.
        """
        R = measurement_variance(self._inertia[joint], self.gains['position_noise'])
        q = float(self.gains['disturbance_rate'][joint]) ** 2
        return steady_lag_filter(R, h, q)
