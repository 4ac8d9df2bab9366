# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort in another scale than the torque at the joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import (
    Effect,
    FloatArray,
    Inner,
    in_joint,
)
from sosml_friction.diagnosis.signals import Signals
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.forward_terms import ReportTerm


class EffortScale(Effect):
    """Add error * tau: the torque constant, or gear ratio, of the effort is wrong."""

    identifier: ClassVar[str] = 'effort_scale'
    amplitudes: ClassVar[tuple[str, ...]] = ('error',)
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the nominal effort."""
        return in_joint(signals, joint, signals.torque[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ReportTerm:
        """Return a report of another scale."""
        scale = np.ones(robot.n)
        scale[joint] += amplitude[0]
        return ReportTerm(lambda torque: torque * scale, lambda report: report / scale)

    def units(self, signals: Signals, joint: int) -> Mapping[str, str]:
        """Return the units."""
        return {'error': '1'}

    def implausible(
        self,
        signals: Signals,
        joint: int,
        inner: Inner,
        amplitude: FloatArray,
        error: FloatArray,
    ) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if abs(amplitude[0]) > 0.5:
            return 'the effort would be wrong by more than half'
        return ''
