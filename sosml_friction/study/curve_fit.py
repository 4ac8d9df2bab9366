# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The curve fit of the paper's study: the Stribeck law through an observer's raw output."""

import numpy as np
from scipy.optimize import lsq_linear, minimize_scalar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.laws import FrictionLaw, make_friction_law
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.stribeck import fade

#: Where v_s is searched [rad/s].
_LOWEST, _HIGHEST = 1e-3, 1.0


def fit_raw(v: FloatArray, tau_f: FloatArray, smoothing_velocity: float) -> FrictionLaw:
    """
    Fit tau_f = s(v) (C + S exp(-|v| / v_s)) + B v + bias by least squares, C, B, S >= 0.

    As in the paper every sample counts, lag and all: this shows what an observer does to the
    friction map. To identify friction, use :mod:`~.law_fit`, which
    allows for the lag. For a given v_s the law is linear; v_s is searched from 0.001 to 1 rad/s.

    :param v: true velocity (N,) [rad/s].
    :param tau_f: what the observer says (N,) [Nm].
    :param smoothing_velocity: v0 of the law [rad/s], known.
    """
    lowest = [0.0, 0.0, 0.0, -np.inf]
    sign = smooth_sign(v, smoothing_velocity)

    def solve(v_s: float) -> tuple[float, FloatArray]:
        X = np.column_stack([sign, v, sign * fade(v, v_s, 1.0), np.ones_like(v)])
        # The bounds need only the triangle, as the samples are many and the columns few.
        Q, R = np.linalg.qr(X)
        found = lsq_linear(R, Q.T @ tau_f, bounds=(lowest, np.inf), method='bvls')
        return float(np.sum((tau_f - X @ found.x) ** 2)), found.x

    grid = np.geomspace(_LOWEST, _HIGHEST, 40)
    best = int(np.argmin([solve(v_s)[0] for v_s in grid]))
    around = np.log(grid[[max(best - 1, 0), min(best + 1, len(grid) - 1)]])
    refined = minimize_scalar(
        lambda u: solve(float(np.exp(u)))[0],
        bounds=tuple(around),
        method='bounded',
        options={'xatol': 1e-8},
    )
    v_s = float(np.exp(refined.x))
    C, B, S, bias = (float(x) for x in solve(v_s)[1])
    return make_friction_law(
        'stribeck',
        {'coulomb': C, 'viscous': B, 'stribeck': S, 'stribeck_velocity': v_s, 'bias': bias},
        smoothing_velocity,
    )
