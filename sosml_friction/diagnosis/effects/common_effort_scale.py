# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort of all joints in the same other scale than the torque."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import FloatArray, Inner
from sosml_friction.diagnosis.effects.effort_scale import EffortScale
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import ReportTerm


class CommonEffortScale(EffortScale):
    """
    Add error * tau in all joints, the same error: one wrong unit, or motors of one kind.

    tau is linear in masses, inertias, rotors and friction: all of them off by the same share are
    the same effort along any motion. Only a mass that is known tells the two apart.
    """

    of_robot: ClassVar[bool] = True
    inseparable: ClassVar[tuple[str, ...]] = ('gravity', 'inertia')

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the nominal effort of all joints."""
        return np.array(signals.torque[:, :, None])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ReportTerm:
        """Return a report of another scale."""
        scale = 1.0 + float(amplitude[0])
        return ReportTerm(lambda torque: torque * scale, lambda report: report / scale)
