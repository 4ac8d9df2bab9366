# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The motion that an effort depends on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray


@dataclass
class Motion:
    """
    Hold what terms look at: N samples of a recording, or N simulated windows at one instant.

    ``time`` (N,) [s] since the start of the recording; ``q``, ``v`` (N, n) [rad or m and per s];
    ``sign`` (N, n): the sign of motion as a state, -1..1; ``load`` (N, n): what the gear passes
    on, M q'' + C q' + g [Nm or N]; ``warm`` (N, n): rise of temperature since the first sample
    [degC], NaN where it is not measured.
    """

    time: FloatArray
    q: FloatArray
    v: FloatArray
    sign: FloatArray
    load: FloatArray
    warm: FloatArray

    def of(self, rows: IndexArray) -> Motion:
        """Return the motion of some samples or windows."""
        parts = (self.time, self.q, self.v, self.sign, self.load, self.warm)
        return Motion(*(part[rows] for part in parts))

    @classmethod
    def steady(cls, v: FloatArray, sign: FloatArray) -> Motion:
        """Return motion at velocities and signs (..., n), without load, at the start of time."""
        nothing = np.zeros_like(v)
        return cls(np.zeros(v.shape[:-1]), nothing, v, sign, nothing, nothing)
