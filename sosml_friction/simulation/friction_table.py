# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction of all joints, compiled."""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from sosml_friction.arrays import FloatArray
from sosml_friction.model.laws import FrictionLaw
from sosml_friction.model.terms.stribeck import fade

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
