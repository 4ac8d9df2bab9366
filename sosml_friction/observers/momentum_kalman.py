# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The integrated-momentum Kalman filter of one joint, compiled: what the Kalman observers share.

State x = (X, p, tau_e): momentum p [Nm s], its integral X [Nm s2] and the disturbance tau_e [Nm],
a random walk of intensity q [Nm^2/s], with the forcing u held over an interval of length h ::

    X' = p,   p' = u + tau_e,   tau_e' = w,   E[w(t) w(s)] = q delta(t - s)

Measured is the sum of the increments of X, which come straight from positions: the noise of an
encoder is white in it, of variance R_i = sum_j M_ij^2 s_j^2 for positions of standard deviation
s_j, where in the differentiated momentum it is not. x[0] holds X minus that sum, so it stays of
the size of the noise however long a recording is.

The covariance P is kept as a full matrix of which both halves get the same number. Its first row
is multiplied by R / (P_00 + R) in an update, the others lose a Schur complement; neither can
become asymmetric.
"""

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.crossing import crossing_probability
from sosml_friction.observers.momentum_samples import Columns


@compiled
def measurement_variance(inertia_row: FloatArray, position_noise: FloatArray) -> float:
    """
    Return R_i = sum_j M_ij^2 s_j^2 [Nm^2 s^4], how encoder noise of all joints enters X_i.

    :param inertia_row: row i of M at that sample, (n,) [kg m2 or kg].
    :param position_noise: s_j, (n,) [rad or m].
    """
    variance = 0.0
    for j in range(len(position_noise)):
        entry = inertia_row[j] * position_noise[j]
        variance += entry * entry
    return variance


@compiled
def begin(x: FloatArray, P: FloatArray, p: float, R: float, h: float, q: float) -> None:
    """
    Write the state at a start, in place: momentum ``p`` as measured, tau_e zero.

    X is the measured one, variance R; ``p`` a difference of positions over h, variance 2 R / h^2;
    tau_e has the variance that its random walk gathers in one second.

    :param x: state (3,).
    :param P: its covariance (3, 3).
    :param h: length of the first interval [s].
    :param q: intensity of the random walk [Nm^2/s].
    """
    x[0] = 0.0
    x[1] = p
    x[2] = 0.0
    P[:, :] = 0.0
    P[0, 0] = R
    P[1, 1] = 2.0 * R / (h * h)
    P[2, 2] = q


@compiled
def predict(x: FloatArray, P: FloatArray, h: float, u: float, integral: float, q: float) -> None:
    """
    Advance state and covariance over one interval, in place, exactly for held u and white w.

    :param u: forcing [Nm].
    :param integral: measured increment of X over the interval [Nm s2].
    :param q: intensity of the random walk over this interval [Nm^2/s].
    """
    half = 0.5 * h * h
    force = u + x[2]
    x[0] += h * x[1] + half * force - integral
    x[1] += h * force

    # F P F^T, first F P by rows, then its product with F^T.
    a00 = P[0, 0] + h * P[0, 1] + half * P[0, 2]
    a01 = P[0, 1] + h * P[1, 1] + half * P[1, 2]
    a02 = P[0, 2] + h * P[1, 2] + half * P[2, 2]
    a11 = P[1, 1] + h * P[1, 2]
    a12 = P[1, 2] + h * P[2, 2]
    qh = q * h
    P[0, 0] = a00 + h * a01 + half * a02 + qh * half * half / 5.0
    P[0, 1] = a01 + h * a02 + qh * half * h / 4.0
    P[0, 2] = a02 + qh * half / 3.0
    P[1, 1] = a11 + h * a12 + qh * h * h / 3.0
    P[1, 2] = a12 + qh * h / 2.0
    P[2, 2] += qh
    P[1, 0] = P[0, 1]
    P[2, 0] = P[0, 2]
    P[2, 1] = P[1, 2]


@compiled
def update(x: FloatArray, P: FloatArray, R: float) -> tuple[float, float]:
    """
    Take the measurement that x[0] is zero, in place.

    :return: innovation [Nm s2] (measured minus predicted X) and its variance P_00 + R.
    """
    innovation = -x[0]
    S = P[0, 0] + R
    k0 = P[0, 0] / S
    k1 = P[0, 1] / S
    k2 = P[0, 2] / S
    x[0] += k0 * innovation
    x[1] += k1 * innovation
    x[2] += k2 * innovation
    P[1, 1] -= k1 * P[0, 1]
    P[1, 2] -= k1 * P[0, 2]
    P[2, 2] -= k2 * P[0, 2]
    # 1 - k0 without cancellation.
    rest = R / S
    P[0, 0] *= rest
    P[0, 1] *= rest
    P[0, 2] *= rest
    P[1, 0] = P[0, 1]
    P[2, 0] = P[0, 2]
    P[2, 1] = P[1, 2]
    return innovation, S


@compiled
def is_finite(x: FloatArray) -> bool:
    """Return whether a joint has an estimate; if not it has to start afresh."""
    return bool(np.isfinite(x[0]) and np.isfinite(x[1]) and np.isfinite(x[2]))


@compiled
def estimate_or_restart(x: FloatArray, begun: BoolArray, joint: int, p: float) -> float:
    """
    Return a joint's tau_e; NaN if its state is not finite, and it then begins afresh at ``p``.

    :param x: the joint's state (3,); its momentum is written where it begins afresh.
    :param begun: which joints have begun, (n,), written where this one begins afresh.
    """
    if is_finite(x):
        return float(x[2])
    begun[joint] = False
    x[1] = p
    return np.nan


@compiled
def run_filter(
    x: FloatArray,
    P: FloatArray,
    begun: BoolArray,
    samples: Columns,
    mobilities: FloatArray,
    gains: tuple[FloatArray, ...],
) -> FloatArray:
    """
    Advance the filters of all joints, in place, and return tau_e after each interval, (N, n).

    :param mobilities: M^-1 of each interval, (N, n, n); not looked at where no jump is expected.
    :param gains: position noise, disturbance rate and crossing jump, (n,) each: the last is the
        standard deviation of the change of friction where a joint's velocity changes its sign
        [Nm]; zero for a random walk alone.
    """
    h, p, integral, forcing, inertia = samples
    position_noise, disturbance_rate, crossing_jump = gains
    n = len(x)
    estimate = np.empty_like(p)
    crossing = np.zeros(n)
    for k in range(len(p)):
        for i in range(n):
            if not begun[i]:
                R = measurement_variance(inertia[k, i], position_noise)
                begin(
                    x[i], P[i], x[i, 1], R, h[k], disturbance_rate[i] ** 2 + crossing_jump[i] ** 2
                )
                begun[i] = True
        for i in range(n):
            if crossing_jump[i] > 0.0:
                crossing[i] = crossing_probability(x, P, mobilities[k, i], forcing[k], h[k])
        for i in range(n):
            R = measurement_variance(inertia[k, i], position_noise)
            q = disturbance_rate[i] ** 2 + crossing_jump[i] ** 2 * crossing[i] / h[k]
            predict(x[i], P[i], h[k], forcing[k, i], integral[k, i], q)
            update(x[i], P[i], R)
            estimate[k, i] = estimate_or_restart(x[i], begun, i, p[k, i])
    return estimate


def steady_lag_filter(R: float, h: float, q: float) -> tuple[FloatArray, FloatArray]:
    """
    Return b(z) / a(z) from a held disturbance to tau_e of the filter with its steady gain.

    With gains K (in units of h) and c = 1 - K_0 the filter is ::

        b = K_2 / 2 (1 + z^-1)
        a = (1 - z^-1)^2 (1 - c z^-1) + K_1 z^-1 (1 - z^-1) + K_2 / 2 (z^-1 + z^-2)

    and its gain at rest is one. The poles follow from R and q without a Riccati equation: the
    spectrum of the measurement is, with y = (1 - z)(1 - z^-1) and r = R / (q h^5), proportional to
    r y^3 + y^2 / 120 - y / 4 + 1, and its roots inside the unit circle are the poles. In terms of
    the symmetric polynomials e_i of 1 - pole: K_0 = e_1 - e_2 + e_3, K_1 = e_2 - 3/2 e_3,
    K_2 = e_3.

    :param R: variance of the measurement [Nm^2 s^4], positive.
    :param h: sampling interval [s].
    :param q: intensity of the random walk [Nm^2/s], positive.
    """
    ratio = R / (q * h**5)
    # y is of the size of ratio^(-1/3): scaled, the roots of the cubic are of the size of one.
    scale = max(ratio, 1.0) ** (-1.0 / 3.0)
    cubic = [ratio * scale**3, scale**2 / 120.0, -scale / 4.0, 1.0]
    y = scale * np.roots(cubic).astype(complex)
    # d = 1 - pole solves d^2 - y d + y = 0; the product of the roots is y, the pole inside the
    # unit circle has the smaller one.
    root = np.sqrt(y * y - 4.0 * y)
    larger = np.where(np.abs(y + root) > np.abs(y - root), y + root, y - root) / 2.0
    d = y / larger
    poles = 1.0 - d
    e3 = float(np.prod(d).real)
    return 0.5 * e3 * np.ones(2), np.atleast_1d(np.poly(poles).real)
