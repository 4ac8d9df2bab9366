# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A constant in the measured effort."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import ReportTerm


class EffortBias(Effect):
    """Add bias: an offset of the current sensor."""

    identifier: ClassVar[str] = 'effort_bias'
    amplitudes: ClassVar[Mapping[str, str]] = {'bias': '{effort}'}
    parameter_error: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = ('asymmetric_friction',)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return 1."""
        return signals.in_joint(joint, np.ones(len(signals.q)))

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ReportTerm:
        """Return a report that is the bias more than the torque."""
        bias = np.zeros(robot.n)
        bias[joint] = amplitude[0]
        return ReportTerm(lambda torque: torque + bias, lambda report: report - bias)

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the model knows of a bias, or of none."""
        return bool(np.isfinite(signals.scales.bias[joint]))
