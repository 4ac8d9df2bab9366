# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Any function of time, and of the position and the speed of the next joints."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.knots import APART, knots_of, padded_hats
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.structure import HATS, spread


class Elsewhere(Curve):
    """
    Add f + s g of time, and of position and velocity of both next joints, beside Structure.

    Of a next joint that moves in proportion nothing is asked by velocity: beside the joint's own
    its noise is left, which a loop feeds back into effort.
    """

    identifier: ClassVar[str] = 'elsewhere'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(10 * HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        times = np.concatenate([s.time for s in stretches])
        self._times = np.linspace(times.min(), times.max(), HATS)
        self._positions = knots_of(stretches, lambda s: s.q, HATS)
        noise = spread(stretches, lambda s: s.jitter)
        self._speeds = knots_of(stretches, lambda s: s.v, HATS, noise)
        self._apart = apart(stretches)

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the hats."""
        return signals.in_joint(joint, *self.own_columns(signals, joint, (inner,))[:, 0].T)

    def own_columns(self, signals: Recording, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, 2 hats of each axis)."""
        factors = 1.0, signals.sign[:, joint]
        parts = [padded_hats(signals.time, self._times, HATS, factors)]
        for k in (joint - 1, joint + 1):
            if 0 <= k < signals.robot.n:
                parts.append(padded_hats(signals.q[:, k], self._positions[k], HATS, factors))
                apart = float(self._apart[joint, k])
                own = [apart * factor for factor in factors]
                parts.append(padded_hats(signals.v[:, k], self._speeds[k], HATS, own))
        return np.concatenate(parts, axis=1)[:, None]


def apart(stretches: Sequence[Signals]) -> BoolArray:
    """Tell of which joints (n, n) the second's velocity is no multiple of the first's."""
    v = np.concatenate([s.v for s in stretches])
    square = v.T @ v
    own = np.maximum(np.diag(square)[:, None], 1e-300)
    left = np.sqrt(np.maximum(np.diag(square) - square**2 / own, 0.0) / len(v))
    return np.asarray(left > APART * spread(stretches, lambda s: s.jitter))
