# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The chance that a joint's velocity has changed its sign, from what a Kalman observer knows.

Friction can only jump where its joint's velocity passes zero, and the filter itself says how well
it knows where that is. With mobility W = M^-1 the velocity of joint i is normally distributed
about v_i = sum_j W_ij p_j with variance s_i^2 = sum_j W_ij^2 P_j (the joints' filters are
independent), and an interval of length h with acceleration a_i = sum_j W_ij (u_j + tau_j) adds ::

    pi_i = |Phi((v_i + h a_i) / s_i) - Phi(v_i / s_i)|

to the chance of a change of sign: the integral of Rice's rate |v'| N(0; v, s^2) for a known
acceleration, which over one passage adds up to one. The uncertainty of the acceleration is left
out, because with it a joint that is held would cross without end.
"""

import math

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled


@compiled
def crossing_probability(
    x: FloatArray, P: FloatArray, mobility_row: FloatArray, forcing: FloatArray, h: float
) -> float:
    """
    Return pi_i for the joint whose row of W = M^-1 is given.

    A joint whose forcing is not known is taken to keep its momentum.

    :param x: states (X, p, tau_e) of all joints at the start of the interval, (n, 3).
    :param P: their covariances, (n, 3, 3).
    :param mobility_row: W_ij, (n,) [1/(kg m2) or 1/kg].
    :param forcing: u, (n,) [Nm or N].
    :param h: length of the interval [s].
    """
    velocity, change, variance = 0.0, 0.0, 0.0
    for j in range(len(mobility_row)):
        w = mobility_row[j]
        velocity += w * x[j, 1]
        variance += w * w * P[j, 1, 1]
        if np.isfinite(forcing[j]):
            change += h * w * (forcing[j] + x[j, 2])
    scale = math.sqrt(2.0 * variance)
    if not scale > 0.0:
        return 0.0
    chance = 0.5 * abs(math.erf((velocity + change) / scale) - math.erf(velocity / scale))
    # A wild sample of another joint must not become this joint's.
    return chance if np.isfinite(chance) else 0.0
