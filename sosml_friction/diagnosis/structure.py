# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is left along any one axis: not a cause, but the sign that one is missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.kernels import hats
from sosml_friction.diagnosis.signals import Signals

_HATS = 9


class Structure(Effect):
    """
    Add any smooth function of velocity, position, acceleration, load, and s times each.

    Hat functions on quantiles of the data, which know no physics: what they predict on data left
    out is structure, whatever its name. Not part of the catalogue.
    """

    identifier: ClassVar[str] = 'structure'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(8 * _HATS)}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the hats."""
        result = np.zeros((len(signals.q), signals.robot.n, 8 * _HATS))
        result[:, joint] = self.own_columns(signals, joint, (inner,))[:, 0]
        return result

    def own_columns(self, signals: Signals, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, k)."""
        s = signals.sign[:, joint]
        axes = (
            signals.v[:, joint],
            signals.q[:, joint],
            signals.a[:, joint],
            signals.torque[:, joint],
        )
        result = np.zeros((len(s), 1, 8 * _HATS))
        for k, x in enumerate(axes):
            knots = np.unique(np.quantile(x, np.linspace(0.01, 0.99, _HATS)))
            hat = hats(np.ascontiguousarray(x), knots)
            first = 2 * k * _HATS
            result[:, 0, first : first + len(knots)] = hat
            first += _HATS
            result[:, 0, first : first + len(knots)] = hat * s[:, None]
        return result
