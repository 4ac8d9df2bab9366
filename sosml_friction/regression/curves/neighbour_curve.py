# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Any function of the position of the next joints."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.knots import knots_of, padded_hats
from sosml_friction.regression.signals import Signals

_HATS = 6


def neighbours(n: int, joint: int) -> list[int]:
    """Return the joints before and after one of n."""
    return [k for k in (joint - 1, joint + 1) if 0 <= k < n]


class NeighbourCurve(Curve):
    """Add f(q_k) + s g(q_k), q_k of the joint before and after: no cause of the catalogue does."""

    identifier: ClassVar[str] = 'neighbours'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(4 * _HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        self._knots = knots_of(stretches, lambda s: s.q, _HATS)

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return hat functions on quantiles of q_k, and s times each, (N, n, 2 hats each)."""
        factors = 1.0, signals.sign[:, joint]
        curves = [
            column
            for k in neighbours(signals.robot.n, joint)
            for column in padded_hats(signals.q[:, k], self._knots[k], _HATS, factors).T
        ]
        return signals.in_joint(joint, *curves)
