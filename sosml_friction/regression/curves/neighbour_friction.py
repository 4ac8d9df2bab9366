# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that follows the position of the next joints."""

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.neighbour_curve import neighbours


class NeighbourFriction(Curve):
    """
    Add s (a x_k + b x_k^2), x_k where the joint before and after is: friction that follows them.

    x_k is q_k over half its range in all recordings; its origin does not matter beside a free s. A
    free curve of 12 columns per neighbour holds it too, but its chance hides a little of it.
    """

    identifier: ClassVar[str] = 'friction_by_neighbours'
    amplitudes: ClassVar[Mapping[str, str]] = {f'power_{k}': '{effort}' for k in range(4)}

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return s x_k and s x_k^2 of each neighbour, (N, n, 2 each)."""
        s = signals.sign[:, joint]
        powers = []
        for k in neighbours(signals.robot.n, joint):
            x = 2.0 * signals.q[:, k] / float(signals.scales.span[k])
            powers += [s * x, s * x**2]
        return signals.in_joint(joint, *powers)
