# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The numbers of a rigid-body model that compiled code computes its terms from."""

from collections.abc import Sequence

import numpy as np
import pinocchio

from sosml_friction.arrays import FloatArray


def rigid_constants(
    model: pinocchio.Model,
    leaders: Sequence[int],
    ratios: Sequence[float],
    offsets: Sequence[float],
) -> FloatArray:
    """
    Return a tree of joints that turn or slide, (m + 1, 55): a row for the base and for each joint.

    The base's begins with the acceleration of gravity. That of a joint, with R and r the placement
    of it in its parent's, a its axis of turning and l that of sliding: the matrices A, B, C (9
    each) of the turned placement A + cos(angle) B + sin(angle) C; r; R l; a; in the joint's frame
    the mass, the mass times its centre (3) and the inertia about the origin (9); the rotor's;
    ratio and offset of its position to that of the modelled joint that leads it; the row of its
    parent; the number of its leader; an effort [Nm or N] that is added to gravity's.

    :param model: of Pinocchio, all its joints with one degree of freedom.
    :param leaders: the modelled joint that each of the model's follows, or is.
    :param ratios: of its position to that of its leader; 1 for the leader.
    :param offsets: [rad or m].
    """
    tree = np.zeros((model.nv + 1, 55))
    tree[0, :3] = model.gravity.linear
    for k, row in enumerate(tree[1:]):
        joint = model.joints[k + 1]
        data = joint.createData()
        joint.calc(data, np.zeros(1), np.zeros(1))
        twist = np.asarray(data.S, dtype=float).reshape(6)
        slide, axis = twist[:3], twist[3:]
        placement, body = model.jointPlacements[k + 1], model.inertias[k + 1]
        R = np.asarray(placement.rotation)
        row[0:9] = R.ravel()
        # Rodrigues' formula; a joint that slides keeps A = R alone.
        if axis.any():
            along = np.outer(axis, axis)
            parts = [R @ along, R @ (np.eye(3) - along), R @ pinocchio.skew(axis)]
            row[0:27] = np.ravel(parts)
        row[27:30], row[30:33], row[33:36] = placement.translation, R @ slide, axis
        # Of no mass at all the centre is nowhere.
        if body.mass:
            c = np.asarray(body.lever)
            row[36], row[37:40] = body.mass, body.mass * c
            row[40:49] = (body.mass * (c @ c * np.eye(3) - np.outer(c, c))).ravel()
        row[40:49] += np.asarray(body.inertia).ravel()
        row[49:54] = model.armature[k], ratios[k], offsets[k], model.parents[k + 1], leaders[k]
    return tree


def mistaken(tree: FloatArray, inertia_scale: float, effort: FloatArray) -> FloatArray:
    """
    Return the constants of s M, s C and g + d.

    :param tree: of :func:`rigid_constants`, of an arm in which no joint follows another.
    :param inertia_scale: s > 0.
    :param effort: d (n,) [Nm or N].
    """
    wrong = tree.copy()
    wrong[1:, 36:50] *= inertia_scale
    wrong[0, :3] /= inertia_scale
    wrong[1:, 54] += effort[tree[1:, 53].astype(int)]
    return wrong
