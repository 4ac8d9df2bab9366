# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The smoother against the weighted least squares it is equal to, and against the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.kinds.kalman import Kalman
from sosml_friction.observers.kinds.smoother import Smoother


def make(n, noise, rate, crossing_rate=0.0, crossing_velocity=1.0):
    return Smoother(
        {
            'position_noise': [noise] * n,
            'disturbance_rate': [rate] * n,
            'crossing_rate': [crossing_rate] * n,
            'crossing_velocity': [crossing_velocity] * n,
        }
    )


def most_probable(p, integral, forcing, h, R, q):
    """
    Return p and tau_e of one joint, (N,) each, that minimise the sum of squares of the model.

    Unknown are X, p, tau_e at all N + 1 samples; every equation is divided by its standard
    deviation. X is in units of h^2, p of h, so that the matrix is of the size of one.
    """
    count = len(h)
    scale = np.mean(h) ** np.array([2.0, 1.0, 0.0])
    rows, right = [], []

    def add(weight, columns, value):
        """Add ``weight @ (sum of matrix @ x_k) = weight @ value``."""
        row = np.zeros((len(weight), 3 * (count + 1)))
        for k, matrix in columns.items():
            row[:, 3 * k : 3 * k + 3] = weight @ matrix * scale
        rows.append(row)
        right.append(weight @ value)

    start = np.sqrt([R[0], 2.0 * R[0] / h[0] ** 2, q[0]])
    add(np.diag(1.0 / start), {0: np.eye(3)}, np.array([0.0, p, 0.0]))
    y = np.cumsum(integral)
    for k in range(count):
        T = h[k]
        F = np.array([[1.0, T, T * T / 2.0], [0.0, 1.0, T], [0.0, 0.0, 1.0]])
        powers = T ** np.array([2.0, 1.0, 0.0])
        Q = q[k] * T * np.outer(powers, powers)
        Q *= np.array([[1 / 20, 1 / 8, 1 / 6], [1 / 8, 1 / 3, 1 / 2], [1 / 6, 1 / 2, 1.0]])
        weight = np.linalg.inv(np.linalg.cholesky(Q))
        u = forcing[k] * np.array([T * T / 2.0, T, 0.0])
        add(weight, {k: -F, k + 1: np.eye(3)}, u)
        measure = np.array([[1.0, 0.0, 0.0]])
        add(np.array([[1.0 / np.sqrt(R[k])]]), {k + 1: measure}, y[k : k + 1])
    solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    state = solution.reshape(-1, 3)[1:] * scale
    return state[:, 1], state[:, 2]


def short_record(count=40, seed=0):
    rng = np.random.default_rng(seed)
    h = rng.uniform(5e-4, 2e-3, size=count + 1)
    p, forcing = 0.05 * rng.normal(size=(2, count + 1, 2))
    integral = h[:, None] * 0.05 * rng.normal(size=(count + 1, 2))
    inertia = np.array([[0.37, 0.1], [0.1, 0.05]]) * rng.uniform(0.9, 1.1, size=(count + 1, 1, 1))
    return p, integral, forcing, h, inertia


def variances(inertia, noise):
    return np.sum((inertia * noise) ** 2, axis=2)


@pytest.mark.parametrize(('noise', 'rate'), [(6e-5, 0.1), (6e-5, 10.0), (1e-4, 100.0)])
def test_it_minimises_the_sum_of_squares(drive, noise, rate):
    """Equal to the solution of all equations at once; 1e-7 of it, lstsq's condition."""
    p, integral, forcing, h, inertia = short_record()
    estimate = drive(make(2, noise, rate), p, forcing, h, integral, inertia[1:])
    R = variances(inertia[1:], noise)
    for i in range(2):
        q = np.full(len(h) - 1, rate**2)
        _, tau = most_probable(p[0, i], integral[1:, i], forcing[1:, i], h[1:], R[:, i], q)
        np.testing.assert_allclose(estimate[:, i], tau, atol=1e-7 * np.abs(tau).max())


def test_a_scheduled_one_minimises_it_with_q_at_the_velocity_of_the_first_pass(drive):
    p, integral, forcing, h, inertia = short_record(seed=1)
    noise, rate, crossing, vq = 6e-5, 0.5, 12.0, 0.1
    observer = make(2, noise, rate, crossing, vq)
    estimate = drive(observer, p, forcing, h, integral, inertia[1:])
    R = variances(inertia[1:], noise)

    def solve(q):
        joints = [
            most_probable(p[0, i], integral[1:, i], forcing[1:, i], h[1:], R[:, i], q[:, i])
            for i in range(2)
        ]
        return np.array(joints).transpose(1, 2, 0)

    momentum, _ = solve(np.full((len(h) - 1, 2), rate**2 + crossing**2))
    v = np.array([np.linalg.solve(M, x) for M, x in zip(inertia[1:], momentum, strict=True)])
    assert 0.05 < np.mean(np.abs(v) < vq) < 0.95
    _, tau = solve(rate**2 + crossing**2 * np.exp(-((v / vq) ** 2)))
    np.testing.assert_allclose(estimate, tau, atol=1e-6 * np.abs(tau).max())


def test_at_the_end_of_a_record_it_is_the_kalman_observer(drive):
    p, integral, forcing, h, inertia = short_record(200)
    kalman = Kalman({'position_noise': [6e-5] * 2, 'disturbance_rate': [2.0] * 2})
    causal = drive(kalman, p, forcing, h, integral, inertia[1:])
    smooth = drive(make(2, 6e-5, 2.0), p, forcing, h, integral, inertia[1:])
    np.testing.assert_array_equal(smooth[-1], causal[-1])
    assert np.abs(smooth - causal)[:-1].min() > 0.0


def test_a_hole_in_the_forcing_is_smoothed_in_pieces(drive):
    p, integral, forcing, h, inertia = short_record(60)
    plain = drive(make(2, 6e-5, 2.0), p, forcing, h, integral, inertia[1:])
    forcing[20:23, 0] = np.nan
    hole = drive(make(2, 6e-5, 2.0), p, forcing, h, integral, inertia[1:])
    np.testing.assert_array_equal(hole[:, 1], plain[:, 1])
    assert np.flatnonzero(np.isnan(hole[:, 0])).tolist() == [19, 20, 21]
    before, after = (
        drive(make(2, 6e-5, 2.0), p[s], forcing[s], h[s], integral[s], inertia[s][1:])
        for s in (slice(20), slice(22, None))
    )
    np.testing.assert_array_equal(hole[:19, 0], before[:, 0])
    np.testing.assert_array_equal(hole[22:, 0], after[:, 0])


TUNED = {'slow_run': (0.0533, 0.0, 1.0, 4.0), 'reversal_run': (0.108, 6.73, 0.0212, 30.0)}


@pytest.mark.parametrize('run', TUNED)
def test_it_reaches_the_accuracy_of_the_study_with_an_encoder(
    request, two_joints, with_encoder, encoder_noise, run
):
    """
    observer_study.md section 3, 16 bit: 3.2 mNm on the slow motion, 26.5 on the reversal.

    Gains tuned on seed 1, scored on seeds 11 to 13: the mean is bounded.
    """
    log, truth = request.getfixturevalue(run)
    rate, crossing, vq, bound = TUNED[run]
    estimator = FrictionEstimator(two_joints, [make(2, encoder_noise, rate, crossing, vq)])
    rmse = []
    for seed in range(11, 14):
        estimate = estimator.batch(with_encoder(log, seed))['smoother']
        rmse.append(1e3 * np.sqrt(np.mean((estimate - truth)[500:, 0] ** 2)))
    assert np.mean(rmse) <= bound


def test_it_is_not_shifted_by_half_an_interval(reversal_run, two_joints):
    """
    Without noise the estimate is the friction at the sample itself.

    Half an interval of 1 ms at the friction's largest rate (690 Nm/s) is 0.35 Nm; the RMSE of
    estimates shifted by half an interval is the truth's own over half a step, 20 times larger than
    the one measured here; 10 times is asked for.
    """
    log, truth = reversal_run
    estimator = FrictionEstimator(two_joints, [make(2, 1e-8, 10.0)])
    error = (estimator.batch(log)['smoother'] - truth)[500:-100]
    half_a_step = 0.5 * np.diff(truth, axis=0)[500:-100]
    assert np.sqrt(np.mean(error[:, 0] ** 2)) < 0.1 * np.sqrt(np.mean(half_a_step[:, 0] ** 2))


@pytest.mark.parametrize('hole', [slice(None), slice(3300, 3500)])
def test_missing_effort_of_a_joint_does_not_spoil_the_schedule_of_the_other(
    reversal_run, two_joints, with_encoder, encoder_noise, hole
):
    """
    The elbow's effort is never known, or not for 0.2 s up to a reversal of the shoulder.

    The shoulder's RMSE, of 0.6 s around that reversal, may grow by a tenth.
    """
    log, truth = reversal_run
    noisy = with_encoder(log, 11)
    rate, crossing, vq, _ = TUNED['reversal_run']
    estimator = FrictionEstimator(two_joints, [make(2, encoder_noise, rate, crossing, vq)])
    both = estimator.batch(noisy)['smoother']
    tau = noisy.tau.copy()
    tau[hole, 1] = np.nan
    one = estimator.batch(replace(noisy, tau=tau))['smoother']
    # The effort holds from its sample on: the last of the hole is missing in one interval more.
    missing = np.flatnonzero(np.isnan(one[1:, 1]))
    assert set(missing) == set(np.flatnonzero(np.isnan(tau[:-1, 1])))
    rmse = [np.sqrt(np.mean((e - truth)[3200:3800, 0] ** 2)) for e in (both, one)]
    assert rmse[1] < 1.1 * rmse[0]


def test_the_lag_filter_is_one():
    assert [x.tolist() for x in make(1, 1e-4, 1.0).lag_filter(1e-3, 0)] == [[1.0], [1.0]]
