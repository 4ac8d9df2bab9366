# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that goes up and down in time, faster than a curve of nine hats follows."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.knots import padded_hats
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.structure import HATS
from sosml_friction.regression.wandering_friction import CYCLES

#: Hats of time: eight times as many as a curve of one quantity has.
WANDERING_HATS = 8 * HATS


class Wandering(Curve):
    """Add s f(t), f of hats that the samples are spread evenly over."""

    identifier: ClassVar[str] = 'wandering'
    amplitudes: ClassVar[Mapping[str, str]] = {
        f'hat_{k}': '{effort}' for k in range(WANDERING_HATS)
    }

    def __init__(self, stretches: Sequence[Signals]) -> None:
        times = np.concatenate([s.time for s in stretches])
        seconds = sum(len(s.time) * s.band.step for s in stretches)
        most = int(seconds * stretches[0].band.cutoff / CYCLES)
        shares = np.linspace(0.0, 1.0, min(WANDERING_HATS, max(most, 2)))
        self._times = np.quantile(times, shares)

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the hats."""
        return signals.in_joint(joint, *self.own_columns(signals, joint, (inner,))[:, 0].T)

    def own_columns(self, signals: Recording, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, WANDERING_HATS)."""
        sign = signals.sign[:, joint]
        return padded_hats(signals.time, self._times, WANDERING_HATS, (sign,))[:, None]
