# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The Kalman observer that adapts its process noise until its innovations are white."""

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.kinds.kalman import RATE, SWEEP, Kalman
from sosml_friction.observers.momentum_kalman import (
    begin,
    estimate_or_restart,
    measurement_variance,
    predict,
    steady_lag_filter,
    update,
)
from sosml_friction.observers.momentum_samples import Columns, MomentumSamples
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace

#: What is left after an interval of the running means of the innovations: about 20 of them count.
_MEMORY = 0.95
#: q h^5 / R of a filter that takes measurements as they are: more would change nothing.
_DEADBEAT = 100.0


@compiled
def _correlation(innovation: float, means: FloatArray) -> float:
    """
    Return how an innovation goes with those before it, and take it into the running means.

    For white innovations of any size it has mean zero and standard deviation about one; with
    m = _MEMORY it is never larger than sqrt((1 + m) / m) / (2 (1 - m)).

    :param innovation: in any unit [Nm s2].
    :param means: running means of the innovations and of their squares, (2,), in that unit.
    """
    past = means[0]
    means[0] = _MEMORY * means[0] + (1.0 - _MEMORY) * innovation
    means[1] = _MEMORY * means[1] + (1.0 - _MEMORY) * innovation * innovation
    if not means[1] > 0.0:
        return 0.0
    return innovation * past / means[1] * math.sqrt((1.0 + _MEMORY) / (1.0 - _MEMORY))


@compiled
def _run(
    x: FloatArray,
    P: FloatArray,
    q: FloatArray,
    means: FloatArray,
    begun: BoolArray,
    samples: Columns,
    gains: tuple[FloatArray, ...],
) -> FloatArray:
    h, p, integral, forcing, inertia = samples
    position_noise, disturbance_rate, adaptation_rate = gains
    estimate = np.empty_like(p)
    for k in range(len(p)):
        for i in range(len(x)):
            R = measurement_variance(inertia[k, i], position_noise)
            least = disturbance_rate[i] * disturbance_rate[i]
            if not begun[i]:
                q[i] = least
                means[i] = 0.0
                begin(x[i], P[i], x[i, 1], R, h[k], least)
                begun[i] = True
            predict(x[i], P[i], h[k], forcing[k, i], integral[k, i], q[i])
            innovation, _ = update(x[i], P[i], R)
            estimate[k, i] = estimate_or_restart(x[i], begun, i, p[k, i])
            if begun[i]:
                growth = adaptation_rate[i] * h[k] * _correlation(innovation, means[i])
                # A coarse sampling must not overflow the exponential: e-fold at a time.
                raised = q[i] * math.exp(min(growth, 1.0))
                q[i] = max(least, min(raised, _DEADBEAT * R / h[k] ** 5))
    return estimate


class KalmanAdaptive(Kalman):
    """
    Adapt the process noise until the innovations are white.

    In a :class:`Kalman` observer of the right gain an innovation tells nothing of the next. If
    they go together the filter lags and its intensity q is too small, if they alternate it follows
    noise and q is too large. With the running mean m of the innovations e before, and c = e m /
    mean(e^2), scaled to variance one for white ones ::

        d(ln q) / dt = adaptation_rate c,   q >= disturbance_rate^2

    Whiteness depends on the gain alone, so neither the size of the motion nor the true noise need
    be known: ``position_noise`` may be wrong by far. A jump of friction is seen when it has
    happened. With ``adaptation_rate`` zero it is the plain Kalman observer.

    Gains: ``position_noise`` [rad] > 0; ``disturbance_rate`` [Nm/sqrt(s)] > 0, the least sqrt(q);
    ``adaptation_rate`` [1/s].
    """

    identifier = 'kalman_adaptive'
    label = 'Kalman adaptive'
    place = 8.0
    gain_units: ClassVar[Mapping[str, str]] = {**Kalman.gain_units, 'adaptation_rate': '1/s'}
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'kalman_adaptive': SearchSpace(
            {'disturbance_rate': RATE, 'adaptation_rate': SearchRange(0.01, 100.0)}, SWEEP
        )
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._q = self.gains['disturbance_rate'] ** 2
        self._means = np.zeros((self.n, 2))

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return never less than a tenth of the random walk, e-fold in a fifth of a second."""
        return {**cls._between_jumps(conditions), 'adaptation_rate': 5.0}

    def start(self, p: FloatArray) -> None:
        """Begin afresh at momentum ``p`` with the estimate zero and the least process noise."""
        super().start(p)
        self._q[:] = self.gains['disturbance_rate'] ** 2

    def _filter(self, samples: MomentumSamples) -> FloatArray:
        state = self._x, self._P, self._q, self._means, self._begun
        return _run(*state, samples.columns, tuple(self.gains.values()))

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return the filter with the steady gain of the inertia and process noise seen last."""
        R = measurement_variance(self._inertia[joint], self.gains['position_noise'])
        return steady_lag_filter(R, h, float(self._q[joint]))

    def disturbance_rate(self) -> FloatArray:
        """Return the sqrt(q) in use, (n,) [Nm/sqrt(s) or N/sqrt(s)]."""
        return np.sqrt(self._q)
