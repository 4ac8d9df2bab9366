# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The sign of motion as a state that keeps its value at rest."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@njit(cache=True)
def sign_state(q: FloatArray, displacement: float) -> FloatArray:
    """
    Return Dahl's state z, (N,), between -1 and 1, along a position.

        dz/dx = (1 - z sgn(dx)) / displacement,

    integrated exactly over each step of position, from z = 0: after a reversal it approaches the
    new sign over a few ``displacement``, at rest it stays, and how fast the joint moves does not
    matter.

    :param q: position (N,) [rad or m].
    :param displacement: [rad or m], positive.
    """
    z = np.empty(len(q))
    now = 0.0
    last = q[0]
    for k in range(len(q)):
        dx = q[k] - last
        last = q[k]
        if dx > 0.0:
            now = 1.0 - (1.0 - now) * math.exp(-dx / displacement)
        elif dx < 0.0:
            now = -1.0 + (1.0 + now) * math.exp(dx / displacement)
        z[k] = now
    return z
