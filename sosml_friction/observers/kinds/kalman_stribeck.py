# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A Kalman observer whose state carries the Stribeck law: the jump at a reversal is expected."""

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.momentum_samples import Columns, MomentumSamples
from sosml_friction.observers.observer import Observer, Recipe
from sosml_friction.observers.search_space import SearchRange, SearchSpace

#: Knee and smoothing of the law that the recipe tells [rad/s or m/s]: friction levels off over
#: hundredths of a radian per second, and a knee told wrong by three costs little.
STRIBECK_VELOCITY, SMOOTHING_VELOCITY = 0.03, 0.005

#: Relative wander of the law's parameters [1/sqrt(s)]: one percent in a second.
_WANDER = 0.01
#: For how long an effort that nobody reports is taken to stay what it is [s].
_UNREPORTED = 0.01
#: Standard deviations by which no position is off what was predicted, unless something happened.
_IMPOSSIBLE = 20.0
#: Most pieces that a sampling interval is cut into. Chosen, no measurement.
_PIECES = 20
#: Speed, in multiples of v_s, above which the law counts as linear: exp(-5) = 0.7 % of the
#: Stribeck term is left there.
_KNEE = 5.0
_STATES = 7


@compiled
def _tail(c: float, z: float) -> float:
    """Return exp(c^2 / 2 - c z) Phi(z - c) without overflow."""
    x = (c - z) / math.sqrt(2.0)
    if x < 0.0:
        return 0.5 * math.exp(c * (0.5 * c - z)) * math.erfc(x)
    if x < 20.0:
        return 0.5 * math.exp(-0.5 * z * z) * math.exp(x * x) * math.erfc(x)
    # erfc by its asymptotic series, whose next term is 105 / (16 x^8) < 3e-10.
    y = 1.0 / (2.0 * x * x)
    series = 1.0 - y * (1.0 - y * (3.0 - 15.0 * y))
    return 0.5 * math.exp(-0.5 * z * z) * series / (x * math.sqrt(math.pi))


@compiled
def expected_law(v: float, s: float, v_s: float, phi: FloatArray, slope: FloatArray) -> None:
    """
    Write the means of sgn(x), x and sgn(x) exp(-|x| / v_s) for x ~ N(v, s^2), and their slopes.

    With z = v / s, c = s / v_s and the normal distribution Phi the means are erf(z / sqrt 2), v
    and e^(c^2/2) (e^(-v/v_s) Phi(z - c) - e^(v/v_s) Phi(-z - c)); slopes are with respect to v.

    :param s: standard deviation of the velocity, positive.
    :param phi: written, (3,).
    :param slope: written, (3,).
    """
    z, c = v / s, s / v_s
    peak = 2.0 * math.exp(-0.5 * z * z) / (math.sqrt(2.0 * math.pi) * s)
    right, left = _tail(c, z), _tail(c, -z)
    phi[0], slope[0] = math.erf(z / math.sqrt(2.0)), peak
    phi[1], slope[1] = v, 1.0
    phi[2], slope[2] = right - left, peak - (right + left) / v_s


@compiled
def _friction(
    x: FloatArray, P: FloatArray, v_s: float, v0: float, phi: FloatArray, slope: FloatArray
) -> float:
    """Return tau_f at the mean of one joint, and write the law's columns and slopes, (3,) each."""
    expected_law(x[1], math.sqrt(P[1, 1] + v0 * v0), v_s, phi, slope)
    return x[2] + x[3] + phi[0] * x[4] + phi[1] * x[5] + phi[2] * x[6]


@compiled
def _fresh(x: FloatArray, P: FloatArray, v: float, R: float, h: float, prior: FloatArray) -> None:
    x[:] = 0.0
    x[1] = v
    P[:] = 0.0
    P[0, 0] = R
    # The momentum came from differences of two positions at worst.
    P[1, 1] = 2.0 * R / (h * h)
    for c in range(2, _STATES):
        P[c, c] = prior[c - 2]


@compiled
def _advance_rows(
    P: FloatArray, row: FloatArray, h: float, g1: float, g2: float, decay: float, keep: float
) -> None:
    """Multiply P by the transition of :func:`_predict` from the left, in place."""
    for c in range(_STATES):
        w = 0.0
        for j in range(2, _STATES):
            w -= row[j - 2] * P[j, c]
        P[0, c] += h * g1 * P[1, c] + h * h * g2 * w
        P[1, c] = decay * P[1, c] + h * g1 * w
        P[2, c] *= keep


@compiled
def _predict(
    x: FloatArray,
    P: FloatArray,
    row: FloatArray,
    h: float,
    acceleration: float,
    stiffness: float,
    keep: float,
    noise: FloatArray,
) -> None:
    """
    Advance one joint's mean and covariance by one interval.

    The law's slope makes v decay at the rate ``stiffness``, which is as fast as the sampling near
    standstill: the exponential of the linearised system is used, which is stable for any of it.

    :param row: -dv'/d(state) of the states from the third on, (5,).
    :param keep: what is left of the residual after the interval.
    :param noise: process noise variance of the states, (7,).
    """
    z = h * stiffness
    if abs(z) < 1e-4:
        g1, g2 = 1.0 - 0.5 * z, 0.5 - z / 6.0
    else:
        g1 = -math.expm1(-z) / z
        g2 = (1.0 - g1) / z
    x[0] += h * x[1] + h * h * g2 * acceleration
    x[1] += h * g1 * acceleration
    x[2] *= keep
    decay = math.exp(-z)
    _advance_rows(P, row, h, g1, g2, decay, keep)
    _advance_rows(P.T, row, h, g1, g2, decay, keep)
    for c in range(_STATES):
        P[c, c] += noise[c]


@compiled
def _correct(x: FloatArray, P: FloatArray, R: float) -> None:
    """Take the measured position in: x[0] is the error of the predicted one."""
    S = P[0, 0] + R
    error = x[0]
    gain = P[:, 0] / S
    row = P[0].copy()
    for c in range(_STATES):
        x[c] -= gain[c] * error
        for d in range(c, _STATES):
            P[c, d] -= gain[c] * row[d]
            P[d, c] = P[c, d]


@compiled
def _recover(x: FloatArray, P: FloatArray, R: float, h: float, prior: FloatArray) -> None:
    """
    Go on from a position that the prediction cannot explain, in place.

    A glitch, a joint that was struck or an estimate that is lost: such a position tells where the
    joint is and nothing of its friction. The velocity is looked for anew, the law is kept.
    """
    law, covariance = x[3:].copy(), P[3:, 3:].copy()
    _fresh(x, P, x[1], R, h, prior)
    x[3:] = law
    P[3:, 3:] = covariance


@compiled
def _dissipate(x: FloatArray, P: FloatArray) -> None:
    """
    Move the state to where C, B and S are not negative: friction takes power and gives none.

    A law of the wrong sign holds or throws the velocity of the model, which then explains itself.
    Each sign is taken in as a measurement without noise would be, so that velocity and the other
    parameters follow (clipped alone, they contradict their covariance); P is left as it is. The
    second time is for those that the first has made negative, and what little is left then is cut.
    """
    for _ in range(2):
        for c in range(4, _STATES):
            if x[c] < 0.0 and P[c, c] > 0.0:
                x -= P[:, c] * (x[c] / P[c, c])
                x[c] = 0.0
    for c in range(4, _STATES):
        x[c] = max(x[c], 0.0)


@compiled
def _pieces(v: FloatArray, v_next: FloatArray, v_s: FloatArray, v0: FloatArray) -> int:
    """
    Return into how many pieces to cut an interval: no joint passes more than v0 near its knee.

    Friction that is taken at the beginning of an interval acts on a reversal too long, which at
    coarse sampling would be learned as a law that is not there.
    """
    count = 1.0
    for i in range(len(v)):
        beyond = min(abs(v[i]), abs(v_next[i])) > _KNEE * v_s[i]
        if v[i] * v_next[i] < 0.0 or not beyond:
            passed = abs(v_next[i] - v[i]) / v0[i]
            # Not max(): what is not a number counts for nothing.
            if passed > count:
                count = passed
    return math.ceil(min(count, float(_PIECES)))


@compiled
def _velocities(
    x: FloatArray,
    P: FloatArray,
    M_last: FloatArray,
    M: FloatArray,
    forcing: FloatArray,
    h: float,
    law: tuple[FloatArray, ...],
) -> FloatArray:
    """
    Return the velocities after h, (n,).

    :param law: v_s and v0, (n,) each; its columns and slopes at the beginning are written behind
        them, (n, 3) each.
    """
    v_s, v0, phi, slope = law
    n = len(forcing)
    v = x[:, 1].copy()
    system, momentum = M.copy(), M_last @ v
    for i in range(n):
        friction = _friction(x[i], P[i], v_s[i], v0[i], phi[i], slope[i])
        momentum[i] += h * (forcing[i] - friction)
        # A joint of unknown effort is taken to go on at its velocity; the others feel that.
        if not np.isfinite(forcing[i]):
            system[i] = 0.0
            system[i, i] = 1.0
            momentum[i] = v[i]
    # What has overflowed starts afresh at the end; solve would refuse it.
    v_next = np.full(n, np.nan)
    if np.isfinite(momentum).all():
        v_next[:] = np.linalg.solve(system, momentum)
    return v_next


@compiled
def _run(
    x: FloatArray,
    P: FloatArray,
    M_last: FloatArray,
    fresh: FloatArray,
    samples: Columns,
    settings: tuple[FloatArray, ...],
) -> FloatArray:
    h, _, integral, forcing, inertia = samples
    R, prior, time, v_s, v0 = settings
    N, n = integral.shape
    estimate = np.empty((N, n))
    phi, slope = np.zeros((n, 3)), np.zeros((n, 3))
    law = (v_s, v0, phi, slope)
    row, noise = np.zeros(5), np.zeros(_STATES)
    for k in range(N):
        M = inertia[k]
        if fresh[0] > 0.0:
            v_start = np.linalg.solve(M, M_last[0])
            for i in range(n):
                _fresh(x[i], P[i], v_start[i], R[i], h[k], prior[i])
            M_last[:] = M
            fresh[0] = 0.0
        dq = np.linalg.solve(0.5 * (M_last + M), integral[k])
        mobility = np.linalg.inv(M)
        v_next = _velocities(x, P, M_last, M, forcing[k], h[k], law)
        count = _pieces(x[:, 1], v_next, v_s, v0)
        T, growth = h[k] / count, (M - M_last) / count
        for _ in range(count):
            if count > 1:
                M_piece = M_last + growth
                v_next = _velocities(x, P, M_last, M_piece, forcing[k], T, law)
                M_last[:] = M_piece
            for i in range(n):
                m = mobility[i, i]
                acceleration = (v_next[i] - x[i, 1]) / T
                keep = math.exp(-T / time[i])
                noise[:] = 0.0
                noise[2] = prior[i, 0] * (1.0 - keep * keep)
                for c in range(1, 5):
                    noise[2 + c] = _WANDER**2 * T * prior[i, c]
                stiffness = 0.0
                if np.isfinite(forcing[k, i]):
                    row[0] = row[1] = m
                    for c in range(3):
                        row[2 + c] = m * phi[i, c]
                        stiffness += m * slope[i, c] * x[i, 4 + c]
                else:
                    row[:] = 0.0
                    noise[1] = (m * m) * prior[i, 2] * _UNREPORTED * T
                _predict(x[i], P[i], row, T, acceleration, stiffness, keep, noise)
        M_last[:] = M
        for i in range(n):
            x[i, 0] -= dq[i]
            if x[i, 0] * x[i, 0] <= _IMPOSSIBLE**2 * (P[i, 0, 0] + R[i]):
                _correct(x[i], P[i], R[i])
            else:
                _recover(x[i], P[i], R[i], h[k], prior[i])
            _dissipate(x[i], P[i])
            friction = _friction(x[i], P[i], v_s[i], v0[i], phi[i], slope[i])
            known = np.isfinite(forcing[k, i])
            estimate[k, i] = -friction if known and np.isfinite(friction) else np.nan
            if known and not np.isfinite(friction):
                _fresh(x[i], P[i], 0.0, R[i], h[k], prior[i])
    return estimate


class KalmanStribeck(Observer):
    """
    Estimate position, velocity and the law of friction itself, from positions and effort alone.

    Each joint's state is (q, v, r, b, C, B, S) and its friction ::

        tau_f = C E[sgn v] + B v + S E[sgn(v) exp(-|v| / v_s)] + b + r

    with C, B, S >= 0, which are learned while the joint moves, and a residual r (first-order
    Gauss-Markov) for what the law does not say. E is the mean over the velocity's own uncertainty
    and the smoothing v0 (statistical linearisation): near standstill the sign is not known, so the
    estimate goes over to the other side as fast as the velocity is known to, instead of
    integrating until it has followed the jump. What no law describes (contact, cogging) is left to
    r, which is a slower observer.

    M(q) couples the mean of all joints: M_k v_k = M_{k-1} v_{k-1} + h (tau + C^T q' - g - tau_f);
    covariances are kept joint by joint. The measured velocity enters through C^T q' only. A joint
    without effort has no estimate (NaN), its velocity is followed from its positions, and its law
    is kept for when the effort comes back.

    Do not fit S and v_s to this estimate: v_s is what the gain says.

    Gains: ``position_noise`` [rad] standard deviation of a position; ``friction`` [Nm] prior size
    of C and S; ``viscous`` [Nm s/rad] of B; ``residual`` [Nm] size of r, and of b, with
    ``residual_time`` [s] its correlation time; ``stribeck_velocity`` v_s and
    ``smoothing_velocity`` v0 [rad/s].
    """

    identifier = 'kalman_stribeck'
    label = 'Kalman+law'
    place = 11.0
    coupled = True
    causal = True
    carries_law = True
    gain_units: ClassVar[Mapping[str, str]] = {
        'position_noise': 'rad',
        'friction': 'Nm',
        'viscous': 'Nm s/rad',
        'residual': 'Nm',
        'residual_time': 's',
        'stribeck_velocity': 'rad/s',
        'smoothing_velocity': 'rad/s',
    }
    positive_gains: ClassVar[tuple[str, ...]] = (
        'position_noise',
        'residual_time',
        'stribeck_velocity',
        'smoothing_velocity',
    )
    _LAW: ClassVar[Mapping[str, SearchRange]] = {
        'residual': SearchRange(1e-3, 10.0),
        'residual_time': SearchRange(1e-3, 100.0),
        'friction': SearchRange(0.1, 10.0),
    }
    study: ClassVar[Mapping[str, SearchSpace]] = {
        'kalman_stribeck': SearchSpace(
            {
                **_LAW,
                'stribeck_velocity': SearchRange(0.01, 0.1),
                'smoothing_velocity': SearchRange(0.002, 0.02),
            },
            ('residual', 3.0),
            {'viscous': 1.0},
        ),
        # The same with a law whose knee is three times as wide as that of the plant.
        'kalman_stribeck_wrong_knee': SearchSpace(
            _LAW,
            ('residual', 3.0),
            {'viscous': 1.0, 'stribeck_velocity': 0.09, 'smoothing_velocity': 0.015},
            label='Kalman+wrong law',
            remark='believes in a Stribeck velocity three times too high',
        ),
    }

    def __init__(self, gains: Mapping[str, Sequence[float]]) -> None:
        super().__init__(gains)
        sizes = ('residual', 'residual', 'friction', 'viscous', 'friction')
        self._prior = np.stack([self.gains[name] for name in sizes], axis=1) ** 2
        self._x = np.full((self.n, _STATES), np.nan)
        self._P = np.full((self.n, _STATES, _STATES), np.nan)
        # Until the first interval brings M, its first row holds the momentum of the start.
        self._M = np.full((self.n, self.n), np.nan)
        self._fresh = np.ones(1)

    @classmethod
    def recipe(cls, conditions: Conditions) -> Recipe:
        """Return a friction of D / 2, and a tenth of it beside the law."""
        D = conditions.friction_jump
        return {
            'position_noise': conditions.position_noise,
            'friction': 0.5 * D,
            'viscous': 0.5 * D,
            'residual': 0.05 * D,
            'residual_time': conditions.reversal_time,
            'stribeck_velocity': STRIBECK_VELOCITY,
            'smoothing_velocity': SMOOTHING_VELOCITY,
        }

    def start(self, p: FloatArray) -> None:
        """Begin afresh at momentum ``p``, with a friction of zero that nothing is known about."""
        self._M[0] = p
        self._fresh[:] = 1.0

    def run(self, samples: MomentumSamples) -> FloatArray:
        settings = (
            self.gains['position_noise'] ** 2,
            self._prior,
            self.gains['residual_time'],
            self.gains['stribeck_velocity'],
            self.gains['smoothing_velocity'],
        )
        return _run(self._x, self._P, self._M, self._fresh, samples.columns, settings)

    def lag_filter(self, h: float, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return 1: friction that obeys the law is followed without lag."""
        return np.ones(1), np.ones(1)

    def velocity(self) -> FloatArray:
        """Return the velocity estimated last, (n,) [rad/s or m/s]."""
        return self._x[:, 1].copy()

    def law(self) -> dict[str, FloatArray]:
        """Return the learned parameters: coulomb, viscous, stribeck and bias, each (n,)."""
        names = {'coulomb': 4, 'viscous': 5, 'stribeck': 6, 'bias': 3}
        return {name: self._x[:, column].copy() for name, column in names.items()}
