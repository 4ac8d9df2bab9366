# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The linear second-order observer against its transfer function and its equations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter, lsim

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.kinds.linear_second_order import LinearSecondOrder

frequencies = st.floats(1.0, 500.0)
ratios = st.floats(0.0, 3.0)


def make(wn, zeta, n=1):
    return LinearSecondOrder({'natural_frequency': [wn] * n, 'damping_ratio': [zeta] * n})


@given(frequencies, ratios, st.floats(2e-4, 0.01))
def test_each_step_solves_the_backward_euler_equations(drive, wn, zeta, h):
    """Written here as a 2 x 2 linear system, solved by numpy."""
    p, u = np.random.default_rng(0).normal(size=(2, 80))
    estimate = drive(make(wn, zeta), p, u, h)
    t2, s2 = 2.0 * zeta * wn, wn**2
    matrix = np.array([[1.0 + h * t2, -h], [h * s2, 1.0]])
    p_hat, sigma = p[0], 0.0
    for k in range(1, 80):
        right = [p_hat + h * u[k] + h * t2 * p[k], sigma + h * s2 * p[k]]
        p_hat, sigma = np.linalg.solve(matrix, right)
        assert estimate[k - 1] == pytest.approx(sigma, abs=1e-9 * (1.0 + h * s2 * 10.0))


@pytest.mark.parametrize(('wn', 'zeta'), [(20.0, 0.5), (35.0, 0.15), (70.0, 1.0)])
def test_it_is_wn2_over_s2_plus_2_zeta_wn_s_plus_wn2(drive, held_momentum, wn, zeta):
    """A step: backward Euler at h wn / 100 is within 1 %, and within half of that at half of h."""
    errors = []
    for n in (100, 200):
        h = 1.0 / (n * wn)
        count = int(20.0 / (wn * h))
        d = np.ones(count)
        d[0] = 0.0
        estimate = drive(make(wn, zeta), held_momentum(d, 0.0 * d, h), 0.0 * d, h)
        t = h * np.arange(count)
        _, y, _ = lsim(([wn**2], [1.0, 2.0 * zeta * wn, wn**2]), np.ones(count), t)
        errors.append(np.abs(estimate - y[1:]).max())
    assert errors[0] < 0.05
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.1)


@given(frequencies, ratios, st.floats(2e-4, 0.01))
def test_the_lag_filter_is_the_response_with_gain_one(drive, held_momentum, wn, zeta, h):
    d, u = np.random.default_rng(1).normal(size=(2, 80))
    observer = make(wn, zeta)
    b, a = observer.lag_filter(h, 0)
    assert b.sum() / a.sum() == pytest.approx(1.0, rel=1e-6)
    estimate = drive(observer, held_momentum(d, u, h), u, h)
    np.testing.assert_allclose(estimate, lfilter(b, a, d[1:]), atol=1e-9)


def test_encoder_noise_comes_out_as_the_recipe_says(drive):
    """wn^2 s_q for zeta = 1/2 and M = 1 while wn h is small; 2 % for 4e5 samples."""
    h, wn, s = 1e-3, 20.0, 1e-4
    q = np.random.default_rng(2).normal(scale=s, size=400_001)
    p = np.diff(q) / h
    estimate = drive(make(wn, 0.5), p, 0.0 * p, h)[5000:]
    assert estimate.std() == pytest.approx(wn**2 * s, rel=0.03)


@pytest.mark.parametrize(
    ('run', 'wn', 'zeta', 'bound'),
    [('slow_run', 33.3, 0.141, 36.0), ('reversal_run', 73.5, 0.549, 245.0)],
)
def test_it_reaches_the_accuracy_of_the_study_with_an_encoder(
    request, two_joints, with_encoder, run, wn, zeta, bound
):
    """
    observer_study.md section 7, 16 bit: 36 / 245 mNm.

    From 1 s on: whole half periods of the reversal, as many crossings a second as its 20 s have.
    """
    log, truth = request.getfixturevalue(run)
    estimator = FrictionEstimator(two_joints, [make(wn, zeta, 2)])
    estimate = estimator.batch(with_encoder(log, 11))['linear_second_order']
    assert 1e3 * np.sqrt(np.mean((estimate - truth)[1000:, 0] ** 2)) <= bound


def test_a_frequency_of_zero_is_refused_under_its_own_name():
    with pytest.raises(ConfigurationError, match='gain natural_frequency of observer linear_'):
        make(0.0, 0.5)
