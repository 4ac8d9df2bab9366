# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Any function of position."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.knots import knots_of, padded_hats
from sosml_friction.regression.signals import Signals

_HATS = 8


class PositionCurve(Curve):
    """Add f(q) with any piecewise linear f: a spring that is not straight, a cable, a stop."""

    identifier: ClassVar[str] = 'position'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(_HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        self._knots = knots_of(stretches, lambda s: s.q, _HATS)

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return hat functions on quantiles of q, (N, n, hats)."""
        curves = padded_hats(signals.q[:, joint], self._knots[joint], _HATS)
        return signals.in_joint(joint, *curves.T)
