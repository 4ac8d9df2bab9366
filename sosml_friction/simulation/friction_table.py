# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction of all joints, and the sums of a Runge-Kutta step, compiled."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sosml_friction.model.coulomb_viscous import CoulombViscous
from sosml_friction.model.friction_law import FrictionLaw
from sosml_friction.model.stribeck import Stribeck

FloatArray = NDArray[np.float64]


def friction_table(laws: Sequence[FrictionLaw]) -> FloatArray | None:
    """
    Return the laws as rows (C, B, S, v_s, bias, v0), or None if one is neither (9) nor (17).

    A Coulomb-viscous row has S = 0.
    """
    rows = []
    for law in laws:
        p = law.parameters
        if type(law) is CoulombViscous:
            rows.append((p['coulomb'], p['viscous'], 0.0, 1.0, p['bias'], law.smoothing_velocity))
        elif type(law) is Stribeck:
            rows.append(
                (
                    p['coulomb'],
                    p['viscous'],
                    p['stribeck'],
                    p['stribeck_velocity'],
                    p['bias'],
                    law.smoothing_velocity,
                )
            )
        else:
            return None
    return np.array(rows, dtype=float).reshape(len(rows), 6)


@njit(cache=True)
def table_torque(table: FloatArray, v: FloatArray) -> FloatArray:
    """Return tau_f (n,) [Nm or N] at ``v``: the laws' own equations, row by row."""
    tau = np.empty(len(v))
    for i in range(len(v)):
        x = v[i]
        level = table[i, 0] + table[i, 2] * math.exp(-abs(x) / table[i, 3])
        v0 = table[i, 5]
        sign = math.tanh(x / v0) if v0 > 0.0 else np.sign(x)
        tau[i] = level * sign + table[i, 1] * x + table[i, 4]
    return tau


@njit(cache=True)
def rk4_stage(
    q: FloatArray,
    v: FloatArray,
    v_stage: FloatArray,
    a_stage: FloatArray,
    h: float,
    tau: FloatArray,
    table: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the next stage's q, v and net effort tau - tau_f(v), each (n,)."""
    n = len(q)
    q_next, v_next = np.empty(n), np.empty(n)
    for i in range(n):
        q_next[i] = q[i] + h * v_stage[i]
        v_next[i] = v[i] + h * a_stage[i]
    net = table_torque(table, v_next)
    for i in range(n):
        net[i] = tau[i] - net[i]
    return q_next, v_next, net


@njit(cache=True)
def rk4_sum(
    q: FloatArray,
    v: FloatArray,
    v2: FloatArray,
    v3: FloatArray,
    v4: FloatArray,
    a1: FloatArray,
    a2: FloatArray,
    a3: FloatArray,
    a4: FloatArray,
    h: float,
) -> tuple[FloatArray, FloatArray]:
    """Return q and v after the step, each (n,)."""
    n = len(q)
    q_next, v_next = np.empty(n), np.empty(n)
    for i in range(n):
        q_next[i] = q[i] + h / 6.0 * (v[i] + 2.0 * v2[i] + 2.0 * v3[i] + v4[i])
        v_next[i] = v[i] + h / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i])
    return q_next, v_next
