# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is left along any one axis: not a cause, but the sign that one is missing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.free_curves import knots_of
from sosml_friction.diagnosis.kernels import hats
from sosml_friction.diagnosis.signals import Signals

_HATS = 9
#: The axes, as signals (N, n).
_AXES: tuple[Callable[[Signals], FloatArray], ...] = (
    lambda s: s.v,
    lambda s: s.q,
    lambda s: s.a,
    lambda s: s.torque,
)


class Structure(Effect):
    """
    Add any smooth function of velocity, position, acceleration, load, and s times each.

    Hat functions on quantiles of the data, which know no physics: what they predict on data left
    out is structure, whatever its name. Not part of the catalogue.
    """

    identifier: ClassVar[str] = 'structure'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(8 * _HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        self._knots = [knots_of(stretches, axis, _HATS) for axis in _AXES]

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the hats."""
        result = np.zeros((len(signals.q), signals.robot.n, 8 * _HATS))
        result[:, joint] = self.own_columns(signals, joint, (inner,))[:, 0]
        return result

    def own_columns(self, signals: Signals, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, k)."""
        s = signals.sign[:, joint]
        result = np.zeros((len(s), 1, 8 * _HATS))
        for k, (axis, knots) in enumerate(zip(_AXES, self._knots, strict=True)):
            own = knots[joint]
            hat = hats(np.ascontiguousarray(axis(signals)[:, joint]), own)
            first = 2 * k * _HATS
            result[:, 0, first : first + len(own)] = hat
            first += _HATS
            result[:, 0, first : first + len(own)] = hat * s[:, None]
        return result
