# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""FO behind a low-pass against the zero-order hold of both lags, and what it is worth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import cont2discrete, lfilter

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.kinds.first_order import FirstOrder
from sosml_friction.observers.kinds.first_order_prefiltered import FirstOrderPrefiltered

cutoffs = st.floats(0.1, 1e4)
periods = st.floats(1e-4, 0.05)


def make(c0, wf, n=1):
    return FirstOrderPrefiltered({'cutoff': [c0] * n, 'prefilter_cutoff': [wf] * n})


@given(cutoffs, st.one_of(st.just(1.0), st.floats(0.01, 100.0)), periods)
def test_a_held_disturbance_passes_the_exact_zoh_of_both_lags(drive, held_momentum, c0, ratio, h):
    """f' = w_f (d - f), r' = c0 (f - r), d held: scipy's matrix exponential. Equal lags too."""
    rng = np.random.default_rng(0)
    d, u = rng.normal(size=(2, 60))
    wf = ratio * c0
    estimate = drive(make(c0, wf), held_momentum(d, u, h), u, h)
    system = [[-wf, 0.0], [c0, -c0]], [[wf], [0.0]], [[0.0, 1.0]], [[0.0]]
    A, B, _, _, _ = cont2discrete(tuple(np.array(m) for m in system), h, 'zoh')
    x, truth = np.zeros(2), []
    for value in d[1:]:
        x = A @ x + B[:, 0] * value
        truth.append(x[1])
    # p is differenced: rounding of p over h; and expm's own for h w up to 5e4.
    np.testing.assert_allclose(estimate, truth, atol=1e-9)


@given(cutoffs, cutoffs, periods)
def test_the_lag_filter_is_the_response_and_has_gain_one_at_rest(drive, held_momentum, c0, wf, h):
    rng = np.random.default_rng(1)
    d, u = rng.normal(size=(2, 60))
    observer = make(c0, wf)
    b, a = observer.lag_filter(h, 0)
    # Coefficients of rounding 1e-16, against (1 - a_r) (1 - a_f).
    rest = np.expm1(-c0 * h) * np.expm1(-wf * h)
    assert b.sum() == pytest.approx(rest, rel=1e-9, abs=1e-15)
    assert a.sum() == pytest.approx(rest, rel=1e-9, abs=1e-15)
    estimate = drive(observer, held_momentum(d, u, h), u, h)
    np.testing.assert_allclose(estimate, lfilter(b, a, d[1:]), atol=1e-9)


@given(st.floats(1.0, 100.0), st.floats(1.0, 100.0))
def test_the_two_cutoffs_may_be_exchanged(drive, c0, wf):
    p, u = np.random.default_rng(2).normal(size=(2, 60))
    one, other = (drive(make(*gains), p, u, 1e-3) for gains in ((c0, wf), (wf, c0)))
    np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(one).max())


def test_with_a_fast_prefilter_it_is_the_first_order_observer(drive):
    """w_f h = 1e6 and more: the prefilter has forgotten all within an interval."""
    p, u = np.random.default_rng(3).normal(size=(2, 60))
    plain = drive(FirstOrder({'cutoff': [40.0]}), p, u, 1e-3)
    # What is left of the lag is c0 / w_f.
    fast = drive(make(40.0, 1e12), p, u, 1e-3)
    np.testing.assert_allclose(fast, plain, atol=1e-9 * np.abs(plain).max())


def test_acceleration_that_the_forcing_explains_is_not_taken_for_a_disturbance(drive):
    """Both are filtered alike; with the momentum alone this would leave up to u itself."""
    h, u = 1e-3, np.concatenate([np.zeros(50), np.full(500, 7.0)])
    p = 2.0 + h * np.cumsum(u)
    assert np.abs(drive(make(30.0, 60.0), p, u, h)).max() < 1e-10


def test_joints_have_their_own_gains_and_a_nan_stays_with_its_joint(drive):
    rng = np.random.default_rng(4)
    p, u = rng.normal(size=(2, 50, 2))
    u[20, 0] = np.nan
    gains = {'cutoff': [10.0, 200.0], 'prefilter_cutoff': [30.0, 50.0]}
    pair = drive(FirstOrderPrefiltered(gains), p, u, 1e-3)
    np.testing.assert_array_equal(pair[:, 1], drive(make(200.0, 50.0), p[:, 1], u[:, 1], 1e-3))
    assert np.flatnonzero(np.isnan(pair[:, 0])).tolist() == [19]
    again = drive(make(10.0, 30.0), p[20:, 0], u[20:, 0], 1e-3)
    np.testing.assert_array_equal(pair[20:, 0], again)


@pytest.mark.parametrize(
    ('run', 'cutoff', 'bound'), [('slow_run', 50.0, 64.0), ('reversal_run', 90.5, 258.0)]
)
def test_it_reaches_the_accuracy_of_the_study_with_an_encoder(
    request, two_joints, with_encoder, run, cutoff, bound
):
    """observer_study.md section 3, 16 bit, FO + prefilter: 64 / 258 mNm; less than half of FO."""
    log, truth = request.getfixturevalue(run)
    observers = [make(cutoff, cutoff, 2), FirstOrder({'cutoff': [10.0, 10.0]})]
    estimates = FrictionEstimator(two_joints, observers).batch(with_encoder(log, 11))
    rmse = {
        name: 1e3 * np.sqrt(np.mean((estimate - truth)[500:, 0] ** 2))
        for name, estimate in estimates.items()
    }
    assert rmse['first_order_prefiltered'] <= bound
    assert rmse['first_order_prefiltered'] < 0.5 * rmse['first_order']


@pytest.mark.parametrize('name', ['cutoff', 'prefilter_cutoff'])
def test_a_cutoff_of_zero_is_refused(name):
    gains = {'cutoff': [1.0], 'prefilter_cutoff': [1.0], name: [0.0]}
    with pytest.raises(ConfigurationError, match=f'gain {name} of observer first_order_pre'):
        FirstOrderPrefiltered(gains)
