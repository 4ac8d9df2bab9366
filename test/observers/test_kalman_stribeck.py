# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The Kalman observer that carries the Stribeck law: its formulas, its accuracy, its limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import expm

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.kinds.kalman import Kalman
from sosml_friction.observers.kinds.kalman_stribeck import KalmanStribeck, _predict, expected_law
from sosml_friction.observers.kinds.linear_second_order import LinearSecondOrder
from sosml_friction.observers.momentum_samples import MomentumSamples


def make(noise, n=2, **changes):
    gains = {
        'position_noise': noise,
        'friction': 0.5,
        'viscous': 0.5,
        'residual': 0.1,
        'residual_time': 1.0,
        'stribeck_velocity': 0.03,
        'smoothing_velocity': 0.005,
        **changes,
    }
    return KalmanStribeck({name: [value] * n for name, value in gains.items()})


def errors(robot, observer, log, truth):
    """Return estimate minus truth (N, n) and the velocity's error, after half a second."""
    estimator = FrictionEstimator(robot, [observer])
    estimate = estimator.batch(log)[observer.identifier]
    return (estimate - truth)[log.time > 0.5]


def rmse(*arguments):
    """Return the RMSE per joint [mNm]."""
    return 1e3 * np.sqrt(np.mean(errors(*arguments) ** 2, axis=0))


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-3.5, 0.5), st.floats(-2.5, 0.5))
def test_the_expected_law_is_the_mean_over_a_normal_velocity(v, log_s, log_v_s):
    """Against adaptive quadrature, to its 1e-9; the slope against a central difference."""
    s, v_s = 10.0**log_s, 10.0**log_v_s
    phi, slope = np.zeros(3), np.zeros(3)
    expected_law(v, s, v_s, phi, slope)

    def mean(function, about):
        def integrand(z):
            return function(about + s * z) * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)

        kink = [-about / s] if abs(about / s) < 12.0 else None
        return quad(integrand, -12.0, 12.0, points=kink, limit=400, epsabs=1e-12)[0]

    functions = (np.sign, lambda x: x, lambda x: np.sign(x) * np.exp(-np.abs(x) / v_s))
    for k, function in enumerate(functions):
        assert phi[k] == pytest.approx(mean(function, v), abs=1e-8)
    d = 1e-4 * s
    ends = [np.zeros(3), np.zeros(3)]
    expected_law(v + d, s, v_s, ends[1], np.zeros(3))
    expected_law(v - d, s, v_s, ends[0], np.zeros(3))
    # Rounding 1e-16 / d and curvature d^2 / s^3 both stay below 1e-6 / s.
    np.testing.assert_allclose(slope, (ends[1] - ends[0]) / (2.0 * d), atol=1e-6 / s + 1e-9)


@pytest.mark.parametrize('v', [0.0, 1e-6, 3.0, 300.0])
@pytest.mark.parametrize('s', [1e-9, 1e-3, 10.0])
@pytest.mark.parametrize('v_s', [1e-6, 0.03, 1e3])
def test_the_expected_law_is_finite_and_odd_at_any_scale(v, s, v_s):
    phi, slope, mirrored = np.zeros(3), np.zeros(3), np.zeros(3)
    expected_law(v, s, v_s, phi, slope)
    expected_law(-v, s, v_s, mirrored, np.zeros(3))
    assert np.isfinite([*phi, *slope]).all()
    assert abs(phi[0]) <= 1.0
    assert abs(phi[2]) <= 1.0
    np.testing.assert_allclose(mirrored, -phi, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize('stiffness', [-50.0, 0.0, 1e-3, 300.0, 2e5])
def test_a_prediction_is_the_exact_solution_of_the_linear_system(stiffness):
    """q' = v, v' = a - k (v - v_0) - row x: matrix exponential, also where explicit Euler dies."""
    rng = np.random.default_rng(0)
    h, acceleration = 1e-3, 7.0
    row = rng.normal(size=5)
    x, root = rng.normal(size=7), rng.normal(size=(7, 7))
    P = root @ root.T
    noise = rng.uniform(size=7)
    A = np.zeros((8, 8))
    A[0, 1], A[1, 1], A[1, 2:7] = 1.0, -stiffness, -row
    # The mean moves by its own acceleration, which has the torque of these states in it.
    mean = np.zeros((3, 3))
    mean[0, 1], mean[1, 1], mean[1, 2] = 1.0, -stiffness, acceleration + stiffness * x[1]
    expected = expm(mean * h) @ np.array([x[0], x[1], 1.0])
    F = expm(A * h)[:7, :7]
    covariance = F @ P @ F.T + np.diag(noise)
    others = x[2:].copy()
    _predict(x, P, row, h, acceleration, stiffness, 1.0, noise)
    np.testing.assert_allclose(x[:2], expected[:2], rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(x[2:], others)
    np.testing.assert_allclose(P, covariance, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(('run', 'bound'), [('slow_run', 60.0), ('reversal_run', 160.0)])
def test_one_gain_set_serves_slow_motion_and_reversals(
    request, two_joints, with_encoder, encoder_noise, run, bound
):
    """
    Issue 3: slow <= 60 and reversal <= 160 mNm at the same settings, 16-bit encoder.

    Measured: about 12 and 20; half the bound is what a mistake would take first.
    """
    log, truth = request.getfixturevalue(run)
    found = [
        rmse(two_joints, make(encoder_noise), with_encoder(log, seed), truth) for seed in range(3)
    ]
    assert np.mean(found, axis=0)[0] <= 0.5 * bound


def test_it_learns_the_law_that_is_in_the_joint(
    two_joints, reversal_run, with_encoder, encoder_noise
):
    """
    Truth C 0.80, B 0.35, S 0.50 at the moving joint, v_s as told.

    Three reversals a seed leave C + B v at speed and C + S at the knee; within 10 % over 3 seeds.
    """
    log, truth = reversal_run
    laws = []
    for seed in range(3):
        observer = make(encoder_noise)
        errors(two_joints, observer, with_encoder(log, seed), truth)
        laws.append([observer.law()[name][0] for name in ('coulomb', 'viscous', 'stribeck')])
    C, B, S = np.mean(laws, axis=0)
    level, breakaway = C + 0.7 * B, C + S
    assert level == pytest.approx(0.80 + 0.7 * 0.35, rel=0.05)
    assert breakaway == pytest.approx(1.30, rel=0.15)


def test_a_knee_told_wrong_by_three_costs_less_than_what_the_law_gains(
    two_joints, reversal_run, with_encoder, encoder_noise
):
    """Against the best linear observer of the study for this motion (wn 73, zeta 0.5)."""
    log, truth = reversal_run
    noisy = with_encoder(log, 1)
    linear = LinearSecondOrder({'natural_frequency': [73.0] * 2, 'damping_ratio': [0.5] * 2})
    best = rmse(two_joints, linear, noisy, truth)[0]
    for v_s in (0.01, 0.09):
        found = rmse(two_joints, make(encoder_noise, stribeck_velocity=v_s), noisy, truth)[0]
        assert found < 0.5 * best, v_s


def test_a_push_that_no_law_explains_is_followed_as_a_plain_kalman_observer_would(
    two_joints, slow_run, with_encoder, encoder_noise
):
    """
    A step of 0.5 Nm for a second on joint 1, as if effort had been less and truth more.

    Both know nothing of it; the law must not make the error worse than by a third.
    """
    log, truth = slow_run
    pushed = (log.time > 3.0) & (log.time < 4.0)
    extra = np.zeros_like(truth)
    extra[pushed, 0] = 0.5
    noisy = with_encoder(log, 2)
    tau = noisy.tau.copy()
    # start hold: the effort of sample k acts until k + 1, so it leads the friction by one.
    tau[:-1] += extra[1:]
    noisy, truth = replace(noisy, tau=tau), truth + extra
    plain = Kalman({'position_noise': [encoder_noise] * 2, 'disturbance_rate': [0.6] * 2})
    window = (log.time[log.time > 0.5] > 3.0) & (log.time[log.time > 0.5] < 4.5)
    with_law, without = (
        np.sqrt(np.mean(errors(two_joints, observer, noisy, truth)[window, 0] ** 2))
        for observer in (make(encoder_noise), plain)
    )
    assert with_law <= 1.34 * without


def test_a_joint_without_effort_is_followed_and_the_other_one_hardly_notices(
    two_joints, reversal_run, with_encoder, encoder_noise
):
    """The elbow is held here; what it does unseen is a small disturbance of the shoulder."""
    log, truth = reversal_run
    noisy = with_encoder(log, 3)
    tau = noisy.tau.copy()
    tau[:, 1] = np.nan
    blind = FrictionEstimator(two_joints, [make(encoder_noise)])
    estimate = blind.batch(replace(noisy, tau=tau))['kalman_stribeck']
    assert np.isnan(estimate[:, 1]).all()
    late = log.time > 0.5
    error = 1e3 * np.sqrt(np.mean((estimate - truth)[late, 0] ** 2))
    assert error <= 80.0


def test_the_law_is_kept_over_a_gap_in_the_effort(
    two_joints, reversal_run, with_encoder, encoder_noise
):
    """A tenth of a second without effort: NaN there, and at once as good as before after it."""
    log, truth = reversal_run
    noisy = with_encoder(log, 4)
    tau = noisy.tau.copy()
    gap = (log.time > 4.2) & (log.time < 4.3)
    tau[gap, 0] = np.nan
    estimator = FrictionEstimator(two_joints, [make(encoder_noise)])
    estimate = estimator.batch(replace(noisy, tau=tau))['kalman_stribeck'][:, 0]
    assert np.isnan(estimate[gap][1:]).all()
    after = (log.time > 4.302) & (log.time < 4.4)
    assert np.abs(estimate - truth[:, 0])[after].max() < 0.15


def test_covariances_stay_symmetric_and_positive_over_a_million_steps():
    """Held at rest nothing is learned: the variances must neither grow without end nor break."""
    count, h, noise = 50_000, 1e-3, 5e-5
    observer = make(noise, n=1)
    observer.start(np.zeros(1))
    rng = np.random.default_rng(0)
    last = 0.0
    for _ in range(20):
        q = np.concatenate([[last], noise * rng.normal(size=count)])
        last = q[-1]
        samples = MomentumSamples(
            np.full(count, h),
            np.diff(q)[:, None] / h * 0.3,
            np.diff(q)[:, None] * 0.3,
            np.zeros((count, 1)),
            np.full((count, 1, 1), 0.3),
        )
        estimate = observer.run(samples)
        assert np.isfinite(estimate).all()
    P = observer._P[0]
    np.testing.assert_array_equal(P, P.T)
    assert np.linalg.eigvalsh(P / np.sqrt(np.outer(np.diag(P), np.diag(P)))).min() > -1e-9
    # At rest friction is zero, in the mean and but for what the noise of the velocity makes.
    assert abs(estimate.mean()) < 0.02
    assert estimate.std() < 0.2


@pytest.mark.parametrize(('size', 'stays'), [(0.01, True), (3.0, False), (0.1, False)])
def test_a_wrong_position_is_got_over(
    two_joints, reversal_run, with_encoder, encoder_noise, size, stays
):
    """
    A step of the elbow's encoder or a spike of one sample: 1.1 s later all is as without it.

    Where the velocity is its difference the glitch is in C^T q' as well, hundreds of Nm for an
    interval, and some of it is taken for friction: then the error stays below a tenth of a Nm.
    """
    log, truth = reversal_run
    noisy = with_encoder(log, 5)
    q = noisy.q.copy()
    at = 3000
    q[at : None if stays else at + 1, 1] += size
    v = np.diff(q, axis=0, prepend=q[:1]) / 1e-3
    late = log.time[log.time > 0.5] > log.time[at] + 1.1

    def error(recording):
        observer = make(encoder_noise)
        return np.sqrt(np.mean(errors(two_joints, observer, recording, truth)[late] ** 2, axis=0))

    assert (error(replace(noisy, q=q)) <= 1.2 * error(noisy) + 1e-3).all()
    assert (error(replace(noisy, q=q, v=v)) < 0.1).all()


def test_friction_never_drives(two_joints, reversal_run, with_encoder, encoder_noise):
    """C, B and S are not negative at any time: a law that gives power would explain itself."""
    log, _ = reversal_run
    noisy = with_encoder(log, 6)
    observer = make(encoder_noise, residual=0.002, friction=7.0, stribeck_velocity=0.005)
    estimator = FrictionEstimator(two_joints, [observer])
    for k in range(3000):
        estimator.update(int(log.t_ns[k]), noisy.q[k], noisy.v[k], noisy.tau[k])
        law = observer.law()
        for name in ('coulomb', 'viscous', 'stribeck'):
            assert np.isnan(law[name]).any() or (law[name] >= 0.0).all()


@pytest.mark.parametrize(('every', 'bound'), [(1, 40.0), (2, 45.0), (5, 130.0)])
def test_a_coarse_sampling_learns_the_same_law(
    two_joints, reversal_run, with_encoder, encoder_noise, every, bound
):
    """
    1 kHz, 500 Hz and 200 Hz: friction near the knee is integrated in pieces of an interval.

    The effort of the fine samples is averaged, as a drive that measures current would report it.
    The linear observer of the study has about 240 mNm at all three.
    """
    log, truth = reversal_run
    noisy = with_encoder(log, 7)
    count = len(log) // every
    rows = np.arange(count) * every
    mean = noisy.tau[: count * every].reshape(count, every, 2).mean(axis=1)
    coarse = JointLog(
        log.names,
        log.t_ns[rows],
        noisy.q[rows],
        np.diff(noisy.q[rows], axis=0, prepend=noisy.q[:1]) / (every * 1e-3),
        mean,
    )
    found = rmse(two_joints, make(encoder_noise), coarse, truth[rows])
    assert found[0] <= bound
