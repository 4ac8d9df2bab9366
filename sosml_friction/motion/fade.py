# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An envelope that lets an oscillation come out of rest and go back to it."""

from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray


class Signal(NamedTuple):
    """Hold a function of time and its first two derivatives, arrays of one shape."""

    x: FloatArray
    rate: FloatArray
    curvature: FloatArray


def fade(t: FloatArray, duration: float, ramp_s: float) -> Signal:
    """
    Return an envelope (k, 1): from 0 to 1 within ``ramp_s``, 1, and back to 0 at the end.

    Each ramp is 10 u^3 - 15 u^4 + 6 u^5: what it multiplies begins and ends at zero position,
    velocity and acceleration, whatever its phase.
    """
    up = np.clip(t / ramp_s, 0.0, 1.0)[:, None]
    down = np.clip((duration - t) / ramp_s, 0.0, 1.0)[:, None]
    x = rate = curvature = np.zeros_like(up)
    for u, sign in ((up, 1.0), (down, -1.0)):
        x = x + u**3 * (10.0 + u * (6.0 * u - 15.0))
        rate = rate + sign * 30.0 * u**2 * (1.0 - u) ** 2 / ramp_s
        curvature = curvature + 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / ramp_s**2
    return Signal(x - 1.0, rate, curvature)


def product(a: Signal, b: Signal) -> Signal:
    """Return a b by the rule of Leibniz."""
    return Signal(
        a.x * b.x,
        a.rate * b.x + a.x * b.rate,
        a.curvature * b.x + 2.0 * a.rate * b.rate + a.x * b.curvature,
    )
