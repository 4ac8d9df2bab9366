# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The Kalman observer that expects friction to jump where the velocity may have changed sign."""

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.kinds.kalman import JUMP, RATE, SWEEP, Kalman
from sosml_friction.observers.momentum_kalman import run_filter
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchSpace


class KalmanScheduled(Kalman):
    """
    Raise the process noise by the chance that friction has jumped.

    A :class:`Kalman` observer whose random walk has over an interval of length h the intensity q =
    disturbance_rate^2 + crossing_jump^2 pi / h, where pi is the chance that the joint's velocity
    changes its sign in it, by the filter's own estimate and covariance
    (:mod:`~sosml_friction.observers.crossing`). One passage through zero so brings the variance
    crossing_jump^2, spread over the time in which it may have happened: short in a fast reversal,
    long in a slow one, with the same gains. Between passages it may be a slow observer.

    A torque that jumps while the joint moves (a contact) is followed at the slow rate of
    ``disturbance_rate``. With ``crossing_jump`` zero it is the plain Kalman observer.

    Gains: ``position_noise`` [rad] > 0 and ``disturbance_rate`` [Nm/sqrt(s)] > 0 as there;
    ``crossing_jump`` [Nm], standard deviation of the change of friction at a passage.
    """

    identifier = 'kalman_scheduled'
    label = 'Kalman scheduled'
    place = 9.0
    coupled = True
    gain_units: ClassVar[Mapping[str, str]] = {**Kalman.gain_units, 'crossing_jump': 'Nm'}
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'kalman_scheduled': SearchSpace({'disturbance_rate': RATE, 'crossing_jump': JUMP}, SWEEP)
    }

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return a tenth of the random walk between reversals and a jump of 0.3 D at one."""
        return {**cls._between_jumps(conditions), 'crossing_jump': 0.3 * conditions.friction_jump}

    def _filter(self, samples: MomentumSamples) -> FloatArray:
        state, gains = (self._x, self._P, self._begun), tuple(self.gains.values())
        return run_filter(*state, samples.columns, samples.mobility, gains)
