# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort in another scale than the torque at the joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import ReportTerm


class EffortScale(Effect):
    """Add error * tau: the torque constant, or gear ratio, of the effort is wrong."""

    identifier: ClassVar[str] = 'effort_scale'
    amplitudes: ClassVar[Mapping[str, str]] = {'error': '1'}
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the nominal effort."""
        return signals.in_joint(joint, signals.torque[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ReportTerm:
        """Return a report of another scale."""
        scale = np.ones(robot.n)
        scale[joint] += amplitude[0]
        return ReportTerm(lambda torque: torque * scale, lambda report: report / scale)

    def tolerated(self, fit: Fitted, tolerance: float) -> bool:
        """Tell whether a torque constant that is off by its tolerance may have such an error."""
        return bool(abs(fit.amplitude[0]) < tolerance)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if abs(fit.amplitude[0]) > 0.5:
            return 'the effort would be wrong by more than half'
        return ''
