# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb friction of another size than the model says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import (
    Effect,
    FloatArray,
    Inner,
    effort_unit,
    in_joint,
)
from sosml_friction.diagnosis.signals import Signals
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.forward_terms import LoadTerm


class Coulomb(Effect):
    """Add change * s, s the sign of motion: the level is not the nominal one."""

    identifier: ClassVar[str] = 'coulomb'
    amplitudes: ClassVar[tuple[str, ...]] = ('change',)
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s."""
        return in_joint(signals, joint, signals.sign[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return change * s."""
        change = float(amplitude[0])
        return LoadTerm(joint, lambda m: change * m.sign[:, joint], change)

    def units(self, signals: Signals, joint: int) -> Mapping[str, str]:
        """Return the units."""
        return {'change': effort_unit(signals, joint)}

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the model has a Coulomb friction to be wrong."""
        return bool(np.isfinite(signals.scales.coulomb[joint]))

    def implausible(
        self,
        signals: Signals,
        joint: int,
        inner: Inner,
        amplitude: FloatArray,
        error: FloatArray,
    ) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if signals.scales.coulomb[joint] + amplitude[0] < 0.0:
            return 'Coulomb friction would be negative'
        return ''
