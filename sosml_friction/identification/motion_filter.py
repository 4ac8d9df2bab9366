# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A Kalman filter over position, velocity and friction, and its way back, compiled."""

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled


@compiled
def smooth_motion(
    h: FloatArray,
    q: FloatArray,
    mobility: FloatArray,
    drive: FloatArray,
    slope: FloatArray,
    white: FloatArray,
    friction: FloatArray,
    kept: FloatArray,
    position: FloatArray,
    slow: FloatArray,
    free: BoolArray,
    counted: BoolArray,
    velocity: FloatArray,
    back: bool,
) -> tuple[FloatArray, FloatArray, float]:
    """
    Filter (q, v, d) forwards and, if ``back``, go back; return v, its variance, log likelihood.

    M v' = drive - slope v - d, with drive and d as they are over an interval; q by the trapezoid;
    d keeps the part ``kept`` of itself. Each position is measured. Where friction is ``free``, so
    is the velocity: the ``slow`` one, that of the position. Back by Bryson and Frazier's
    recursion, which inverts nothing.

    :param h: of the intervals (N,) [s]; ``mobility`` (N, n, n) the inverse of M; ``drive``,
        ``slope`` (N, n); ``white`` (N, n) variance of the drive; ``kept`` (N,).
    :param friction: variance of d (n,); ``velocity``: of what is measured (n,).
    :param q: (N + 1, n), as are its variance ``position``, ``slow``, ``free`` and ``counted``,
        which innovations of a position count in the likelihood.
    """
    count, n = q.shape
    m = 3 * n
    x, P = np.zeros(m), np.zeros((m, m))
    for i in range(n):
        x[i], x[n + i] = q[0, i], slow[0, i]
        P[i, i], P[n + i, n + i] = position[0, i], velocity[i]
        P[2 * n + i, 2 * n + i] = friction[i]
    stored = count if back else 1
    # Filtered states, transitions, and per measurement gain, innovation and its variance.
    states, spreads = np.zeros((stored, m)), np.zeros((stored, m, m))
    steps, gains = np.zeros((stored, m, m)), np.zeros((stored, 2 * n, m))
    errors, variances = np.zeros((stored, 2 * n)), np.zeros((stored, 2 * n))
    if back:
        states[0], spreads[0] = x, P
    A, AP, K, moved = np.zeros((m, m)), np.zeros((m, m)), np.zeros(m), np.zeros(m)
    X, work, F, G = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    likelihood = 0.0
    for k in range(1, count):
        _transition(h[k - 1], mobility[k - 1], slope[k - 1], kept[k - 1], X, work, F, G, A)
        # x becomes A x + b and P becomes A P A^T + Q, with the drive and its noise in b and Q.
        _turn(A, x, P, moved, AP)
        half = 0.5 * h[k - 1]
        for i in range(n):
            for j in range(n):
                pushed = G[i, j] * drive[k - 1, j]
                x[n + i] += pushed
                x[i] += half * pushed
                noise = 0.0
                for c in range(n):
                    noise += G[i, c] * white[k - 1, c] * G[j, c]
                P[n + i, n + j] += noise
                P[i, n + j] += half * noise
                P[n + j, i] += half * noise
                P[i, j] += half * half * noise
            P[2 * n + i, 2 * n + i] += friction[i] * (1.0 - kept[k - 1] ** 2)
        if back:
            steps[k] = A
        for j in range(2 * n):
            i = j % n
            if j >= n and not free[k, i]:
                continue
            measured, own = (q[k, i], position[k, i]) if j < n else (slow[k, i], velocity[i])
            error, variance = measured - x[j], P[j, j] + own
            for a in range(m):
                K[a] = P[a, j] / variance
            for a in range(m):
                x[a] += K[a] * error
            for a in range(m):
                for b in range(a, m):
                    P[a, b] -= K[a] * K[b] * variance
                    P[b, a] = P[a, b]
            if j < n and counted[k, i]:
                likelihood -= 0.5 * (error * error / variance + np.log(variance))
            if back:
                gains[k, j], errors[k, j], variances[k, j] = K, error, variance
        if back:
            states[k], spreads[k] = x, P
    v, spread = np.zeros((stored, n)), np.zeros((stored, n))
    # What is measured later says of the state: states - P first, P - P second P.
    first, second, SK = np.zeros(m), np.zeros((m, m)), np.zeros(m)
    for k in range(stored - 1, -1, -1):
        for i in range(n):
            a = n + i
            row = spreads[k, a]
            v[k, i], spread[k, i] = states[k, a], row[a]
            for b in range(m):
                v[k, i] -= row[b] * first[b]
                for c in range(m):
                    spread[k, i] -= row[b] * second[b, c] * row[c]
        if k == 0:
            break
        for j in range(2 * n - 1, -1, -1):
            if variances[k, j] == 0.0:
                continue
            K[:] = gains[k, j]
            along, twice = 0.0, 0.0
            for a in range(m):
                along += K[a] * first[a]
                SK[a] = 0.0
                for b in range(m):
                    SK[a] += second[a, b] * K[b]
            for a in range(m):
                twice += K[a] * SK[a]
            first[j] -= along + errors[k, j] / variances[k, j]
            for a in range(m):
                second[a, j] -= SK[a]
                second[j, a] -= SK[a]
            second[j, j] += twice + 1.0 / variances[k, j]
        _turn(steps[k].T, first, second, moved, AP)
    return v, spread, likelihood


@compiled
def _transition(
    h: float,
    mobility: FloatArray,
    slope: FloatArray,
    kept: float,
    X: FloatArray,
    work: FloatArray,
    F: FloatArray,
    G: FloatArray,
    A: FloatArray,
) -> None:
    """Write the transition A, exp(-X) = F and the gain G of the drive over one interval."""
    n = len(slope)
    for i in range(n):
        for j in range(n):
            X[i, j] = h * mobility[i, j] * slope[j]
    # exp(-X) and its mean over the step: Pade's (0, 2), which does not ring where X is large.
    for i in range(n):
        for j in range(n):
            work[i, j] = X[i, j] + (1.0 if i == j else 0.0)
            F[i, j] = 1.0 if i == j else 0.0
            G[i, j] = mobility[i, j]
            for c in range(n):
                work[i, j] += 0.5 * X[i, c] * X[c, j]
                G[i, j] += 0.5 * X[i, c] * mobility[c, j]
            G[i, j] *= h
    _solve_both(work, F, G)
    for i in range(n):
        for j in range(n):
            A[n + i, n + j], A[n + i, 2 * n + j] = F[i, j], -G[i, j]
            A[i, n + j], A[i, 2 * n + j] = 0.5 * h * F[i, j], -0.5 * h * G[i, j]
        A[i, i] = 1.0
        A[i, n + i] += 0.5 * h
        A[2 * n + i, 2 * n + i] = kept


@compiled
def _solve_both(M: FloatArray, F: FloatArray, G: FloatArray) -> None:
    """Overwrite F and G with their solutions of M Y = F and M Y = G; M is lost."""
    n = len(M)
    for c in range(n):
        pivot = c
        for a in range(c + 1, n):
            if abs(M[a, c]) > abs(M[pivot, c]):
                pivot = a
        if pivot != c:
            for b in range(n):
                M[c, b], M[pivot, b] = M[pivot, b], M[c, b]
                F[c, b], F[pivot, b] = F[pivot, b], F[c, b]
                G[c, b], G[pivot, b] = G[pivot, b], G[c, b]
        scale = 1.0 / M[c, c]
        for b in range(n):
            M[c, b] *= scale
            F[c, b] *= scale
            G[c, b] *= scale
        for a in range(n):
            factor = M[a, c]
            if a != c and factor != 0.0:
                for b in range(n):
                    M[a, b] -= factor * M[c, b]
                    F[a, b] -= factor * F[c, b]
                    G[a, b] -= factor * G[c, b]


@compiled
def _turn(
    A: FloatArray, x: FloatArray, P: FloatArray, moved: FloatArray, work: FloatArray
) -> None:
    """Overwrite x with A x and the symmetric P with A P A^T."""
    m = len(x)
    for a in range(m):
        moved[a] = 0.0
        for b in range(m):
            moved[a] += A[a, b] * x[b]
            work[a, b] = 0.0
            for c in range(m):
                work[a, b] += A[a, c] * P[c, b]
    for a in range(m):
        x[a] = moved[a]
        for b in range(a, m):
            P[a, b] = 0.0
            for c in range(m):
                P[a, b] += work[a, c] * A[b, c]
            P[b, a] = P[a, b]
