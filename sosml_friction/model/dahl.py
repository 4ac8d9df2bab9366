# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Dahl's state of friction: a sign of motion that sticks.

dz/dx = (1 - z sgn(dx)) / displacement, integrated exactly over each displacement: stable however
stiff, and it does not creep under a constant load as a smooth sign does.
"""

import math

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled


def dahl_step(z: FloatArray, dx: FloatArray, displacement: FloatArray | float) -> FloatArray:
    """
    Return z after a displacement ``dx``, same shape.

    :param displacement: over which z approaches the sign of motion, positive [rad or m].
    """
    target = np.sign(dx)
    return np.asarray(target + (z - target) * np.exp(-np.abs(dx) / displacement))


@compiled
def dahl_path(x: FloatArray, displacement: float) -> FloatArray:
    """
    Return z (N,), between -1 and 1, along a path x (N,) from z = 0.

    After a reversal it approaches the new sign over a few ``displacement``, at rest it stays, and
    how fast the path is run through does not matter.

    :param displacement: over which z approaches the sign of motion, positive [rad or m].
    """
    z = np.zeros(len(x))
    now = 0.0
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        if dx != 0.0:
            target = 1.0 if dx > 0.0 else -1.0
            now = target + (now - target) * math.exp(-abs(dx) / displacement)
        z[k] = now
    return z
