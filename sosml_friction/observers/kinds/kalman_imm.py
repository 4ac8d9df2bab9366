# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The Kalman observer with two interacting hypotheses: friction has jumped lately, or not."""

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.crossing import crossing_probability
from sosml_friction.observers.kinds.kalman import JUMP, RATE, SWEEP, Kalman
from sosml_friction.observers.momentum_kalman import (
    begin,
    estimate_or_restart,
    measurement_variance,
    predict,
    update,
)
from sosml_friction.observers.momentum_samples import Columns, MomentumSamples
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace

#: Keeps a weight from underflow: it says nothing, but its hypothesis can come back.
_LEAST_WEIGHT = 1e-100


@compiled
def _merge(
    mean: FloatArray,
    covariance: FloatArray,
    x: FloatArray,
    P: FloatArray,
    first: float,
    second: float,
) -> None:
    """
    Write mean and covariance of a mixture of two normal distributions of three states.

    :param mean: written, (3,).
    :param covariance: written, (3, 3).
    :param x: means, (2, 3).
    :param P: covariances, (2, 3, 3).
    :param first: weight of the first, with ``second`` adding up to one.
    """
    for a in range(3):
        mean[a] = first * x[0, a] + second * x[1, a]
    for a in range(3):
        for b in range(a, 3):
            spread = first * second * (x[0, a] - x[1, a]) * (x[0, b] - x[1, b])
            covariance[a, b] = first * P[0, a, b] + second * P[1, a, b] + spread
            covariance[b, a] = covariance[a, b]


@compiled
def _mix(
    x: FloatArray, P: FloatArray, weight: FloatArray, crossing: float, memory: float, jump: float
) -> None:
    """
    Take the transitions of an interval, in place: Blom and Bar-Shalom's mixing.

    :param x: means of the hypotheses none, jumped, (2, 3).
    :param P: covariances, (2, 3, 3).
    :param weight: their probabilities, (2,).
    :param crossing: chance of a jump.
    :param memory: chance that a jump is still called recent.
    :param jump: variance that a jump brings to tau_e [Nm^2].
    """
    recent = weight[1] * memory
    past = weight[0] + weight[1] * (1.0 - memory)
    still = recent * (1.0 - crossing)
    none = max(past * (1.0 - crossing), _LEAST_WEIGHT)
    jumped = max(crossing + still, _LEAST_WEIGHT)
    # From each hypothesis to each: a jump comes from either of them.
    none_to_none = min(weight[0] * (1.0 - crossing) / none, 1.0)
    none_to_jumped = min(weight[0] * crossing / jumped, 1.0)
    old_x, old_P = x.copy(), P.copy()
    _merge(x[0], P[0], old_x, old_P, none_to_none, 1.0 - none_to_none)
    _merge(x[1], P[1], old_x, old_P, none_to_jumped, 1.0 - none_to_jumped)
    P[1, 2, 2] += jump * min(crossing / jumped, 1.0)
    weight[0] = none / (none + jumped)
    weight[1] = jumped / (none + jumped)


@compiled
def _weigh(weight: FloatArray, innovation: FloatArray, S: FloatArray) -> None:
    """
    Multiply the weights by the likelihoods of the innovations, in place.

    :param weight: probabilities of none and jumped, (2,).
    :param innovation: of the two filters, (2,) [Nm s2].
    :param S: their variances, (2,).
    """
    none, jumped = innovation[0] * innovation[0] / S[0], innovation[1] * innovation[1] / S[1]
    # The logarithm of the likelihood ratio, in no unit; the likelier keeps its weight.
    advantage = 0.5 * (jumped - none + math.log(S[1] / S[0]))
    first = weight[0] * math.exp(min(advantage, 0.0)) + _LEAST_WEIGHT
    second = weight[1] * math.exp(min(-advantage, 0.0)) + _LEAST_WEIGHT
    weight[0] = first / (first + second)
    weight[1] = second / (first + second)


@compiled
def _run(
    x: FloatArray,
    P: FloatArray,
    modes: FloatArray,
    covariances: FloatArray,
    weight: FloatArray,
    begun: BoolArray,
    samples: Columns,
    mobilities: FloatArray,
    gains: tuple[FloatArray, ...],
) -> FloatArray:
    h, p, integral, forcing, inertia = samples
    position_noise, disturbance_rate, crossing_jump, jump_memory = gains
    n = len(x)
    estimate = np.empty_like(p)
    crossing, innovation, S = np.empty(n), np.empty(2), np.empty(2)
    for k in range(len(p)):
        for i in range(n):
            if not begun[i]:
                R = measurement_variance(inertia[k, i], position_noise)
                begin(
                    x[i], P[i], x[i, 1], R, h[k], disturbance_rate[i] ** 2 + crossing_jump[i] ** 2
                )
                modes[i, :] = x[i]
                covariances[i, :] = P[i]
                weight[i, 0], weight[i, 1] = 0.0, 1.0
                begun[i] = True
        for i in range(n):
            crossing[i] = crossing_probability(x, P, mobilities[k, i], forcing[k], h[k])
        for i in range(n):
            R = measurement_variance(inertia[k, i], position_noise)
            memory = math.exp(-h[k] / jump_memory[i])
            _mix(modes[i], covariances[i], weight[i], crossing[i], memory, crossing_jump[i] ** 2)
            for m in range(2):
                q = disturbance_rate[i] ** 2
                predict(modes[i, m], covariances[i, m], h[k], forcing[k, i], integral[k, i], q)
                innovation[m], S[m] = update(modes[i, m], covariances[i, m], R)
            _weigh(weight[i], innovation, S)
            _merge(x[i], P[i], modes[i], covariances[i], weight[i, 0], weight[i, 1])
            estimate[k, i] = estimate_or_restart(x[i], begun, i, p[k, i])
    return estimate


class KalmanImm(Kalman):
    """
    Weigh two Kalman observers: one believes in a recent jump of friction, the other does not.

    Interacting multiple models (Blom and Bar-Shalom, IEEE Trans. Automatic Control 33, 1988), for
    each joint two filters of the :class:`Kalman` model. In an interval friction jumps with the
    chance pi that the joint's velocity changes its sign
    (:mod:`~sosml_friction.observers.crossing`, at the merged estimate); a jump moves the weight to
    the second filter and adds crossing_jump^2 to its variance of tau_e; its weight goes back to
    the first with the time constant ``jump_memory``. Then each filter takes the measurement, and
    the weights are multiplied by the likelihoods of the innovations. The estimate is the weighted
    mean. A torque that jumps while the joint moves (a contact) is followed at the slow rate of
    ``disturbance_rate``. With ``crossing_jump`` zero both filters are the plain Kalman observer.

    Gains: ``position_noise`` [rad] > 0 and ``disturbance_rate`` [Nm/sqrt(s)] > 0 as there;
    ``crossing_jump`` [Nm], standard deviation of the change of friction at a passage through zero
    velocity, about its Coulomb level; ``jump_memory`` [s] > 0.
    """

    identifier = 'kalman_imm'
    label = 'Kalman IMM'
    place = 10.0
    coupled = True
    gain_units: ClassVar[Mapping[str, str]] = {
        **Kalman.gain_units,
        'crossing_jump': 'Nm',
        'jump_memory': 's',
    }
    positive_gains: ClassVar[tuple[str, ...]] = (*Kalman.positive_gains, 'jump_memory')
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'kalman_imm': SearchSpace(
            {
                'disturbance_rate': RATE,
                'crossing_jump': JUMP,
                'jump_memory': SearchRange(0.01, 3.0),
            },
            SWEEP,
        )
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._modes = np.full((self.n, 2, 3), np.nan)
        self._covariances = np.full((self.n, 2, 3, 3), np.nan)
        self._weight = np.full((self.n, 2), np.nan)

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return a tenth of the random walk, and a jump of D / 2 believed in for T / 3."""
        return {
            **cls._between_jumps(conditions),
            'crossing_jump': 0.5 * conditions.friction_jump,
            'jump_memory': conditions.reversal_time / 3.0,
        }

    def _filter(self, samples: MomentumSamples) -> FloatArray:
        state = self._x, self._P, self._modes, self._covariances, self._weight, self._begun
        gains = tuple(self.gains.values())
        return _run(*state, samples.columns, samples.mobility, gains)

    def mode_probabilities(self) -> FloatArray:
        """Return the weights of no recent jump and of one, (n, 2); NaN before the first sample."""
        return self._weight.copy()
