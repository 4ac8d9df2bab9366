# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A base that does not stand as the model says."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.terms.kinds.term import Inner


class GravityTilt(BodyTerm):
    """Turn gravity: the base is turned by phi_x, phi_y [rad] about its horizontal axes."""

    identifier: ClassVar[str] = 'gravity_tilt'
    amplitudes: ClassVar[Mapping[str, str]] = {'rotation_x': 'rad', 'rotation_y': 'rad'}
    of_robot: ClassVar[bool] = True
    parameter_error: ClassVar[bool] = True

    def changes(self, robot: Robot, joint: int, inner: Inner) -> tuple[Body, ...]:
        """Return how gravity turns, to first order in the angles."""
        result = []
        for axis in np.eye(3)[:2]:
            body = Body.unchanged(robot.n)
            body.gravity = np.cross(robot.gravity_acceleration, axis)
            result.append(body)
        return tuple(result)

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether gravity acts on the robot."""
        g0 = signals.robot.gravity_acceleration
        felt = signals.robot.gravity(signals.q[len(signals.q) // 2])
        return bool(g0.any()) and bool(np.abs(felt).max() > 0.0)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if np.abs(fit.amplitude).max() > 0.3:
            return 'a base tilted by over 17 degrees would be seen'
        return ''
