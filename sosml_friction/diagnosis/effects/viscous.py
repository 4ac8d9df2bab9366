# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Viscous friction of another size than the model says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import LoadTerm


class Viscous(Effect):
    """Add change * q': the slope of friction is not the nominal one."""

    identifier: ClassVar[str] = 'viscous'
    amplitudes: ClassVar[Mapping[str, str]] = {'change': '{effort} s/{length}'}
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return q'."""
        return signals.in_joint(joint, signals.v[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return change * q'."""
        change = float(amplitude[0])
        return LoadTerm(joint, lambda m: change * m.v[:, joint])

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the model has a viscous friction to be wrong."""
        return bool(np.isfinite(signals.scales.viscous[joint]))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.signals.scales.viscous[fit.joint] + fit.amplitude[0] < 0.0:
            return 'viscous friction would be negative'
        return ''
