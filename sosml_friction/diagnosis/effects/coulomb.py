# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb friction of another size than the model says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import LoadTerm


class Coulomb(Effect):
    """Add change * s, s the sign of motion: the level is not the nominal one."""

    identifier: ClassVar[str] = 'coulomb'
    amplitudes: ClassVar[Mapping[str, str]] = {'change': '{effort}'}
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s."""
        return signals.in_joint(joint, signals.sign[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return change * s."""
        change = float(amplitude[0])
        return LoadTerm(joint, lambda m: change * m.sign[:, joint], change)

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the model has a Coulomb friction to be wrong."""
        return bool(np.isfinite(signals.scales.coulomb[joint]))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.signals.scales.coulomb[fit.joint] + fit.amplitude[0] < 0.0:
            return 'Coulomb friction would be negative'
        return ''
