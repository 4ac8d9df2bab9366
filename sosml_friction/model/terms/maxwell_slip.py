# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Presliding friction with a memory of all reversals: generalised Maxwell slip."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

#: Displacements at which the elements begin to slide, as shares of the largest one. Four in equal
#: ratios draw the curve from first motion to sliding to within 2 % of its level.
_SHARES = np.array([0.125, 0.25, 0.5, 1.0])


class MaxwellSlip(EffortTerm):
    """
    Add the sum of F_k (z_k - s), z_k' = q' / x_k, |z_k| <= 1: elements that stick, then slide.

    Each element is a spring of stiffness F_k / x_k before a block of Coulomb friction F_k; x_k are
    fixed shares of ``displacement`` x [rad or m], over which all slide. Unlike Dahl's, the state
    does not drift under small oscillations about a load, and a small loop within a large one
    closes (Al-Bender, Lampaert and Swevers, 2005; its sliding part is the law's own).
    """

    identifier: ClassVar[str] = 'maxwell_slip'
    amplitudes: ClassVar[Mapping[str, str]] = {
        f'level_{k + 1}': '{effort}' for k in range(len(_SHARES))
    }
    inner: ClassVar[Mapping[str, str]] = {'displacement': '{length}'}
    refined: ClassVar[tuple[str, ...]] = ('displacement',)
    axis: ClassVar[str] = 'displacement'
    searched: ClassVar[bool] = False
    inseparable: ClassVar[tuple[str, ...]] = ('presliding_hysteresis',)

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return z_k - s of each element."""
        s = motion.sign[:, joint]
        return tuple(z - s for z in state.T)

    def path_state(self, path: FloatArray, inner: Inner) -> FloatArray:
        """Return z_k along a path, (N, elements), all springs slack at its start."""
        result = np.zeros((len(path), len(_SHARES)))
        for k in range(1, len(path)):
            result[k] = _slide(result[k - 1], path[k] - path[k - 1], inner)
        return result

    def next_state(self, state: FloatArray, dq: FloatArray, inner: Inner) -> FloatArray:
        """Return z_k after a displacement."""
        return _slide(state, dq[:, None], inner)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        smallest = float(signals.scales.sign_limit[joint])
        return [{'displacement': smallest * k} for k in (2.0, 4.0, 8.0, 16.0, 32.0)]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        smallest = float(signals.scales.sign_limit[joint])
        return {'displacement': (smallest, 80.0 * smallest)}


def _slide(z: FloatArray, dq: FloatArray | float, inner: Inner) -> FloatArray:
    """Return the states after a displacement: each spring stretches until its block slides."""
    return np.clip(z + dq / (_SHARES * inner['displacement']), -1.0, 1.0)
