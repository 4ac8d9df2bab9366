# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The terms of p' = tau + C^T q' - g - tau_f, compiled, for any tree of joints.

C^T q' with Christoffel's C is the gradient of the kinetic energy by position, so no matrix C is
needed. A change of q_j turns all that joint j carries, of spatial momentum H_j, about its screw
S_j; relative to it, the twist V_j that it had is turned the other way, and ::

    (C^T q')_j = H_j . (V_j x S_j),    M_ij = S_i . (I_j S_j) for i on the way from the base to j

with I_j the inertia of all that joint j carries. Twists, momenta and inertias are those about the
base's origin and in its axes, where they add up without a transformation.
"""

import math

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled

#: Numbers of :func:`rigid_terms` for each joint: rotation, origin, screw (turning, sliding), twist
#: likewise, mass, mass times centre, inertia (xx, xy, xz, yy, yz, zz), angular momentum, linear.
WORK = 40


@compiled
def rigid_terms(
    tree: FloatArray,
    q: FloatArray,
    v: FloatArray,
    work: FloatArray,
    p: FloatArray,
    drift: FloatArray,
    M: FloatArray,
) -> None:
    """
    Write p = M q' (n,), C^T q' - g (n,) and M (n, n).

    :param tree: (m + 1, ...) of :func:`~sosml_friction.model.rigid_constants.rigid_constants`.
    :param q: position (n,) [rad or m].
    :param v: velocity (n,) [rad/s or m/s].
    :param work: (m + 1, WORK); anything.
    """
    rows, n = len(tree), len(q)
    root = work[0]
    root[:] = 0.0
    root[0] = root[4] = root[8] = 1.0
    for j in range(1, rows):
        leader = int(tree[j, 53])
        place(tree[j], work[int(tree[j, 52])], work[j], q[leader], v[leader])
    for i in range(n):
        drift[i] = 0.0
        for k in range(n):
            M[i, k] = 0.0
    gx, gy, gz = tree[0, 0], tree[0, 1], tree[0, 2]
    for j in range(rows - 1, 0, -1):
        w = work[j]
        ratio, parent, leader = tree[j, 50], int(tree[j, 52]), int(tree[j, 53])
        ax, ay, az, lx, ly, lz = w[12], w[13], w[14], w[15], w[16], w[17]
        ox, oy, oz, vx, vy, vz = w[18], w[19], w[20], w[21], w[22], w[23]
        mass, cx, cy, cz = w[24], w[25], w[26], w[27]
        # V_j x S_j, as (turning, sliding).
        tx, ty, tz = oy * az - oz * ay, oz * ax - ox * az, ox * ay - oy * ax
        sx = oy * lz - oz * ly + vy * az - vz * ay
        sy = oz * lx - ox * lz + vz * ax - vx * az
        sz = ox * ly - oy * lx + vx * ay - vy * ax
        change = tx * w[34] + ty * w[35] + tz * w[36] + sx * w[37] + sy * w[38] + sz * w[39]
        # The first moment of what joint j carries, per unit of q_j: its weight does the work.
        fx = mass * lx + ay * cz - az * cy
        fy = mass * ly + az * cx - ax * cz
        fz = mass * lz + ax * cy - ay * cx
        drift[leader] += ratio * (change + gx * fx + gy * fy + gz * fz) - tree[j, 54]
        nx = w[28] * ax + w[29] * ay + w[30] * az + cy * lz - cz * ly
        ny = w[29] * ax + w[31] * ay + w[32] * az + cz * lx - cx * lz
        nz = w[30] * ax + w[32] * ay + w[33] * az + cx * ly - cy * lx
        own = ax * nx + ay * ny + az * nz + lx * fx + ly * fy + lz * fz + tree[j, 49]
        M[leader, leader] += ratio * ratio * own
        if parent > 0:
            above = work[parent]
            for k in range(24, 40):
                above[k] += w[k]
        i = parent
        while i > 0:
            a = work[i]
            both = a[12] * nx + a[13] * ny + a[14] * nz + a[15] * fx + a[16] * fy + a[17] * fz
            both *= ratio * tree[i, 50]
            other = int(tree[i, 53])
            M[leader, other] += both
            M[other, leader] += both
            i = int(tree[i, 52])
    for i in range(n):
        total = 0.0
        for k in range(n):
            total += M[i, k] * v[k]
        p[i] = total


@compiled
def place(b: FloatArray, parent: FloatArray, w: FloatArray, q: float, v: float) -> None:
    """Write where a joint and its body are, how they move, and the body's inertia and momentum."""
    angle, rate = b[50] * q + b[51], b[50] * v
    c, s = math.cos(angle), math.sin(angle)
    for i in range(3):
        x, y, z = parent[3 * i], parent[3 * i + 1], parent[3 * i + 2]
        for k in range(3):
            w[3 * i + k] = (
                x * (b[k] + c * b[9 + k] + s * b[18 + k])
                + y * (b[3 + k] + c * b[12 + k] + s * b[21 + k])
                + z * (b[6 + k] + c * b[15 + k] + s * b[24 + k])
            )
        w[15 + i] = x * b[30] + y * b[31] + z * b[32]
        w[9 + i] = parent[9 + i] + x * b[27] + y * b[28] + z * b[29] + angle * w[15 + i]
        w[12 + i] = w[3 * i] * b[33] + w[3 * i + 1] * b[34] + w[3 * i + 2] * b[35]
        w[25 + i] = w[3 * i] * b[37] + w[3 * i + 1] * b[38] + w[3 * i + 2] * b[39]
    x, y, z = w[9], w[10], w[11]
    # The screw about the base's origin, and the twist.
    w[15] += y * w[14] - z * w[13]
    w[16] += z * w[12] - x * w[14]
    w[17] += x * w[13] - y * w[12]
    for i in range(6):
        w[18 + i] = parent[18 + i] + rate * w[12 + i]
    # The inertia in the base's axes, and from the joint's origin to the base's.
    mass, cx, cy, cz = b[36], w[25], w[26], w[27]
    both = 2.0 * (x * cx + y * cy + z * cz) + mass * (x * x + y * y + z * z)
    k = 28
    for i in range(3):
        t0 = w[3 * i] * b[40] + w[3 * i + 1] * b[43] + w[3 * i + 2] * b[46]
        t1 = w[3 * i] * b[41] + w[3 * i + 1] * b[44] + w[3 * i + 2] * b[47]
        t2 = w[3 * i] * b[42] + w[3 * i + 1] * b[45] + w[3 * i + 2] * b[48]
        for j in range(i, 3):
            turned = t0 * w[3 * j] + t1 * w[3 * j + 1] + t2 * w[3 * j + 2]
            here, there = w[9 + i], w[9 + j]
            w[k] = turned - here * w[25 + j] - there * w[25 + i] - mass * here * there
            if i == j:
                w[k] += both
            k += 1
    w[24] = mass
    w[25], w[26], w[27] = cx, cy, cz = cx + mass * x, cy + mass * y, cz + mass * z
    ox, oy, oz, vx, vy, vz = w[18], w[19], w[20], w[21], w[22], w[23]
    w[34] = w[28] * ox + w[29] * oy + w[30] * oz + cy * vz - cz * vy
    w[35] = w[29] * ox + w[31] * oy + w[32] * oz + cz * vx - cx * vz
    w[36] = w[30] * ox + w[32] * oy + w[33] * oz + cx * vy - cy * vx
    w[37] = mass * vx + oy * cz - oz * cy
    w[38] = mass * vy + oz * cx - ox * cz
    w[39] = mass * vz + ox * cy - oy * cx


@compiled
def rigid_statics(tree: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return M (N, n, n) and g (N, n) along positions (N, n), of the ``tree`` above."""
    count, n = q.shape
    M, g = np.empty((count, n, n)), np.empty((count, n))
    work, still, p = work_space(tree), np.zeros(n), np.empty(n)
    for k in range(count):
        rigid_terms(tree, q[k], still, work, p, g[k], M[k])
    return M, -g


@compiled
def work_space(tree: FloatArray) -> FloatArray:
    """Return the ``work`` of :func:`rigid_terms`."""
    return np.empty((len(tree), WORK))
