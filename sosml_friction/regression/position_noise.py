# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the measurement of a position adds to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.signal_noise import white_noise


@dataclass(frozen=True)
class PositionNoise:
    """
    Hold a motion and what its measurement adds, for n joints.

    ``q`` (N, n) [rad or m]: the motion without what was added; ``quantum`` (n,) [rad or m]: its
    steps, 0 for none; ``white`` (n,) [rad or m] and ``effort`` (n,) [Nm or N]: standard deviation
    of white noise of position and of effort; ``inertia`` (n, n).
    """

    q: FloatArray
    quantum: FloatArray
    white: FloatArray
    effort: FloatArray
    inertia: FloatArray

    @classmethod
    def seen(
        cls,
        measured: FloatArray,
        q: FloatArray,
        quantum: FloatArray,
        effort: FloatArray,
        inertia: FloatArray,
    ) -> PositionNoise:
        """
        Return the noise of ``measured`` (N, n), a motion ``q`` read in steps of ``quantum``.

        Steps alone look like noise, by how fast the motion goes over them: white is what is more
        than reading the motion in them makes.
        """
        steps = cls(q, quantum, np.zeros(len(quantum)), effort, inertia)
        read = q + steps.drawn(np.random.default_rng(0))
        seen, own = (np.array([white_noise(column) for column in x.T]) for x in (measured, read))
        more = seen**2 - np.where(quantum > 0.0, own**2, 0.0)
        return replace(steps, white=np.sqrt(np.maximum(more, 0.0)))

    def drawn(self, rng: np.random.Generator) -> FloatArray:
        """
        Return noise of position along the motion, (N, n).

        The motion is read in steps once more, from another zero: at constant speed the steps of
        an encoder make a line, which may be in the band, and not white noise.
        """
        e = self.white * rng.standard_normal(self.q.shape)
        for i in np.flatnonzero(self.quantum > 0.0):
            step = self.quantum[i]
            true = self.q[:, i] + rng.uniform(0.0, step)
            e[:, i] = step * np.round((true + e[:, i]) / step) - true
        return e
