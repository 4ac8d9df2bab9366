# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""SOSML as the paper steps it: explicit Euler with a boundary layer, for comparison."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.kinds.sosml import Sosml
from sosml_friction.observers.momentum_samples import Columns, MomentumSamples
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace


@compiled
def _run(
    p_hat: FloatArray,
    sigma: FloatArray,
    p_previous: FloatArray,
    samples: Columns,
    gains: tuple[FloatArray, ...],
) -> FloatArray:
    """Advance the states (n,) in place and return sigma after each interval, (N, n)."""
    h, p, _, forcing, _ = samples
    s1, t1, s2, t2, boundary = gains
    estimate = np.empty_like(p)
    for k in range(len(p)):
        for i in range(len(sigma)):
            e = p_hat[i] - p_previous[i]
            s = min(max(e / boundary[i], -1.0), 1.0)
            p_hat[i] += h[k] * (forcing[k, i] + sigma[i] - t1[i] * np.sqrt(abs(e)) * s - t2[i] * e)
            sigma[i] -= h[k] * (s1[i] * s + s2[i] * e)
            p_previous[i] = p[k, i]
            estimate[k, i] = sigma[i]
            if not (np.isfinite(sigma[i]) and np.isfinite(p_hat[i])):
                estimate[k, i] = np.nan
                sigma[i] = 0.0
                p_hat[i] = p[k, i]
    return estimate


class SosmlExplicit(Sosml):
    """
    Step equations (14)-(16) by explicit Euler, s_eps in place of the sign, once corrected.

    Corrected: the left side of (15) is d p_hat / dt, and the Coriolis matrix is transposed. With
    e = p_hat - p and s(e) = min(max(e / eps, -1), 1), element by element ::

        p_hat' = tau + C^T q' - g + sigma - T1 |e|^(1/2) s(e) - T2 e
        sigma' = -S1 s(e) - S2 e,   tau_e = sigma

    Inside the layer |e| < eps the root times s has slope zero at e = 0 and damps nothing, so T2
    alone does. With right sides at the beginning of an interval h the estimate of a constant is
    locally stable only for ::

        h (S1 / eps + S2) < T2 < 2 / h + h / 2 (S1 / eps + S2)

    (the two conditions of Jury on z^2 - (2 - h T2) z + 1 - h T2 + h^2 (S1 / eps + S2)); below, it
    ends in a limit cycle, above, it diverges. :class:`Sosml` has neither. An estimate that
    overflows is NaN and the joint starts afresh.

    Gains: ``sliding`` S1 [Nm/s], ``sliding_root`` T1 [sqrt(Nm/s)], ``linear`` S2 [1/s^2],
    ``linear_damping`` T2 [1/s], ``boundary`` eps [Nm s] > 0.
    """

    identifier = 'sosml_explicit'
    label = 'SOSML explicit'
    place = 6.0
    gain_units: ClassVar[Mapping[str, str]] = {**Sosml.gain_units, 'boundary': 'Nm s'}
    positive_gains: ClassVar[tuple[str, ...]] = ('boundary',)
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'sosml_explicit': SearchSpace(
            {**Sosml.study['sosml'].ranges, 'boundary': SearchRange(1e-6, 1.0)}, ('linear', 2.0)
        )
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        self._p = np.full(self.n, np.nan)

    @classmethod
    def _on_linear(cls, wn: FloatArray, zeta: float, momentum_noise: FloatArray) -> Recipe:
        """
        Return the gains of SOSML with a layer of three standard deviations of the momentum.

        Noise then stays inside, where the stiffness S1 / eps is a thirtieth of S2. Without noise
        there is no sliding term, and any layer will do.
        """
        boundary = np.where(momentum_noise > 0.0, 3.0 * momentum_noise, 1.0)
        return {**super()._on_linear(wn, zeta, momentum_noise), 'boundary': boundary}

    def start(self, p: FloatArray) -> None:
        super().start(p)
        self._p[:] = p

    def run(self, samples: MomentumSamples) -> FloatArray:
        gains = tuple(self.gains.values())
        p_hat, sigma = self._state
        return _run(p_hat, sigma, self._p, samples.columns, gains)

    def stiffness(self) -> FloatArray:
        """Return S1 / eps + S2, the slope of -sigma' at e = 0, (n,) [1/s^2]."""
        return self.gains['sliding'] / self.gains['boundary'] + self.gains['linear']

    def locally_stable(self, h: float) -> BoolArray:
        """
        Return for each joint whether its estimate of a constant disturbance can settle.

        :param h: sampling interval [s].
        """
        K, t2 = self.stiffness(), self.gains['linear_damping']
        return (h * K < t2) & (t2 < 2.0 / h + 0.5 * h * K)

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """
        Return the filter linearised at e = 0, which small disturbances see.

        e_k = (1 - h T2) e_{k-1} + h sigma_{k-1} - h d_k, sigma_k = sigma_{k-1} - h K e_{k-1} with
        K = S1 / eps + S2; e is eliminated. Where it is not locally stable there is no such
        filter: the observer swings about the disturbance and is taken to have no lag.
        """
        if not self.locally_stable(h)[joint]:
            return np.ones(1), np.ones(1)
        K, t2 = self.stiffness()[joint], self.gains['linear_damping'][joint]
        return (
            np.array([0.0, h * h * K]),
            np.array([1.0, -(2.0 - h * t2), 1.0 - h * t2 + h * h * K]),
        )
