# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""FO behind a first-order low-pass, as practitioners run it on a differentiated velocity."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.kinds.first_order import CUTOFF, FirstOrder
from sosml_friction.observers.momentum_samples import Columns, MomentumSamples
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace


@compiled
def _transition(c0: float, wf: float, h: float) -> tuple[float, float, float]:
    """Return exp(-wf h), exp(-c0 h) and how much of the first lag reaches the second one."""
    apart = abs(c0 - wf) * h
    # c0 (exp(-wf h) - exp(-c0 h)) / (c0 - wf), whose limit for equal ones is c0 h exp(-c0 h).
    shape = -np.expm1(-apart) / apart if apart > 0.0 else 1.0
    return np.exp(-wf * h), np.exp(-c0 * h), c0 * h * np.exp(-min(c0, wf) * h) * shape


@compiled
def _run(
    f: FloatArray,
    r: FloatArray,
    p_previous: FloatArray,
    samples: Columns,
    gains: tuple[FloatArray, ...],
) -> FloatArray:
    h, p, _, forcing, _ = samples
    c0, wf = gains
    estimate = np.empty_like(p)
    for k in range(len(p)):
        for i in range(len(r)):
            a_f, a_r, g = _transition(c0[i], wf[i], h[k])
            d = (p[k, i] - p_previous[i]) / h[k] - forcing[k, i]
            r[i] = a_r * r[i] + g * f[i] + (1.0 - a_r - g) * d
            f[i] = a_f * f[i] + (1.0 - a_f) * d
            p_previous[i] = p[k, i]
            estimate[k, i] = r[i]
            if not np.isfinite(r[i] + f[i]):
                estimate[k, i] = np.nan
                r[i] = 0.0
                f[i] = 0.0
    return estimate


class FirstOrderPrefiltered(FirstOrder):
    """
    Filter the momentum residual by w_f / (s + w_f) and c0 / (s + c0), discretised exactly.

    The usual cure for a velocity that comes from differences. Momentum and forcing pass it alike:
    with the momentum alone filtered, inertial torque would leak into the estimate ::

        tau_e_hat = c0 / (s + c0) w_f / (s + w_f) tau_e

    For the residual d held over an interval the exact step is, with a_f = exp(-w_f h),
    a_r = exp(-c0 h), g = c0 (a_f - a_r) / (c0 - w_f) ::

        r_k = a_r r_{k-1} + g f_{k-1} + (1 - a_r - g) d_k,   f_k = a_f f_{k-1} + (1 - a_f) d_k

    Gains: ``cutoff`` c0 [1/s] > 0, ``prefilter_cutoff`` w_f [1/s] > 0.
    """

    identifier = 'first_order_prefiltered'
    label = 'FO+prefilter'
    place = 3.0
    gain_units: ClassVar[Mapping[str, str]] = {'cutoff': '1/s', 'prefilter_cutoff': '1/s'}
    positive_gains: ClassVar[tuple[str, ...]] = ('cutoff', 'prefilter_cutoff')
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'first_order_prefiltered': SearchSpace(
            {'cutoff': CUTOFF, 'prefilter_cutoff': SearchRange(0.1, 10.0, 'cutoff', 1.0)},
            ('cutoff', 1.0),
        )
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._f = np.full(self.n, np.nan)

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return both poles at (5/4)^(1/5) wn, wn balanced for second order: J = 5/4."""
        both = 1.25**0.2 * conditions.second_order_frequency
        return {'cutoff': both, 'prefilter_cutoff': both}

    @classmethod
    def bandwidth_recipe(cls, w: FloatArray, momentum_noise: FloatArray) -> Recipe | None:
        """Return both poles at 2 w."""
        return {'cutoff': 2.0 * w, 'prefilter_cutoff': 2.0 * w}

    def start(self, p: FloatArray) -> None:
        super().start(p)
        self._f[:] = 0.0

    def run(self, samples: MomentumSamples) -> FloatArray:
        r, p = self._state
        return _run(self._f, r, p, samples.columns, tuple(self.gains.values()))

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return the step of the class's equations with f eliminated."""
        c0, wf = (float(self.gains[name][joint]) for name in self.gain_units)
        a_f, a_r, g = _transition(c0, wf, h)
        direct = 1.0 - a_r - g
        b = np.array([direct, g * (1.0 - a_f) - direct * a_f])
        return b, np.convolve([1.0, -a_r], [1.0, -a_f])
