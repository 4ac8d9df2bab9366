# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where joints should be, and how a reference gets onto a new trajectory."""

from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray

#: In this time the reference moves from where it was onto a new trajectory [s].
BLEND = 0.5


class Reference(NamedTuple):
    """
    Hold position [rad or m], velocity [per s] and acceleration [per s^2].

    (n,) each at one time, (N, n) at several.
    """

    q: FloatArray
    v: FloatArray
    a: FloatArray


def blend(t: FloatArray | float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the share of the place held before, 1 to 0, and its two derivatives, (N,) each."""
    s = np.clip(t / BLEND, 0.0, 1.0)
    inside = (t >= 0.0) & (t < BLEND)
    return (
        1.0 - s * s * (3.0 - 2.0 * s),
        np.where(inside, -6.0 * s * (1.0 - s) / BLEND, 0.0),
        np.where(inside, -6.0 * (1.0 - 2.0 * s) / BLEND**2, 0.0),
    )
