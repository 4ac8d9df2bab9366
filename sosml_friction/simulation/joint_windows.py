# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One joint of a robot, driven by its measured effort in many windows."""

import numpy as np
from numba.extending import register_jitable

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.model.terms.kinds.fading_term import fade
from sosml_friction.simulation.integrator import runge_kutta_step

_fade = register_jitable(fade)


@register_jitable  # type: ignore[untyped-decorator]
def _acceleration(known: tuple[float, ...], t: float, q: float, v: float) -> float:
    C, B, bias, S, v_s, exponent, width, force, mass, mass_rate, other_rate = known
    friction = np.tanh(v / width) * (C + S * _fade(v, v_s, exponent)) + B * v + bias
    return float((force - friction - mass_rate * v - other_rate) / (mass + t * mass_rate))


@compiled
def simulate_joint_windows(
    theta: FloatArray,
    x0: FloatArray,
    v0: FloatArray,
    h: FloatArray,
    forcing: FloatArray,
    m: FloatArray,
    other: FloatArray,
    exponent: float,
    width: float,
    steps: int,
) -> FloatArray:
    """
    Return the positions (W, L) [rad or m] of a joint in W windows of L samples.

        (m v + other)' = forcing - (C + S exp(-(|v| / v_s)^exponent)) tanh(v / width) - B v - bias,

    m and the momentum ``other`` of the moving joints beside it on lines between the samples.

    :param theta: C, B, bias, S and v_s.
    :param x0: where each window begins (W,), and v0: how fast (W,).
    :param h: time since the sample before (W, L) [s]; ``forcing`` (W, L) [Nm or N] over it.
    :param steps: of the integration in a sample.
    """
    C, B, bias, S, v_s = theta
    windows, count = h.shape
    x = np.empty((windows, count))
    for k in range(windows):
        here, speed = x0[k], v0[k]
        x[k, 0] = here
        for j in range(1, count):
            if h[k, j] > 0.0:
                m_rate = (m[k, j] - m[k, j - 1]) / h[k, j]
                other_rate = (other[k, j] - other[k, j - 1]) / h[k, j]
                step = h[k, j] / steps
                for s in range(steps):
                    mass = m[k, j - 1] + s * step * m_rate
                    known = (
                        C, B, bias, S, v_s, exponent, width, forcing[k, j], mass, m_rate,
                        other_rate,
                    )  # fmt: skip
                    here, speed = runge_kutta_step(_acceleration, known, here, speed, step)
            x[k, j] = here
    return x
