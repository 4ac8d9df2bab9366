# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A base that does not stand as the model says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.rigid_terms import between, coarse_rows
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Body
from sosml_friction.simulation.forward_terms import BodyTerm


class GravityTilt(Effect):
    """Add dg/dphi phi: the base is turned by phi_x, phi_y [rad] about its horizontal axes."""

    identifier: ClassVar[str] = 'gravity_tilt'
    amplitudes: ClassVar[Mapping[str, str]] = {'rotation_x': 'rad', 'rotation_y': 'rad'}
    of_robot: ClassVar[bool] = True
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the derivative of gravity by the rotation."""
        if ('tilt', 0) in signals.cache:
            return signals.cache[('tilt', 0)]
        g0 = signals.robot.gravity_acceleration
        rows = coarse_rows(signals)
        result = np.zeros((len(signals.q), signals.robot.n, 2))
        for k, axis in enumerate(np.eye(3)[:2]):
            # The gravity torque is linear in the acceleration of gravity.
            turned = np.cross(g0, axis)
            coarse = np.array([signals.robot.gravity_under(q, turned) for q in signals.q[rows]])
            result[:, :, k] = between(signals, rows, coarse)
        signals.cache[('tilt', 0)] = result
        return result

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> BodyTerm:
        """Return gravity turned, to first order in the angles."""
        rotation = np.array([amplitude[0], amplitude[1], 0.0])

        def body(body: Body) -> None:
            body.gravity += np.cross(body.gravity, rotation)

        return BodyTerm(body)

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether gravity acts on the robot."""
        g0 = signals.robot.gravity_acceleration
        felt = signals.robot.gravity(signals.q[len(signals.q) // 2])
        return bool(g0.any()) and bool(np.abs(felt).max() > 0.0)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if np.abs(fit.amplitude).max() > 0.3:
            return 'a base tilted by over 17 degrees would be seen'
        return ''
