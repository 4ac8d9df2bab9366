# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From reference to effort, for actuators that take torque."""

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.motion.reference import Reference


class JointController:
    """
    Compute tau = M(q_r) q_r'' + C q_r' + g(q_r) + kp (q_r - q) + kd (q_r' - q').

    The feed-forward is the nominal model's inverse dynamics at the reference; friction is not in
    it: it is what is to be found. Where q' is not known yet (NaN) its term is left out.

    :param kp: (n,) [Nm/rad or N/m]; not used for a joint whose actuator takes positions.
    :param kd: (n,) [Nm s/rad or N s/m].
    """

    def __init__(self, robot: Robot, kp: FloatArray, kd: FloatArray) -> None:
        self._robot = robot
        self._kp = np.array(kp, dtype=float)
        self._kd = np.array(kd, dtype=float)

    def effort(self, reference: Reference, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return tau (n,) [Nm or N] at the measured ``q`` and ``v``, before any limit."""
        tau = self._robot.inverse_dynamics(reference.q, reference.v, reference.a)
        damping = np.where(np.isnan(v), 0.0, reference.v - v)
        return tau + self._kp * (reference.q - q) + self._kd * damping
