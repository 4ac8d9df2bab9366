# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid-body terms of a serial arm given as URDF, by Pinocchio."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio
from numpy.typing import NDArray

from sosml_friction.exceptions import ConfigurationError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class JointLimits:
    """Limits the URDF states: position [rad or m], velocity [rad/s or m/s], effort [Nm or N]."""

    lower: float
    upper: float
    velocity: float
    effort: float


class Robot:
    """
    Compute M, C^T q' - g and their relatives for joints in a given order.

    M(q) q'' + C(q, q') q' + g(q) = tau - tau_f, with C by Christoffel symbols, so that
    M' = C + C^T and p' = tau + C^T q' - g - tau_f for the momentum p = M q'. The reflected rotor
    inertia (armature) is on the diagonal of M. Not safe to share between threads: Pinocchio works
    in one buffer.

    :param urdf: the URDF document itself.
    :param joints: names of the joints to model, in the caller's order; the URDF's other movable
        joints are an error, because a load that is left out would pass for friction.
    :param armature: reflected inertia per joint [kg m2 or kg].
    :raises ConfigurationError: if the URDF cannot be read or its joints differ from ``joints``.
    """

    def __init__(self, urdf: str, joints: Sequence[str], armature: Sequence[float]) -> None:
        try:
            # ElementTree first: urdfdom writes lines of its own to stderr on what is not XML.
            self.robot_name = ElementTree.fromstring(urdf).get('name', '')
            model = pinocchio.buildModelFromXML(urdf)
        except (ValueError, RuntimeError, ElementTree.ParseError) as error:
            reason = (
                str(error).strip().splitlines()[0] if str(error).strip() else 'no reason given'
            )
            raise ConfigurationError(f'the URDF cannot be read: {reason}') from error
        movable = [name for name in model.names if name != 'universe']
        if sorted(movable) != sorted(joints):
            raise ConfigurationError(
                f'the URDF moves the joints {", ".join(movable) or "none"} where the model names '
                f'{", ".join(joints)}: make them the same'
            )
        if len(armature) != len(joints) or not all(0.0 <= a < np.inf for a in armature):
            raise ConfigurationError(
                f'armature is {list(armature)} for joints {", ".join(joints)}: give each joint a '
                'reflected rotor inertia >= 0'
            )
        ids = [model.getJointId(name) for name in joints]
        if any(model.joints[i].nq != 1 for i in ids):
            raise ConfigurationError(
                'a continuous or multi-degree joint is in the URDF: give it type revolute or '
                'prismatic with limits'
            )
        self.names = tuple(joints)
        self.document = urdf
        self.armature = tuple(float(a) for a in armature)
        self._order = np.array([model.joints[i].idx_v for i in ids])
        rotor = np.zeros(model.nv)
        rotor[self._order] = np.asarray(armature, dtype=float)
        model.armature = rotor
        self._model = model
        self._data = model.createData()
        self._identity = bool(np.array_equal(self._order, np.arange(model.nv)))
        self.effort_units = tuple(
            'N' if model.joints[i].shortname().startswith('JointModelP') else 'Nm' for i in ids
        )
        self.limits = tuple(
            JointLimits(
                float(model.lowerPositionLimit[i]),
                float(model.upperPositionLimit[i]),
                float(model.velocityLimit[i]),
                float(model.effortLimit[i]),
            )
            for i in self._order
        )

    @property
    def n(self) -> int:
        """Return the number of joints."""
        return len(self.names)

    def _in(self, x: FloatArray) -> FloatArray:
        if self._identity:
            return x
        y = np.empty(len(x))
        y[self._order] = x
        return y

    def inertia(self, q: FloatArray) -> FloatArray:
        """Return M(q), (n, n) [kg m2 or kg], armature included, a copy of its own."""
        M = pinocchio.crba(self._model, self._data, self._in(q))
        return np.array(M if self._identity else M[np.ix_(self._order, self._order)])

    def coriolis(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return C(q, q') by Christoffel symbols, (n, n)."""
        C = pinocchio.computeCoriolisMatrix(self._model, self._data, self._in(q), self._in(v))
        return np.array(C if self._identity else C[np.ix_(self._order, self._order)])

    def gravity(self, q: FloatArray) -> FloatArray:
        """Return g(q), (n,) [Nm or N]: the effort that holds the arm still."""
        g = pinocchio.computeGeneralizedGravity(self._model, self._data, self._in(q))
        return np.array(g[self._order])

    def momentum_terms(
        self, q: FloatArray, v: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Return p = M q' and C^T q' - g, each (n,), and M, (n, n), copies of their own.

        :param q: position (n,) [rad or m].
        :param v: velocity (n,) [rad/s or m/s].
        """
        q, v = self._in(q), self._in(v)
        model, data = self._model, self._data
        M = pinocchio.crba(model, data, q)
        p = M @ v
        C = pinocchio.computeCoriolisMatrix(model, data, q, v)
        drift = C.T @ v - pinocchio.computeGeneralizedGravity(model, data, q)
        if self._identity:
            return p, drift, np.array(M)
        return p[self._order], drift[self._order], M[np.ix_(self._order, self._order)]

    def acceleration(self, q: FloatArray, v: FloatArray, tau: FloatArray) -> FloatArray:
        """Return q'' under the net effort ``tau`` (actuator minus friction), (n,)."""
        a = pinocchio.aba(self._model, self._data, self._in(q), self._in(v), self._in(tau))
        return a if self._identity else np.array(a[self._order])

    def inverse_dynamics(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return M q'' + C q' + g, (n,) [Nm or N]."""
        tau = pinocchio.rnea(self._model, self._data, self._in(q), self._in(v), self._in(a))
        return np.array(tau[self._order])

    def torque_regressor(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """
        Return Y, (n, 10 n): M q'' + C q' + g = Y pi without rotors, linear in the inertias pi.

        pi holds ten numbers for the body of each joint, in the order of the joints
        (:meth:`inertial_parameters`).
        """
        Y = pinocchio.computeJointTorqueRegressor(
            self._model, self._data, self._in(q), self._in(v), self._in(a)
        )
        # For one joint Pinocchio's binding returns a vector.
        blocks = np.array(Y).reshape(self.n, self.n, 10)
        if self._identity:
            return blocks.reshape(self.n, 10 * self.n)
        return blocks[np.ix_(self._order, self._order)].reshape(self.n, 10 * self.n)

    def inertial_parameters(self) -> FloatArray:
        """
        Return (n, 10): m, m c (x, y, z), I (xx, xy, yy, xz, yz, zz) of the body of each joint.

        In the joint's frame, I about its origin [kg, kg m, kg m2]; bodies that are fixed to one
        another are one.
        """
        return np.array(
            [self._model.inertias[int(i) + 1].toDynamicParameters() for i in self._order]
        )

    def gravity_under(self, q: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Return g(q), (n,), were the acceleration of gravity ``acceleration`` (3,) [m/s2]."""
        kept = self._model.gravity.linear.copy()
        self._model.gravity.linear = np.asarray(acceleration, dtype=float)
        try:
            return self.gravity(q)
        finally:
            self._model.gravity.linear = kept

    def changed(self, inertias: FloatArray, armature: FloatArray, gravity: FloatArray) -> Robot:
        """
        Return the same arm with other bodies, for a simulation; its URDF is still the old one.

        Nothing is checked: an armature may be negative where M is positive definite all the same.

        :param inertias: (n, 10) as :meth:`inertial_parameters`.
        :param armature: reflected inertia (n,) [kg m2 or kg].
        :param gravity: acceleration of gravity in the base frame (3,) [m/s2].
        """
        other = copy.copy(self)
        model = self._model.copy()
        for i, row in zip(self._order, inertias, strict=True):
            model.inertias[int(i) + 1] = pinocchio.Inertia.FromDynamicParameters(row)
        rotor = np.zeros(model.nv)
        rotor[self._order] = armature
        model.armature = rotor
        model.gravity.linear = np.asarray(gravity, dtype=float)
        other.armature = tuple(float(a) for a in armature)
        other._model, other._data = model, model.createData()
        return other

    @property
    def gravity_acceleration(self) -> FloatArray:
        """Return the acceleration of gravity in the base frame, (3,) [m/s2]."""
        return np.array(self._model.gravity.linear)

    def energy(self, q: FloatArray, v: FloatArray) -> float:
        """Return kinetic (rotors included) plus potential energy [J]."""
        q, v = self._in(q), self._in(v)
        # Pinocchio 3 and 4 differ on whether its kinetic energy has the armature: M has it.
        kinetic = 0.5 * float(v @ pinocchio.crba(self._model, self._data, q) @ v)
        return kinetic + float(pinocchio.computePotentialEnergy(self._model, self._data, q))
