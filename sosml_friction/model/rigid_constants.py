# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The numbers of a rigid-body model that compiled code computes its terms from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio

from sosml_friction.arrays import FloatArray, IndexArray


class RigidConstants(NamedTuple):
    """
    Hold a tree of revolute and prismatic joints as arrays, a row for each joint that moves.

    :param bodies: (m, 52). With R and r the placement of the joint in its parent's, a its axis of
        turning and l that of sliding: the matrices A, B, C (9 each) of the turned placement
        A + cos(angle) B + sin(angle) C, r (3), R l (3), a (3), then in the joint's frame the mass,
        the mass times its centre (3) and the inertia about the origin (9), the rotor's, and ratio
        and offset of the joint's position to that of the modelled joint that leads it.
    :param links: (m, 2): the parent, counted from 1, where 0 is the base; the joint that leads.
    :param base: (3 + n,): the acceleration of gravity [m/s2], and an effort that is added to that
        of gravity [Nm or N].
    """

    bodies: FloatArray
    links: IndexArray
    base: FloatArray

    @classmethod
    def of(
        cls,
        model: pinocchio.Model,
        leaders: Sequence[int],
        ratios: Sequence[float],
        offsets: Sequence[float],
    ) -> RigidConstants:
        """
        Return those of a Pinocchio model whose joints all have one degree of freedom.

        :param leaders: the modelled joint that each of the model's follows, or is.
        :param ratios: of its position to that of its leader; 1 for the leader.
        :param offsets: [rad or m].
        """
        bodies = np.empty((model.nv, 52))
        links = np.empty((model.nv, 2), dtype=np.int64)
        for k, row in enumerate(bodies):
            joint = model.joints[k + 1]
            data = joint.createData()
            joint.calc(data, np.zeros(1), np.zeros(1))
            twist = np.asarray(data.S, dtype=float).reshape(6)
            slide, axis = twist[:3], twist[3:]
            placement, body = model.jointPlacements[k + 1], model.inertias[k + 1]
            R = np.asarray(placement.rotation)
            along = np.outer(axis, axis)
            # Rodrigues' formula; a joint that slides keeps A = R alone.
            turns = bool(axis.any())
            row[0:9] = (R @ along if turns else R).ravel()
            row[9:18] = (R @ (np.eye(3) - along)).ravel() if turns else 0.0
            row[18:27] = (R @ pinocchio.skew(axis)).ravel()
            row[27:30], row[30:33], row[33:36] = placement.translation, R @ slide, axis
            lever = np.asarray(body.lever)
            # Of no mass at all the centre is nowhere.
            row[36], row[37:40] = body.mass, body.mass * lever if body.mass else 0.0
            shift = np.zeros((3, 3))
            if body.mass:
                shift = body.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
            row[40:49] = (np.asarray(body.inertia) + shift).ravel()
            row[49:52] = model.armature[k], ratios[k], offsets[k]
            links[k] = model.parents[k + 1], leaders[k]
        gravity = np.asarray(model.gravity.linear, dtype=float)
        return cls(bodies, links, np.concatenate([gravity, np.zeros(max(leaders) + 1)]))

    def mistaken(self, inertia_scale: float, effort: FloatArray) -> RigidConstants:
        """
        Return those of s M, s C and g + d.

        :param inertia_scale: s > 0.
        :param effort: d (n,) [Nm or N].
        """
        bodies, base = self.bodies.copy(), self.base.copy()
        bodies[:, 36:50] *= inertia_scale
        base[:3] /= inertia_scale
        base[3:] += effort
        return RigidConstants(bodies, self.links, base)
