# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""SOSML's implicit step against its own equations and a linear observer written here."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.kinds.sosml import Sosml
from sosml_friction.observers.momentum_samples import MomentumSamples


def make(s1, t1, s2, t2):
    return Sosml({'sliding': [s1], 'sliding_root': [t1], 'linear': [s2], 'linear_damping': [t2]})


gain_sets = st.tuples(
    st.one_of(st.just(0.0), st.floats(1e-3, 1e4)),
    st.one_of(st.just(0.0), st.floats(1e-2, 200.0)),
    st.one_of(st.just(0.0), st.floats(1.0, 1e5)),
    st.one_of(st.just(0.0), st.floats(1.0, 1e3)),
).filter(lambda gains: gains[0] + gains[2] > 0.0)
periods = st.floats(2e-4, 0.01)


def momentum(disturbance, forcing, h):
    return np.concatenate([[0.0], np.cumsum(h * (forcing[1:] + disturbance[1:]))])


@given(gain_sets, periods, st.integers(0, 1000), st.floats(-3.0, 2.0))
def test_each_step_solves_the_backward_euler_equations(gains, h, seed, scale):
    """
    Substitute e and sigma after the step.

    e = p_hat' - p and the new sigma must satisfy both equations with one sign in [-1, 1], which is
    sgn(e) where e is not 0. Residual: 1e-12 of the largest term, that is rounding.
    """
    s1, t1, s2, t2 = gains
    rng = np.random.default_rng(seed)
    p_hat = float(10**scale * rng.normal())
    observer = make(*gains)
    observer.start(np.array([p_hat]))
    # Bring sigma to a value of no significance by steps that are checked as well.
    sigma = 0.0
    for _ in range(20):
        p, u = 10**scale * rng.normal(size=2)
        one = (np.array([[x]]) for x in (p, 0.0, u))
        samples = MomentumSamples(np.array([h]), *one, np.ones((1, 1, 1)))
        new = float(observer.run(samples)[0, 0])
        new_hat = float(observer._state[0, 0])
        e = new_hat - p
        size = max(abs(p), abs(p_hat), abs(h * u), abs(h * sigma), abs(h * new), 1e-30)
        if s1 > 0.0:
            sign = -((new - sigma) / h + s2 * e) / s1
            slack = 1e-12 * (size / h**2) / s1 + 1e-12 * (abs(sigma) + abs(new)) / (h * s1) + 1e-12
            assert abs(sign) <= 1.0 + slack
            if abs(e) > 1e-9 * size:
                assert sign == pytest.approx(np.sign(e), abs=1e3 * slack)
        else:
            assert (new - sigma) / h + s2 * e == pytest.approx(0.0, abs=1e-12 * size / h**2)
        residual = new_hat - p_hat - h * (u + new - t1 * np.sqrt(abs(e)) * np.sign(e) - t2 * e)
        # sqrt magnifies the rounding of e = p_hat - p where e is small against p.
        rounding = h * t1 * min(np.sqrt(1e-16 * size), 1e-16 * size / np.sqrt(abs(e) + 1e-300))
        assert abs(residual) <= 1e-12 * size + 4.0 * rounding
        p_hat, sigma = new_hat, new


@settings(deadline=None, max_examples=60)
@given(
    st.floats(5.0, 200.0),
    st.floats(0.3, 2.0),
    st.one_of(st.just(0.0), st.floats(1e-3, 1e3)),
    st.floats(-20.0, 20.0),
)
def test_a_constant_disturbance_is_found_without_error_or_limit_cycle(drive, wn, zeta, s1, size):
    """After 40 time constants the last 100 estimates are the disturbance: no chattering."""
    h = 1e-3
    observer = make(s1, 1.6 * np.sqrt(s1), wn**2, 2.0 * zeta * wn)
    slowest = wn * (zeta - np.sqrt(max(zeta**2 - 1.0, 0.0)))
    n = int(40.0 / (slowest * h)) + 200
    d, u = np.full(n, size), 3.0 * np.sin(np.arange(n))
    estimate = drive(observer, momentum(d, u, h), u, h)
    # Rounding of the growing momentum, over h.
    np.testing.assert_allclose(estimate[-100:], size, atol=1e-8 * (1.0 + abs(size)))


@settings(deadline=None, max_examples=60)
@given(gain_sets.filter(lambda gains: gains[0] > 0.0), periods, st.floats(-5.0, 5.0))
def test_a_sliding_observer_does_not_chatter_at_any_gains(drive, gains, h, size):
    """Explicit Euler cycles here for T2 = 0; implicitly the swing of sigma dies out."""
    s1, _, s2, t2 = gains
    # A pure integrator pair without any damping rings on, as its equations say it must.
    observer = make(s1, max(gains[1], 1.5 * np.sqrt(s1)), s2, t2)
    assume(s2 * h < 50.0 * max(t2, np.sqrt(s1)))
    reach = abs(size) / s1 + 0.2
    n = min(int(20.0 * reach / h), 60_000)
    assume(n < 60_000)
    d, u = np.full(n + 300, size), np.zeros(n + 300)
    estimate = drive(observer, momentum(d, u, h), u, h)
    tail = estimate[-100:]
    # What explicit Euler would leave is a swing of about h S1.
    assert np.ptp(tail) <= max(1e-3 * h * s1, 1e-7 * (1.0 + abs(size)))
    np.testing.assert_allclose(tail, size, atol=max(1e-3 * h * s1, 1e-6 * (1.0 + abs(size))))


@given(st.floats(1.0, 1e5), st.floats(0.0, 1e3), periods, st.integers(0, 100))
def test_without_sliding_it_is_the_linear_second_order_observer(drive, s2, t2, h, seed):
    """Written here as a 2 x 2 implicit linear system, solved by numpy."""
    rng = np.random.default_rng(seed)
    p, u = rng.normal(size=(2, 80))
    estimate = drive(make(0.0, 0.0, s2, t2), p, u, h)
    matrix = np.array([[1.0 + h * t2, -h], [h * s2, 1.0]])
    p_hat, sigma = p[0], 0.0
    for k in range(1, 80):
        right = [p_hat + h * u[k] + h * t2 * p[k], sigma + h * s2 * p[k]]
        p_hat, sigma = np.linalg.solve(matrix, right)
        assert estimate[k - 1] == pytest.approx(sigma, abs=1e-9 * (1.0 + h * s2 * 10.0))


@given(gain_sets, periods, st.floats(1e-3, 1e3))
def test_another_unit_of_effort_changes_nothing(drive, gains, h, k):
    """p, forcing and S1 by k, T1 by sqrt(k): the estimate by k."""
    s1, t1, s2, t2 = gains
    rng = np.random.default_rng(4)
    p, u = np.cumsum(rng.normal(size=60)) * 0.01, rng.normal(size=60)
    one = drive(make(s1, t1, s2, t2), p, u, h)
    other = drive(make(k * s1, np.sqrt(k) * t1, s2, t2), k * p, k * u, h)
    np.testing.assert_allclose(other, k * one, atol=1e-7 * k * (1.0 + np.abs(one).max()))


@given(st.floats(1.0, 1e5), st.floats(0.0, 1e3), periods)
def test_the_lag_filter_is_the_linear_observers_response_with_gain_one(drive, s2, t2, h):
    rng = np.random.default_rng(5)
    d, u = rng.normal(size=(2, 80))
    observer = make(0.0, 0.0, s2, t2)
    b, a = observer.lag_filter(h, 0)
    assert b.sum() / a.sum() == pytest.approx(1.0, rel=1e-6)
    estimate = drive(observer, momentum(d, u, h), u, h)
    np.testing.assert_allclose(estimate, lfilter(b, a, d[1:]), atol=1e-9)


def test_a_sliding_observer_with_clean_signals_has_no_lag_as_its_filter_says(drive):
    """|tau_e'| < S1: after reaching, the estimate is the mean disturbance of the last interval."""
    h, t = 1e-3, np.arange(3000) * 1e-3
    d, u = np.sin(2.0 * np.pi * t), np.cos(t)
    observer = make(20.0, 1.6 * np.sqrt(20.0), 0.0, 0.0)
    b, a = observer.lag_filter(h, 0)
    assert (b.tolist(), a.tolist()) == ([1.0], [1.0])
    estimate = drive(observer, momentum(d, u, h), u, h)
    np.testing.assert_allclose(estimate[1000:], d[1001:], atol=1e-9)


def test_a_nan_stays_with_its_joint_until_it_is_started_again(drive):
    gains = {
        'sliding': [1.0, 2.0],
        'sliding_root': [1.0, 2.0],
        'linear': [100.0, 200.0],
        'linear_damping': [10.0, 20.0],
    }
    rng = np.random.default_rng(6)
    p, u = rng.normal(size=(2, 50, 2))
    u[20, 0] = np.nan
    pair = drive(Sosml(gains), p, u, 1e-3)
    last = {name: values[1:] for name, values in gains.items()}
    np.testing.assert_array_equal(pair[:, 1:], drive(Sosml(last), p[:, 1:], u[:, 1:], 1e-3))
    assert np.flatnonzero(np.isnan(pair[:, 0])).tolist() == [19]
    first = {name: values[:1] for name, values in gains.items()}
    again = drive(Sosml(first), p[20:, :1], u[20:, :1], 1e-3)
    np.testing.assert_array_equal(pair[20:, :1], again)


def test_an_observer_that_cannot_move_is_refused():
    with pytest.raises(ConfigurationError, match='sliding > 0 or linear > 0 on each joint'):
        make(0.0, 1.0, 0.0, 1.0)
    with pytest.raises(ConfigurationError, match='one finite gain >= 0 for each joint'):
        Sosml(
            {
                'sliding': [1.0, 1.0],
                'sliding_root': [1.0],
                'linear': [1.0],
                'linear_damping': [1.0],
            }
        )
