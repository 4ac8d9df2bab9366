# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The effort of each joint per unit of each body's ten numbers, compiled, along a motion.

With w, w' and a the body's rates and the acceleration of its joint's origin less gravity, all in
the joint's axes, a body of mass m, first moment c and inertia I about that origin needs ::

    force = m a + w' x c + w x (w x c),    moment = c x a + I w' + w x I w

and joint i, of the screw S_i, carries S_i . (moment, force) of all bodies beyond it.
"""

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.compiled import compiled
from sosml_friction.model.rigid_terms import place, work_space


@compiled
def rigid_regressor(
    tree: FloatArray, bodies: IndexArray, q: FloatArray, v: FloatArray, a: FloatArray
) -> FloatArray:
    """
    Return Y (N, n, 10 n) with M q'' + C q' + g = Y pi, without rotors.

    :param tree: (m + 1, ...) of :func:`~sosml_friction.model.rigid_constants.rigid_constants`.
    :param bodies: row of the tree of each of the n joints.
    :param q: position (N, n) [rad or m]; v, a: its derivatives.
    """
    count, n = q.shape
    rows = len(tree)
    result = np.zeros((count, n, 10 * n))
    work = work_space(tree)
    work[0] = 0.0
    work[0, 0] = work[0, 4] = work[0, 8] = 1.0
    # Of each body: rates' change, and acceleration of its point at the base's origin.
    spins, pulls = np.zeros((rows, 3)), np.zeros((rows, 3))
    pulls[0] = -tree[0, :3]
    # In the joint's axes: rates, their change, acceleration of its origin; I w of one number.
    turn, spin, pull, unit = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    force, moment, wrench, x = np.zeros(3), np.zeros(3), np.zeros(6), np.zeros(3)
    for t in range(count):
        for j in range(1, rows):
            w, parent, leader = work[j], int(tree[j, 52]), int(tree[j, 53])
            place(tree[j], work[parent], w, q[t, leader], v[t, leader])
            speed, gain = tree[j, 50] * v[t, leader], tree[j, 50] * a[t, leader]
            for k in range(3):
                spins[j, k] = spins[parent, k] + gain * w[12 + k]
                pulls[j, k] = pulls[parent, k] + gain * w[15 + k]
            # The screw turns with the body.
            _add_cross(speed, w[18:21], w[12:15], spins[j])
            _add_cross(speed, w[18:21], w[15:18], pulls[j])
            _add_cross(speed, w[21:24], w[12:15], pulls[j])
        for b in range(n):
            j = bodies[b]
            w = work[j]
            R, origin = w[:9].reshape(3, 3), w[9:12]
            x[:] = w[21:24]
            _add_cross(1.0, w[18:21], origin, x)
            wrench[:3] = pulls[j]
            _add_cross(1.0, spins[j], origin, wrench[:3])
            _add_cross(1.0, w[18:21], x, wrench[:3])
            _turn(R.T, w[18:21], turn)
            _turn(R.T, spins[j], spin)
            _turn(R.T, wrench[:3], pull)
            for number in range(10):
                unit[:], force[:], moment[:] = 0.0, 0.0, 0.0
                if number == 0:
                    force[:] = pull
                elif number < 4:
                    unit[number - 1] = 1.0
                    _add_cross(1.0, spin, unit, force)
                    x[:] = 0.0
                    _add_cross(1.0, turn, unit, x)
                    _add_cross(1.0, turn, x, force)
                    _add_cross(1.0, unit, pull, moment)
                else:
                    # xx, xy, yy, xz, yz, zz.
                    high = 0 if number == 4 else 1 if number < 7 else 2
                    low = number - 4 - high * (high + 1) // 2
                    unit[low], moment[low] = turn[high], spin[high]
                    unit[high], moment[high] = turn[low], spin[low]
                    _add_cross(1.0, turn, unit, moment)
                _turn(R, moment, wrench[:3])
                _turn(R, force, wrench[3:])
                _add_cross(1.0, origin, wrench[3:], wrench[:3])
                i = j
                while i > 0:
                    effort = 0.0
                    for k in range(6):
                        effort += work[i, 12 + k] * wrench[k]
                    result[t, int(tree[i, 53]), 10 * b + number] += tree[i, 50] * effort
                    i = int(tree[i, 52])
    return result


@compiled
def _add_cross(size: float, x: FloatArray, y: FloatArray, to: FloatArray) -> None:
    to[0] += size * (x[1] * y[2] - x[2] * y[1])
    to[1] += size * (x[2] * y[0] - x[0] * y[2])
    to[2] += size * (x[0] * y[1] - x[1] * y[0])


@compiled
def _turn(R: FloatArray, x: FloatArray, to: FloatArray) -> None:
    for k in range(3):
        to[k] = R[k, 0] * x[0] + R[k, 1] * x[1] + R[k, 2] * x[2]
