# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A rigid-body model that is wrong in a known way."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.rigid_constants import mistaken
from sosml_friction.model.robot import Robot


class MismatchedRobot(Robot):
    """
    Believe in the inertia s M (and so in s C) and in the gravity g + d of an arm that has M and g.

    Its momentum is s p and its drift s C^T q' - g - d. The arm itself obeys
    p' = tau + C^T q' - g + tau_e, so the disturbance that an observer with this model sees, before
    its own lag, is ::

        (s p)' - (tau + s C^T q' - g - d) = tau_e + (s - 1) (p' - C^T q') + d
                                          = tau_e + d/dt(dM q') - dC^T q' + dg

    with dM = (s - 1) M, dC = (s - 1) C, dg = d. Because p' - C^T q' = M q'' + C q', the friction
    it reports is wrong by -(s - 1) (M q'' + C q') - d (:meth:`friction_error`), whatever its
    gains.

    :param inertia_scale: s > 0.
    :param gravity_offset: d per joint [Nm or N].
    """

    def __init__(
        self,
        urdf: str,
        joints: Sequence[str],
        armature: Sequence[float],
        inertia_scale: float,
        gravity_offset: Sequence[float],
    ) -> None:
        super().__init__(urdf, joints, armature)
        self.inertia_scale = float(inertia_scale)
        self.gravity_offset = np.array(gravity_offset, dtype=float)

    def inertia(self, q: FloatArray) -> FloatArray:
        return self.inertia_scale * super().inertia(q)

    def coriolis(self, q: FloatArray, v: FloatArray) -> FloatArray:
        return self.inertia_scale * super().coriolis(q, v)

    def gravity(self, q: FloatArray) -> FloatArray:
        return super().gravity(q) + self.gravity_offset

    @property
    def constants(self) -> FloatArray:
        return mistaken(super().constants, self.inertia_scale, self.gravity_offset)

    def acceleration(self, q: FloatArray, v: FloatArray, tau: FloatArray) -> FloatArray:
        inertial = (tau - self.gravity(q)) / self.inertia_scale
        return super().acceleration(q, v, inertial + super().gravity(q))

    def inverse_dynamics(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        inertial = super().inverse_dynamics(q, v, a) - super().gravity(q)
        return self.inertia_scale * inertial + self.gravity(q)

    def energy(self, q: FloatArray, v: FloatArray) -> float:
        """Return s times the kinetic energy, plus the potential energy with that of d [J]."""
        potential = super().energy(q, np.zeros_like(v))
        kinetic = super().energy(q, v) - potential
        return self.inertia_scale * kinetic + potential + float(self.gravity_offset @ q)

    def friction_error(self, q: FloatArray, tau: FloatArray, friction: FloatArray) -> FloatArray:
        """
        Return what an ideal observer with this model reports minus the true tau_f, (N, n).

        -(s - 1) (M q'' + C q') - d, where M q'' + C q' = tau - tau_f - g by the true arm.
        """
        g = np.array([super(MismatchedRobot, self).gravity(x) for x in q])
        return -(self.inertia_scale - 1.0) * (tau - friction - g) - self.gravity_offset
