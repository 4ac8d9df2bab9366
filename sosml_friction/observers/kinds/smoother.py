# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The fixed-interval smoother of the integrated-momentum model: offline, without lag."""

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.kinds.kalman import RATE, SWEEP, Kalman
from sosml_friction.observers.momentum_kalman import (
    begin,
    is_finite,
    measurement_variance,
    predict,
    update,
)
from sosml_friction.observers.momentum_samples import Columns, MomentumSamples
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace

#: How near standstill friction may jump: some widths of the smooth sign [rad/s or m/s].
_CROSSING_VELOCITY = 0.02


@compiled
def _smooth(
    x: FloatArray,
    P: FloatArray,
    begun: BoolArray,
    samples: Columns,
    position_noise: FloatArray,
    q: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Filter forwards, the states in place, and go back: momentum and tau_e, each (N, n)."""
    h, p, integral, forcing, inertia = samples
    count, n = p.shape
    momentum = np.empty_like(p)
    disturbance = np.empty_like(p)
    # What the way back needs of an interval: gain, innovation over its variance, and the rows of
    # the covariance that belong to p and tau_e.
    gain = np.empty((count, 3))
    scaled = np.empty(count)
    rows = np.empty((count, 2, 3))
    for i in range(n):
        for k in range(count):
            R = measurement_variance(inertia[k, i], position_noise)
            if not begun[i]:
                begin(x[i], P[i], x[i, 1], R, h[k], q[k, i])
                begun[i] = True
            predict(x[i], P[i], h[k], forcing[k, i], integral[k, i], q[k, i])
            gain[k] = P[i, :, 0] / (P[i, 0, 0] + R)
            innovation, variance = update(x[i], P[i], R)
            scaled[k] = innovation / variance
            rows[k] = P[i, 1:]
            momentum[k, i] = x[i, 1]
            disturbance[k, i] = x[i, 2]
            if not is_finite(x[i]):
                momentum[k, i] = np.nan
                disturbance[k, i] = np.nan
                begun[i] = False
                x[i, 1] = p[k, i]
        a, b, c = 0.0, 0.0, 0.0
        for k in range(count - 1, -1, -1):
            momentum[k, i] -= rows[k, 0, 0] * a + rows[k, 0, 1] * b + rows[k, 0, 2] * c
            disturbance[k, i] -= rows[k, 1, 0] * a + rows[k, 1, 1] * b + rows[k, 1, 2] * c
            if not (np.isfinite(momentum[k, i]) and np.isfinite(disturbance[k, i])):
                # Nothing is known across this interval: the piece before it ends here.
                momentum[k, i] = np.nan
                disturbance[k, i] = np.nan
                a, b, c = 0.0, 0.0, 0.0
                continue
            a -= gain[k, 0] * a + gain[k, 1] * b + gain[k, 2] * c + scaled[k]
            c += h[k] * b + 0.5 * h[k] * h[k] * a
            b += h[k] * a
    return momentum, disturbance


class Smoother(Kalman):
    """
    Estimate tau_e at each sample from the whole recording, by the model of the Kalman observer.

    The most probable tau_e of :class:`Kalman` given what came before and after: the
    Rauch-Tung-Striebel smoother, computed in the form of Bryson and Frazier, which carries the
    adjoint backwards and inverts no covariance. It has no lag. A joint without forcing over an
    interval is smoothed in pieces, before and after it.

    Friction can jump only near velocity zero, so q may be raised there ::

        q = rate^2 + crossing_rate^2 exp(-(v / crossing_velocity)^2)

    with v = M^-1 p from a first pass that allows a crossing everywhere: at the low q the momentum
    itself would be smoothed across a jump. A joint without effort has a velocity there all the
    same, so that the joints coupled to it keep their schedule.

    Gains: ``position_noise`` [rad] > 0, standard deviation of an encoder reading, quantisation
    included; ``disturbance_rate`` [Nm/sqrt(s)] > 0; ``crossing_rate`` [Nm/sqrt(s)], 0 for one pass
    at constant q; ``crossing_velocity`` [rad/s] > 0.
    """

    identifier = 'smoother'
    label = 'Smoother'
    place = 12.0
    coupled = True
    gain_units: ClassVar[Mapping[str, str]] = {
        **Kalman.gain_units,
        'crossing_rate': 'Nm/sqrt(s)',
        'crossing_velocity': 'rad/s',
    }
    positive_gains: ClassVar[tuple[str, ...]] = (*Kalman.positive_gains, 'crossing_velocity')
    causal = False
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'smoother': SearchSpace(
            {
                'disturbance_rate': RATE,
                'crossing_rate': SearchRange(1.0, 1e4, 'disturbance_rate', 1.0),
                'crossing_velocity': SearchRange(1e-3, 1.0),
            },
            SWEEP,
        )
    }

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """
        Return a tenth of the random walk, and at a standstill rate^2 = D^2 sqrt(pi) V / (T v_c).

        A sinusoid of top speed V passes it with the acceleration pi V / T. Without a top speed it
        is the Kalman observer's model, smoothed.
        """
        c, crossing_velocity = conditions, {'crossing_velocity': _CROSSING_VELOCITY}
        if c.top_speed is None:
            return {**super().recipe(c), 'crossing_rate': 0.0, **crossing_velocity}
        passages = np.sqrt(np.pi) * c.top_speed / (c.reversal_time * _CROSSING_VELOCITY)
        crossing = c.friction_jump * np.sqrt(passages)
        return {**cls._between_jumps(c), 'crossing_rate': crossing, **crossing_velocity}

    def run(self, samples: MomentumSamples) -> FloatArray:
        """Smooth over the intervals, given all before, and return tau_e at their ends, (N, n)."""
        s, noise = samples, self.gains['position_noise']
        q = np.broadcast_to(self.gains['disturbance_rate'] ** 2, s.p.shape)
        extra = self.gains['crossing_rate'] ** 2
        if extra.any():
            state = self._x.copy(), self._P.copy(), self._begun.copy()
            # At this q positions alone tell the momentum: a missing effort may as well be zero.
            known = replace(s, forcing=np.where(np.isfinite(s.forcing), s.forcing, 0.0))
            momentum, _ = _smooth(*state, known.columns, noise, q + extra)
            v = np.linalg.solve(s.inertia, momentum[..., None])[..., 0]
            # Beyond 30 the exponential is zero; an unknown velocity may be a crossing.
            ratio = np.minimum(np.abs(v) / self.gains['crossing_velocity'], 30.0)
            q = q + extra * np.exp(-(np.nan_to_num(ratio, nan=0.0) ** 2))
        return _smooth(self._x, self._P, self._begun, s.columns, noise, q)[1]

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return 1: a smoother has no lag."""
        return np.ones(1), np.ones(1)
