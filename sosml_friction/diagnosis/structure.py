# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is left along any one axis: not a cause, but the sign that one is missing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner, effort_unit
from sosml_friction.diagnosis.signals import Signals

_HATS = 9


class Structure(Effect):
    """
    Add any smooth function of velocity, position, acceleration, load, and s times each.

    Hat functions on quantiles of the data, which know no physics: what they predict on data left
    out is structure, whatever its name. Not part of the catalogue.
    """

    identifier: ClassVar[str] = 'structure'
    amplitudes: ClassVar[tuple[str, ...]] = tuple(f'hat_{k}' for k in range(8 * _HATS))

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the hats, each with its mean taken off."""
        s = signals.sign[:, joint]
        axes = (
            signals.v[:, joint],
            signals.q[:, joint],
            signals.a[:, joint],
            signals.torque[:, joint],
        )
        result = np.zeros((len(s), signals.robot.n, 8 * _HATS))
        for k, x in enumerate(axes):
            knots = np.unique(np.quantile(x, np.linspace(0.01, 0.99, _HATS)))
            for j in range(len(knots)):
                hat = np.interp(x, knots, np.eye(len(knots))[j])
                result[:, joint, 2 * k * _HATS + j] = hat
                result[:, joint, (2 * k + 1) * _HATS + j] = hat * s
        return result

    def units(self, signals: Signals, joint: int) -> Mapping[str, str]:
        """Return the units."""
        return dict.fromkeys(self.amplitudes, effort_unit(signals, joint))
