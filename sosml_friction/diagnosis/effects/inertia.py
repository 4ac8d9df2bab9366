# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A reflected rotor inertia that is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Body
from sosml_friction.simulation.forward_terms import BodyTerm


class Inertia(Effect):
    """Add change * q'': the inertia about the joint's axis is not the nominal one."""

    identifier: ClassVar[str] = 'inertia'
    amplitudes: ClassVar[Mapping[str, str]] = {'change': '{inertia}'}
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return q''."""
        return signals.in_joint(joint, signals.a[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> BodyTerm:
        """Return a rotor that is larger by the change."""
        change = float(amplitude[0])

        def body(body: Body) -> None:
            body.rotors[joint] += change

        return BodyTerm(body)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        inertia = fit.signals.robot.inertia(np.median(fit.signals.q, axis=0))
        whole = float(inertia[fit.joint, fit.joint])
        if whole + fit.amplitude[0] < 0.3 * whole:
            return 'hardly any inertia would be left'
        return ''
