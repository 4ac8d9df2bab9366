# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid-body terms of a serial arm given as URDF, by Pinocchio."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pinocchio

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.rigid_constants import rigid_constants
from sosml_friction.model.urdf_joints import JointLimits, Mimic, UrdfJoints, read_joints

__all__ = ['JointLimits', 'Robot']

_NOTHING = pinocchio.Inertia.Zero()

#: Rows whose regressors are made at a time: a few MB. A size of memory, not of the answer.
_ROWS = 4096


class Robot:
    """
    Compute M, C^T q' - g and their relatives for joints in a given order.

    M(q) q'' + C(q, q') q' + g(q) = tau - tau_f, with C by Christoffel symbols, so that
    M' = C + C^T and p' = tau + C^T q' - g - tau_f for the momentum p = M q'. The reflected rotor
    inertia (armature) is on the diagonal of M. Not safe to share between threads: Pinocchio works
    in one buffer.

    The URDF's other joints are held still, at ``locked`` or else at 0, and ``held`` says where
    each is; one that mimics a joint of ``joints`` follows it with its body (``followers``).
    ``remarks`` has a sentence on what is held though nobody said so: what such a joint carries
    when it moves all the same would pass for friction.

    :param urdf: the URDF document itself.
    :param joints: names of the joints to model, in the caller's order.
    :param armature: reflected inertia per joint [kg m2 or kg].
    :param locked: positions [rad or m] of joints that are held still.
    :raises ConfigurationError: if the URDF cannot be read or lacks one of the joints.
    """

    def __init__(
        self,
        urdf: str,
        joints: Sequence[str],
        armature: Sequence[float],
        locked: Mapping[str, float] | None = None,
    ) -> None:
        stated = read_joints(urdf)
        self.robot_name = stated.robot_name
        try:
            model = pinocchio.buildModelFromXML(stated.plain)
        except (ValueError, RuntimeError) as error:
            reason = (
                str(error).strip().splitlines()[0] if str(error).strip() else 'no reason given'
            )
            raise ConfigurationError(f'the URDF cannot be read: {reason}') from error
        _check_names(stated, joints, locked or {})
        if len(armature) != len(joints) or not all(0.0 <= a < np.inf for a in armature):
            raise ConfigurationError(
                f'armature is {list(armature)} for joints {", ".join(joints)}: give each joint a '
                'reflected rotor inertia >= 0'
            )
        self.names = tuple(joints)
        self.document = urdf
        self.armature = tuple(float(a) for a in armature)
        self.held, self.followers = _held_and_followers(stated, self.names, locked or {})
        self.remarks = _remarks(stated, self.held, locked or {})
        model = _reduced(model, self.held)
        ids = [model.getJointId(name) for name in joints]
        self._order = np.array([model.joints[i].idx_v for i in ids])
        rotor = np.zeros(model.nv)
        rotor[self._order] = np.asarray(armature, dtype=float)
        model.armature = rotor
        self._model = model
        self._data = model.createData()
        self._identity = bool(np.array_equal(self._order, np.arange(model.nv)))
        self._spread, self._offset = self._following()
        self._constants: FloatArray | None = None
        self._compiled: tuple[Callable[..., None], FloatArray, FloatArray] | None = None
        self.effort_units = tuple(
            'N' if stated.joints[n].kind == 'prismatic' else 'Nm' for n in joints
        )
        self.limits = tuple(stated.joints[name].limits for name in joints)

    @property
    def n(self) -> int:
        """Return the number of joints."""
        return len(self.names)

    def carriers(self, joint: int) -> tuple[int, ...]:
        """Return the joints between the base and a joint, which carry it."""
        names = set()
        for k in list(self._model.supports[self._model.getJointId(self.names[joint])])[1:-1]:
            name = self._model.names[k]
            names.add(self.followers[name].leader if name in self.followers else name)
        return tuple(i for i, name in enumerate(self.names) if name in names)

    @property
    def constants(self) -> FloatArray:
        """Return what compiled code computes :meth:`momentum_terms` from, rigid_constants."""
        if self._constants is None:
            led = [self.followers.get(name, Mimic(name)) for name in list(self._model.names)[1:]]
            self._constants = rigid_constants(
                self._model,
                [self.names.index(mimic.leader) for mimic in led],
                [mimic.multiplier for mimic in led],
                [mimic.offset for mimic in led],
            )
        return self._constants

    def _following(self) -> tuple[FloatArray | None, FloatArray]:
        """Return G and h: the model's positions are G q + h; G is None where nothing follows."""
        nv = self._model.nv
        offset = np.zeros(nv)
        if not self.followers:
            return None, offset
        spread = np.zeros((nv, self.n))
        spread[self._order, np.arange(self.n)] = 1.0
        for name, mimic in self.followers.items():
            i = self._model.joints[self._model.getJointId(name)].idx_v
            spread[i, self.names.index(mimic.leader)] = mimic.multiplier
            offset[i] = mimic.offset
        return spread, offset

    def _in(self, x: FloatArray) -> FloatArray:
        """Return velocities or accelerations, or positions but for an offset, for Pinocchio."""
        if self._identity:
            return x
        if self._spread is not None:
            return np.asarray(self._spread @ x)
        y = np.empty(len(x))
        y[self._order] = x
        return y

    def _at(self, q: FloatArray) -> FloatArray:
        """Return positions for Pinocchio."""
        return self._in(q) if self._spread is None else self._in(q) + self._offset

    def _out(self, y: FloatArray) -> FloatArray:
        """Return efforts or momenta of Pinocchio's, a copy; what follows works on its leader."""
        if self._spread is not None:
            return np.asarray(self._spread.T @ y)
        return np.array(y[self._order])

    def _matrix(self, A: FloatArray) -> FloatArray:
        if self._spread is not None:
            return np.asarray(self._spread.T @ A @ self._spread)
        return np.array(A if self._identity else A[np.ix_(self._order, self._order)])

    def inertia(self, q: FloatArray) -> FloatArray:
        """Return M(q), (n, n) [kg m2 or kg], armature included, a copy of its own."""
        return self._matrix(pinocchio.crba(self._model, self._data, self._at(q)))

    def coriolis(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return C(q, q') by Christoffel symbols, (n, n)."""
        C = pinocchio.computeCoriolisMatrix(self._model, self._data, self._at(q), self._in(v))
        return self._matrix(C)

    def gravity(self, q: FloatArray) -> FloatArray:
        """Return g(q), (n,) [Nm or N]: the effort that holds the arm still."""
        return self._out(pinocchio.computeGeneralizedGravity(self._model, self._data, self._at(q)))

    def momentum_terms(
        self, q: FloatArray, v: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Return p = M q' and C^T q' - g, each (n,), and M, (n, n), copies of their own.

        :param q: position (n,) [rad or m].
        :param v: velocity (n,) [rad/s or m/s].
        """
        if self._compiled is None:
            # Numba is for those alone who come here.
            from sosml_friction.model.rigid_terms import rigid_terms, work_space

            tree = self.constants
            self._compiled = rigid_terms, tree, work_space(tree)
        terms, tree, work = self._compiled
        p, drift, M = np.empty(self.n), np.empty(self.n), np.empty((self.n, self.n))
        q, v = np.array(q, dtype=float), np.array(v, dtype=float)
        terms(tree, q, v, work, p, drift, M)
        return p, drift, M

    def acceleration(self, q: FloatArray, v: FloatArray, tau: FloatArray) -> FloatArray:
        """Return q'' under the net effort ``tau`` (actuator minus friction), (n,)."""
        if self._spread is not None:
            rest = self.inverse_dynamics(q, v, np.zeros(self.n))
            return np.asarray(np.linalg.solve(self.inertia(q), tau - rest))
        a = pinocchio.aba(self._model, self._data, self._at(q), self._in(v), self._in(tau))
        return a if self._identity else np.array(a[self._order])

    def inverse_dynamics(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return M q'' + C q' + g, (n,) [Nm or N]."""
        return self._out(
            pinocchio.rnea(self._model, self._data, self._at(q), self._in(v), self._in(a))
        )

    def torque_regressor(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """
        Return Y, (n, 10 n): M q'' + C q' + g = Y pi without rotors, linear in the inertias pi.

        pi holds ten numbers for the body of each joint, in the order of the joints
        (:meth:`inertial_parameters`). The bodies of ``followers`` are not in it: what they need
        is that of :meth:`inverse_dynamics` beside Y pi and the rotors.
        """
        Y = pinocchio.computeJointTorqueRegressor(
            self._model, self._data, self._at(q), self._in(v), self._in(a)
        )
        # For one joint Pinocchio's binding returns a vector.
        nv = self._model.nv
        blocks = np.array(Y).reshape(nv, nv, 10)
        if self._spread is not None:
            blocks = np.tensordot(self._spread.T, blocks[:, self._order], 1)
        elif not self._identity:
            blocks = blocks[np.ix_(self._order, self._order)]
        return blocks.reshape(self.n, 10 * self.n)

    def torque_regressors(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return :meth:`torque_regressor` along a motion (N, n), (N, n, 10 n), compiled."""
        # Numba is for those alone who come here.
        from sosml_friction.model.rigid_regressor import rigid_regressor

        q, v, a = (np.ascontiguousarray(x, dtype=float) for x in (q, v, a))
        return np.asarray(rigid_regressor(self.constants, self._order + 1, q, v, a))

    def inverse_dynamics_along(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return :meth:`inverse_dynamics` along a motion (N, n), compiled without followers."""
        result = np.empty(q.shape)
        bodies, rotors = self.inertial_parameters().ravel(), np.array(self.armature)
        for first in range(0, len(q), _ROWS):
            rows = slice(first, first + _ROWS)
            own = q[rows], v[rows], a[rows]
            if self.followers:
                # Their bodies are not in the regressor.
                result[rows] = [self.inverse_dynamics(*x) for x in zip(*own, strict=True)]
            else:
                result[rows] = self.torque_regressors(*own) @ bodies + rotors * own[2]
        return result

    def statics(
        self, q: FloatArray, gravity: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """
        Return :meth:`inertia` (N, n, n) and :meth:`gravity` (N, n) along positions, compiled.

        :param q: positions (N, n) [rad or m].
        :param gravity: another acceleration of gravity (3,) [m/s2].
        """
        # Numba is for those alone who come here.
        from sosml_friction.model.rigid_terms import rigid_statics

        tree = self.constants
        if gravity is not None:
            tree = tree.copy()
            tree[0, :3] = gravity
        M, g = rigid_statics(tree, np.ascontiguousarray(q, dtype=float))
        return M, g

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
            # Of no mass at all the centre is nowhere, and would be NaN.
            body = pinocchio.Inertia.FromDynamicParameters(row) if row.any() else _NOTHING
            model.inertias[int(i) + 1] = body
        rotor = np.zeros(model.nv)
        rotor[self._order] = armature
        model.armature = rotor
        model.gravity.linear = np.asarray(gravity, dtype=float)
        other.armature = tuple(float(a) for a in armature)
        other._model, other._data = model, model.createData()
        other._constants = other._compiled = None
        return other

    @property
    def gravity_acceleration(self) -> FloatArray:
        """Return the acceleration of gravity in the base frame, (3,) [m/s2]."""
        return np.array(self._model.gravity.linear)

    @property
    def longest_link(self) -> float:
        """Return the longest way from one joint to the next, 0 for one joint [m]."""
        places = list(self._model.jointPlacements)[2:]
        return max((float(np.linalg.norm(own.translation)) for own in places), default=0.0)

    @property
    def base_rotation(self) -> FloatArray:
        """Return how the first joint is turned in the base frame at 0, (3, 3)."""
        return np.array(self._model.jointPlacements[1].rotation)

    def energy(self, q: FloatArray, v: FloatArray) -> float:
        """Return kinetic (rotors included) plus potential energy [J]."""
        q, v = self._at(q), self._in(v)
        # Pinocchio 3 and 4 differ on whether its kinetic energy has the armature: M has it.
        kinetic = 0.5 * float(v @ pinocchio.crba(self._model, self._data, q) @ v)
        return kinetic + float(pinocchio.computePotentialEnergy(self._model, self._data, q))


def _check_names(stated: UrdfJoints, joints: Sequence[str], locked: Mapping[str, float]) -> None:
    movable = list(stated.joints)
    if len(set(joints)) != len(joints) or not set(joints) <= set(movable):
        raise ConfigurationError(
            f'the URDF moves the joints {", ".join(movable) or "none"} where the model names '
            f'{", ".join(joints)}: make them the same'
        )
    for name in joints:
        if not stated.joints[name].is_single:
            raise ConfigurationError(
                f'joint {name} of the URDF is of type {stated.joints[name].kind}: give it type '
                'revolute, continuous or prismatic, or leave it out of the model'
            )
    for name, position in locked.items():
        if name not in movable or name in joints:
            why = 'the model moves it' if name in joints else 'the URDF has no such joint'
            raise ConfigurationError(f'joint {name} cannot be locked: {why}')
        if not (stated.joints[name].is_single and np.isfinite(position)):
            raise ConfigurationError(
                f'joint {name} cannot be locked at {position}: that needs a number and a joint '
                'of type revolute, continuous or prismatic'
            )


def _held_and_followers(
    stated: UrdfJoints, joints: Sequence[str], locked: Mapping[str, float]
) -> tuple[dict[str, float], dict[str, Mimic]]:
    """Return where each joint that is not modelled is held, or what joint of them it follows."""
    held: dict[str, float] = {}
    followers: dict[str, Mimic] = {}
    for name, joint in stated.joints.items():
        if name in joints:
            continue
        leader, ratio, offset = name, 1.0, 0.0
        while leader not in joints and leader not in locked:
            mimic = stated.joints[leader].mimic
            if mimic is None:
                break
            leader, ratio, offset = (
                mimic.leader, ratio * mimic.multiplier, ratio * mimic.offset + offset,
            )  # fmt: skip
        if leader in joints and joint.is_single:
            followers[name] = Mimic(leader, ratio, offset)
        else:
            held[name] = ratio * float(locked.get(leader, 0.0)) + offset
    return held, followers


def _remarks(
    stated: UrdfJoints, held: Mapping[str, float], locked: Mapping[str, float]
) -> tuple[str, ...]:
    # Of a joint that follows one that is held, its leader tells.
    silent = [n for n in held if n not in locked and stated.joints[n].mimic is None]
    if not silent:
        return ()
    one = len(silent) == 1
    return (
        f'{"joint" if one else "joints"} {", ".join(silent)} of the URDF {"is" if one else "are"} '
        f'not in the model and held at 0: if {"it moves" if one else "they move"}, name '
        f'{"it" if one else "them"} under joints of model.yaml, or in parameter joints of a node; '
        f'if {"it stands" if one else "they stand"} elsewhere, under locked',
    )


def _reduced(model: pinocchio.Model, held: Mapping[str, float]) -> pinocchio.Model:
    """Return the model with joints held still."""
    if not held:
        return model
    q = pinocchio.neutral(model)
    ids = [model.getJointId(name) for name in held]
    for i, position in zip(ids, held.values(), strict=True):
        if model.joints[i].nq == 1:
            q[model.joints[i].idx_q] = position
    return pinocchio.buildReducedModel(model, ids, q)
