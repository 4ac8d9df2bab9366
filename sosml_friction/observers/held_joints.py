# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether joints that the model holds still are where it holds them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot

#: Weight that is elsewhere is told beyond so many standard errors of the estimate, or, where these
#: are not known, beyond this share of gravity; another inertia beyond that share. Chosen.
_ERRORS = 3.0
_WEIGHT = 0.02
_INERTIA = 0.1
#: Time between two looks [s]: each makes a robot, which takes some ms.
_LOOK_S = 0.2


class HeldJoints:
    """
    Find the joints whose friction is not known because another, which is held, is elsewhere.

    With g and M of the model, and g' and M' with the held joints where they are measured, that is
    joint i where ``|g'_i - g_i| > 3 s_i`` (``0.02 |g_i|`` without a standard error s_i) or
    ``|M'_ii - M_ii| > 0.1 M_ii``. So the noise of an encoder, and a gripper that opens, are none.

    :param robot: that holds them.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.names = tuple(robot.held)
        self._at = dict(robot.held)
        self._looked_s = -math.inf
        # The last that was known: what is not given has none.
        self._error = np.full(robot.n, np.nan)
        #: By joint of the robot whose friction is not known: why.
        self.causes: dict[int, str] = {}

    def see(self, positions: Mapping[str, float]) -> None:
        """Take measured positions [rad or m] of held joints, by name."""
        self._at |= {name: x for name, x in positions.items() if math.isfinite(x)}

    def look(self, t_s: float, q: FloatArray, error: FloatArray) -> None:
        """
        Judge :attr:`causes` anew, unless it was done shortly before.

        :param t_s: stamp [s].
        :param q: position of the robot's joints (n,) [rad or m].
        :param error: standard error of their estimates (n,) [Nm or N], NaN where not known.
        """
        moved = {name: x for name, x in self._at.items() if x != self._robot.held[name]}
        if not moved:
            self.causes = {}
        elif abs(t_s - self._looked_s) >= _LOOK_S and np.isfinite(q).all():
            self._looked_s = t_s
            self.causes = self._look(moved, q, error)

    def _look(
        self, moved: Mapping[str, float], q: FloatArray, error: FloatArray
    ) -> dict[int, str]:
        self._error = error = np.where(np.isfinite(error), error, self._error)
        robot = self._robot
        there = Robot(robot.document, robot.names, robot.armature, self._at)
        gravity, inertia = robot.gravity(q), np.diag(robot.inertia(q))
        weight = np.abs(there.gravity(q) - gravity)
        granted = np.where(np.isfinite(error), _ERRORS * error, _WEIGHT * np.abs(gravity))
        touched = weight > granted
        touched |= np.abs(np.diag(there.inertia(q)) - inertia) > _INERTIA * inertia
        name = max(moved, key=lambda name: abs(moved[name] - robot.held[name]))
        said = (
            f'joint {name} is at {moved[name]:.4g} and the model holds it at '
            f'{robot.held[name]:.4g}: if it moves, name it under joints of model.yaml, or in '
            'parameter joints; if it stands there, under locked'
        )
        return dict.fromkeys(np.flatnonzero(touched).tolist(), said)
