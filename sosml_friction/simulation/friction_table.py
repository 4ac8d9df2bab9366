# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction of all joints, and the sums of a Runge-Kutta step, compiled."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sosml_friction.model.laws import FrictionLaw
from sosml_friction.model.terms.stribeck import fade

FloatArray = NDArray[np.float64]


#: Amplitudes and inner parameters of the terms that the compiled friction has, by column; the
#: rest of a row is the width of the sign.
_COLUMNS = (
    'coulomb', 'viscous', 'stribeck', 'bias', 'viscous_asymmetry', 'stribeck_asymmetry',
    'stribeck_velocity', 'exponent',
)  # fmt: skip
_fade = njit(cache=True)(fade)


def friction_table(laws: Sequence[FrictionLaw]) -> FloatArray | None:
    """Return the laws as rows of numbers, or None if one has a term that is not compiled."""
    rows = []
    for law in laws:
        values = {**law.definition.fixed, **law.parameters}
        if not set(values) <= set(_COLUMNS):
            return None
        row = [values.get(name, 0.0) for name in _COLUMNS[:6]]
        row += [values.get(name, 1.0) for name in _COLUMNS[6:]]
        rows.append([*row, law.smoothing_velocity])
    return np.array(rows, dtype=float).reshape(len(rows), len(_COLUMNS) + 1)


@njit(cache=True)
def table_torque(table: FloatArray, v: FloatArray) -> FloatArray:
    """Return tau_f (n,) [Nm or N] at ``v``: the sum of the laws' terms, row by row."""
    tau = np.empty(len(v))
    for i in range(len(v)):
        x, v0 = v[i], table[i, 8]
        sign = math.tanh(x / v0) if v0 > 0.0 else np.sign(x)
        faded = _fade(x, table[i, 6], table[i, 7])
        level = table[i, 0] + table[i, 2] * faded
        even = table[i, 4] * abs(x) + table[i, 5] * abs(sign) * faded
        tau[i] = level * sign + table[i, 1] * x + table[i, 3] + even
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
