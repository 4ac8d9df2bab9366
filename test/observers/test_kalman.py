# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The integrated-momentum Kalman observer against textbook matrices, its noise and its lag."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, solve_discrete_are
from scipy.signal import lfilter

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.kinds.kalman import Kalman
from sosml_friction.observers.momentum_kalman import (
    begin,
    measurement_variance,
    predict,
    steady_lag_filter,
    update,
)
from sosml_friction.observers.momentum_samples import MomentumSamples

#: A triple integrator: X' = p, p' = u + tau, tau' = w.
CHAIN = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])


def make(position_noise, disturbance_rate):
    return Kalman({'position_noise': position_noise, 'disturbance_rate': disturbance_rate})


def discrete(h, q):
    """Return F and Q of the triple integrator by Van Loan's matrix exponential."""
    block = np.zeros((6, 6))
    block[:3, :3], block[3:, 3:] = -CHAIN, CHAIN.T
    block[2, 5] = q
    e = expm(block * h)
    F = e[3:, 3:].T
    return F, F @ e[:3, 3:]


def textbook(p, integral, forcing, h, inertia, noise, rate):
    """Return tau_e of one joint by matrices, X itself in the state; row 0 is the start."""
    R = (inertia**2) @ (np.array(noise) ** 2)
    q = rate**2
    x, y = np.array([0.0, p[0], 0.0]), 0.0
    P = np.diag([R[1], 2.0 * R[1] / h[1] ** 2, q])
    H = np.array([[1.0, 0.0, 0.0]])
    result = []
    for k in range(1, len(p)):
        F, Q = discrete(h[k], q)
        x = F @ x + np.array([0.5 * h[k] ** 2, h[k], 0.0]) * forcing[k]
        P = F @ P @ F.T + Q
        y += integral[k]
        S = H @ P @ H.T + R[k]
        K = P @ H.T / S
        x = x + K[:, 0] * (y - x[0])
        P = (np.eye(3) - K @ H) @ P @ (np.eye(3) - K @ H).T + R[k] * K @ K.T
        result.append(x[2])
    return np.array(result)


def random_samples(count, seed):
    """Return p, integral, forcing, h and inertia of two coupled joints, all varying."""
    rng = np.random.default_rng(seed)
    h = rng.uniform(5e-4, 2e-3, size=count)
    p, forcing = 0.1 * rng.normal(size=(2, count, 2))
    integral = h[:, None] * 0.1 * rng.normal(size=(count, 2))
    phase = np.arange(count) * 0.05
    inertia = np.empty((count, 2, 2))
    inertia[:, 0, 0] = 0.37 + 0.05 * np.cos(phase)
    inertia[:, 1, 1] = 0.05
    inertia[:, 0, 1] = inertia[:, 1, 0] = 0.08 + 0.03 * np.sin(phase)
    return p, integral, forcing, h, inertia


@pytest.mark.parametrize('rate', [0.05, 2.0, 50.0])
def test_it_is_the_textbook_filter(drive, rate):
    """1e-9 of the largest estimate: the textbook's X grows, this one does not."""
    p, integral, forcing, h, inertia = random_samples(400, 0)
    noise, rates = [6e-5, 3e-4], [rate, 0.3 * rate]
    estimate = drive(make(noise, rates), p, forcing, h, integral, inertia[1:])
    for i in range(2):
        expected = textbook(
            p[:, i], integral[:, i], forcing[:, i], h, inertia[:, i], noise, rates[i]
        )
        np.testing.assert_allclose(
            estimate[:, i], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
        )


def test_the_covariance_stays_symmetric_and_settles_over_a_million_steps():
    """After 1e6 updates it solves the Riccati equation, 1e-9 of each entry's scale."""
    h, q, R = 1e-3, 4.0, 4e-10
    observer = make([2e-5], [2.0])
    count, chunk = 1_000_000, 100_000
    rng = np.random.default_rng(1)
    observer.start(np.zeros(1))
    for _ in range(count // chunk):
        integral = np.diff(rng.normal(scale=2e-5, size=chunk + 1))[:, None]
        zero, M = np.zeros((chunk, 1)), np.ones((chunk, 1, 1))
        estimate = observer.run(MomentumSamples(np.full(chunk, h), zero, integral, zero, M))
        assert np.isfinite(estimate).all()
    x, P = observer._x[0], observer._P[0]
    np.testing.assert_array_equal(P, P.T)
    F, Q = discrete(h, q)
    prior = solve_discrete_are(F.T, np.array([[1.0], [0.0], [0.0]]), Q, np.array([[R]]))
    K = prior[:, 0] / (prior[0, 0] + R)
    expected = prior - np.outer(K, prior[0])
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((P - expected) / scale).max() < 1e-9
    assert np.linalg.eigvalsh(P / scale).min() > 0.0
    # X is held against its own measurement: what is left is noise, not a sum of a million.
    assert abs(x[0]) < 10.0 * np.sqrt(R)


def test_innovations_and_errors_are_as_large_as_the_filter_believes():
    """
    Two coupled joints drawn from the model: encoder noise of both enters each momentum.

    Mean of innovation^2 / variance over 20 000 white samples: 1 within 5 sqrt(2 / N) = 5 %. That
    of the error of tau_e: correlated over about 20 samples, 1 within 5 sqrt(40 / N) = 22 %.
    """
    rng = np.random.default_rng(2)
    count, h = 20_000, 1e-3
    M = np.array([[0.4, 0.15], [0.15, 0.1]])
    noise, q = np.array([2e-5, 1e-4]), np.array([4.0, 1.0])
    readings = rng.normal(size=(count + 1, 2)) * noise @ M.T
    for i in range(2):
        F, Q = discrete(h, q[i])
        R = measurement_variance(M[i], noise)
        np.testing.assert_allclose(R, M[i] ** 2 @ noise**2, rtol=1e-14)
        w = rng.normal(size=(count, 3)) @ np.linalg.cholesky(Q).T
        truth, x, P = np.zeros(3), np.zeros(3), np.zeros((3, 3))
        begin(x, P, 0.0, R, h, q[i])
        ratios = []
        for k in range(count):
            before = truth[0]
            truth = F @ truth + w[k]
            measured = truth[0] - before + readings[k + 1, i] - readings[k, i]
            predict(x, P, h, 0.0, measured, q[i])
            innovation, variance = update(x, P, R)
            ratios.append((innovation**2 / variance, (x[2] - truth[2]) ** 2 / P[2, 2]))
        innovations, errors = np.mean(ratios[200:], axis=0)
        assert innovations == pytest.approx(1.0, abs=0.05)
        assert errors == pytest.approx(1.0, abs=0.22)


@given(st.floats(-2.0, 6.0), st.floats(2e-4, 1e-2), st.floats(-2.0, 2.0))
def test_the_steady_gain_is_that_of_the_riccati_equation(ratio, h, rate):
    """
    Poles of (I - K H) F by scipy's Riccati solver, in units of h.

    It loses digits as the poles approach one: 1e-9 up to R / (q h^5) = 1e6.
    """
    F, Q = discrete(1.0, 1.0)
    H = np.array([[1.0, 0.0, 0.0]])
    P = solve_discrete_are(F.T, H.T, Q, np.array([[10.0**ratio]]))
    K = P @ H.T / (P[0, 0] + 10.0**ratio)
    b, a = steady_lag_filter(10.0 ** (ratio + 2 * rate) * h**5, h, 10.0 ** (2 * rate))
    np.testing.assert_allclose(a, np.poly((np.eye(3) - K @ H) @ F), atol=1e-9)
    np.testing.assert_allclose(b, 0.5 * K[2, 0] * np.ones(2), atol=1e-9)


@given(st.floats(-15.0, 20.0))
def test_the_lag_filter_is_stable_with_gain_one_at_rest_at_any_gains(ratio):
    """
    1 - |pole| falls to 5e-4 at the end of the range; the sum of a is the product of them.

    It comes from coefficients of rounding 1e-16, which is that against a(1) = 2 b.
    """
    b, a = steady_lag_filter(10.0**ratio * 1e-15, 1e-3, 1.0)
    assert a.sum() == pytest.approx(b.sum(), abs=1e-14)
    assert np.abs(np.roots(a)).max() < 1.0


@pytest.mark.parametrize('rate', [0.1, 2.0, 100.0])
def test_the_lag_filter_is_the_response_to_a_disturbance(drive, held_momentum, rate):
    """Once the gain has settled, a disturbance adds its filtered self: 1e-8 of it."""
    rng = np.random.default_rng(3)
    h, count, settled = 1e-3, 6000, 5000
    M = np.array([[0.37, 0.1], [0.1, 0.05]])
    inertia = np.broadcast_to(M, (count - 1, 2, 2)).copy()
    d, u = rng.normal(size=(2, count, 2))
    d[:settled] = 0.0
    observer = make([5e-5, 5e-5], [rate, rate])
    with_it = drive(observer, held_momentum(d, u, h), u, h, inertia=inertia)
    without = drive(observer, held_momentum(0.0 * d, u, h), u, h, inertia=inertia)
    for i in range(2):
        b, a = observer.lag_filter(h, i)
        # b and a are of the gain after infinitely many steps; 5 s of the slowest are e^-100.
        expected = lfilter(b, a, d[1:, i])
        np.testing.assert_allclose(
            (with_it - without)[:, i], expected, atol=1e-8 * np.abs(d).max()
        )


def test_before_any_sample_the_lag_filter_takes_the_inertia_for_one():
    expected = steady_lag_filter(4e-10, 1e-3, 9.0)
    for one, other in zip(make([2e-5], [3.0]).lag_filter(1e-3, 0), expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)


def test_a_missing_forcing_starts_that_joint_afresh(drive):
    p, integral, forcing, h, inertia = random_samples(60, 4)
    noise, rates = [6e-5, 6e-5], [2.0, 2.0]
    plain = drive(make(noise, rates), p, forcing, h, integral, inertia[1:])
    forcing[20, 0] = np.nan
    hole = drive(make(noise, rates), p, forcing, h, integral, inertia[1:])
    np.testing.assert_array_equal(hole[:, 1], plain[:, 1])
    assert np.flatnonzero(np.isnan(hole[:, 0])).tolist() == [19]
    np.testing.assert_array_equal(hole[:19, 0], plain[:19, 0])
    again = drive(make(noise, rates), p[20:], forcing[20:], h[20:], integral[20:], inertia[21:])
    np.testing.assert_array_equal(hole[20:, 0], again[:, 0])


@pytest.mark.parametrize(
    ('run', 'rate', 'bound'), [('slow_run', 0.34, 40.0), ('reversal_run', 1.93, 225.0)]
)
def test_it_reaches_the_accuracy_of_the_study_with_an_encoder(
    request, two_joints, with_encoder, encoder_noise, run, rate, bound
):
    """
    observer_study.md section 3, 16 bit: 36.1 / 218 mNm with q tuned for each motion.

    One seed of a shorter record: 5 seeds of the full one spread by 0.5 / 1.5 mNm, the rest is for
    the length.
    """
    log, truth = request.getfixturevalue(run)
    observer = make([encoder_noise] * 2, [rate] * 2)
    estimate = FrictionEstimator(two_joints, [observer]).batch(with_encoder(log, 11))['kalman']
    rmse = 1e3 * np.sqrt(np.mean((estimate - truth)[500:, 0] ** 2))
    assert rmse <= bound


@pytest.mark.parametrize('name', ['position_noise', 'disturbance_rate'])
def test_a_gain_of_zero_is_refused(name):
    gains = {'position_noise': [1e-4], 'disturbance_rate': [1.0], name: [0.0]}
    with pytest.raises(ConfigurationError, match=f'gain {name} of observer kalman must be'):
        Kalman(gains)
