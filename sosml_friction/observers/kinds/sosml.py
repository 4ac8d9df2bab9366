# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""SOSML: the second-order sliding-mode momentum observer, equations (13)-(16) corrected."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer, Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace


@compiled
def _run(
    state: FloatArray,
    h: FloatArray,
    p: FloatArray,
    forcing: FloatArray,
    terms: FloatArray,
) -> FloatArray:
    """Advance p_hat and sigma, (2, n), in place and return sigma after each interval, (N, n)."""
    p_hat, sigma = state
    s1, t1, s2, t2 = terms
    estimate = np.empty_like(p)
    for k in range(len(p)):
        T = h[k]
        for i in range(len(sigma)):
            y = p_hat[i] + T * (forcing[k, i] + sigma[i]) - p[k, i]
            outside = abs(y) - T * T * s1[i]
            if outside <= 0.0:
                # The sliding set: e = 0 solves the inclusion with the sign anywhere in [-1, 1].
                sigma[i] -= y / T
                p_hat[i] = p[k, i]
            else:
                # A x^2 + T T1 x = |y| - T^2 S1 for x = sqrt(|e|), root without cancellation.
                A = 1.0 + T * t2[i] + T * T * s2[i]
                b = T * t1[i]
                x = 2.0 * outside / (b + np.sqrt(b * b + 4.0 * A * outside))
                e = np.sign(y) * x * x
                sigma[i] -= T * (s1[i] * np.sign(y) + s2[i] * e)
                p_hat[i] = p[k, i] + e
            estimate[k, i] = sigma[i]
            if not np.isfinite(sigma[i]):
                estimate[k, i] = np.nan
                sigma[i] = 0.0
                p_hat[i] = p[k, i]
    return estimate


class Sosml(Observer):
    """
    Track the momentum by a super-twisting observer with linear terms, stepped implicitly.

    With e = p_hat - p: p_hat' = tau + C^T q' - g + sigma - T1 |e|^(1/2) sgn(e) - T2 e,
    sigma' = -S1 sgn(e) - S2 e, tau_e = sigma. The backward Euler step has a closed-form solution,
    needs no boundary layer and does not chatter. With S1 = T1 = 0 it is the linear second-order
    observer of frequency sqrt(S2) and damping T2 / (2 sqrt(S2)).

    Gains: ``sliding`` S1 [Nm/s], ``sliding_root`` T1 [sqrt(Nm/s)], ``linear`` S2 [1/s^2],
    ``linear_damping`` T2 [1/s]; ``sliding`` or ``linear`` > 0, or the estimate would never move.
    """

    identifier = 'sosml'
    label = 'SOSML'
    place = 5.0
    gain_units: ClassVar[Mapping[str, str]] = {
        'sliding': 'Nm/s',
        'sliding_root': 'sqrt(Nm/s)',
        'linear': '1/s^2',
        'linear_damping': '1/s',
    }
    causal = True
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'sosml': SearchSpace(
            {
                'sliding': SearchRange(1e-3, 1e5),
                'sliding_root': SearchRange(0.1, 10.0, 'sliding'),
                'linear': SearchRange(1.0, 1e6),
                'linear_damping': SearchRange(0.1, 4.0, 'linear'),
            },
            ('linear', 2.0),
        )
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._terms = np.array(self._of_gains())
        if not np.all(self._terms[0] + self._terms[2] > 0.0):
            raise ConfigurationError(
                f'observer {self.identifier} needs sliding > 0 or linear > 0 on each joint: '
                'without both its estimate never moves'
            )
        self._state = np.full((2, self.n), np.nan)

    def _of_gains(self) -> tuple[FloatArray, ...]:
        """Return S1, T1, S2 and T2, (n,) each."""
        return tuple(self.gains[name] for name in Sosml.gain_units)

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return S2 = wn^2, T2 = 0.8 wn, with wn of the linear observer, and S1, T1 on top."""
        return cls._on_linear(conditions.second_order_frequency, 0.4, conditions.momentum_noise)

    @classmethod
    def bandwidth_recipe(cls, w: FloatArray, momentum_noise: FloatArray) -> Recipe | None:
        """Return S2 = w^2, T2 = w, and S1, T1 on top."""
        return cls._on_linear(w, 0.5, momentum_noise)

    @classmethod
    def _on_linear(cls, wn: FloatArray, zeta: float, momentum_noise: FloatArray) -> Recipe:
        """
        Return a linear observer with S1 = 0.1 S2 s_p and T1 = 1.6 sqrt(S1).

        That is small enough that noise of the momentum, s_p, does not feel it.
        """
        sliding = 0.1 * wn**2 * momentum_noise
        return {
            'sliding': sliding,
            'sliding_root': 1.6 * np.sqrt(sliding),
            'linear': wn**2,
            'linear_damping': 2.0 * zeta * wn,
        }

    def start(self, p: FloatArray) -> None:
        self._state[0] = p
        self._state[1] = 0.0

    def run(self, samples: MomentumSamples) -> FloatArray:
        # Array by array: a tuple costs numba a microsecond in each call.
        s = samples
        return _run(self._state, s.h, s.p, s.forcing, self._terms)

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """
        Return the filter of the linear part, S1 = T1 = 0.

        The step is then A e_k = e_{k-1} + h sigma_{k-1} - h d_k, sigma_k = sigma_{k-1} - h S2 e_k
        with A = 1 + h T2 + h^2 S2; e is eliminated. The sliding terms, where they act, make the
        true lag shorter: a purely sliding observer (S2 = 0) is taken to have none.
        """
        s2, t2 = (term[joint] for term in self._terms[2:])
        if s2 == 0.0:
            return np.ones(1), np.ones(1)
        A = 1.0 + h * t2 + h * h * s2
        return np.array([h * h * s2]), np.array([A, -(A + 1.0) + h * h * s2, 1.0])
