# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is late, or early, beside position."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.nominal import effort_slope
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import ReportTerm


class EffortDelay(Effect):
    """Add -d dtau/dt: effort comes a ``delay`` d [s] after position, in all joints."""

    identifier: ClassVar[str] = 'effort_delay'
    amplitudes: ClassVar[Mapping[str, str]] = {'delay': 's'}
    of_robot: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return -dtau/dt."""
        return -effort_slope(signals)[:, :, None]

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ReportTerm:
        """Return a report that is late."""
        return ReportTerm(lambda torque: torque, lambda report: report, float(amplitude[0]))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if abs(fit.amplitude[0]) < 0.75 * fit.signals.band.step:
            return 'a delay within a sampling interval is where in it a sample is taken'
        if abs(fit.amplitude[0]) > 0.05:
            return 'a delay of over 50 ms would be seen'
        return ''
