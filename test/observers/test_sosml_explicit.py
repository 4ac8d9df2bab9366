# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's explicit form against a loop written here, and its limit cycle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.kinds.sosml import Sosml
from sosml_friction.observers.kinds.sosml_explicit import SosmlExplicit

H = 1e-3


def make(s1, t1, s2, t2, eps):
    return SosmlExplicit(
        {
            'sliding': [s1],
            'sliding_root': [t1],
            'linear': [s2],
            'linear_damping': [t2],
            'boundary': [eps],
        }
    )


def explicit(p, u, h, s1, t1, s2, t2, sign):
    """Return sigma after each interval: explicit Euler of the corrected (15)-(16), any sign."""
    p_hat, sigma, result = p[0], 0.0, []
    for k in range(1, len(p)):
        e = p_hat - p[k - 1]
        rate = u[k] + sigma - t1 * np.sqrt(abs(e)) * sign(e) - t2 * e
        sigma_rate = -s1 * sign(e) - s2 * e
        p_hat, sigma = p_hat + h * rate, sigma + h * sigma_rate
        result.append(sigma)
    return np.array(result)


def driven(seed, count=2000):
    """Return a momentum under a disturbance with jumps, with noise, and its forcing."""
    rng = np.random.default_rng(seed)
    t = H * np.arange(count)
    d, u = np.sign(np.sin(7.0 * t)), 2.0 * np.cos(5.0 * t)
    p = np.concatenate([[0.1], 0.1 + H * np.cumsum((d + u)[1:])])
    return p + rng.normal(scale=3e-4, size=count), u


@given(
    st.floats(0.0, 400.0),
    st.floats(0.0, 30.0),
    st.floats(1.0, 2000.0),
    st.floats(0.0, 100.0),
    st.floats(1e-2, 1.0),
)
def test_it_is_the_loop_written_here(drive, s1, t1, s2, t2, eps):
    """1e-12 of the largest estimate while nothing diverges: 200 steps round differently."""
    p, u = (x[:200] for x in driven(0))
    estimate = drive(make(s1, t1, s2, t2, eps), p, u, H)

    def s_eps(e):
        return np.sign(e) if abs(e) > eps else e / eps

    expected = explicit(p, u, H, s1, t1, s2, t2, s_eps)
    np.testing.assert_allclose(estimate, expected, atol=1e-12 * (1.0 + np.abs(expected).max()))


def tail_swing(drive, observer, count=20_000):
    """Return the swing of the last 500 estimates of a constant, met with an error of 1e-6."""
    p, u = np.zeros(count), np.full(count, -0.7)
    p[0] = 1e-6
    return np.ptp(drive(observer, p, u, H)[-500:])


@pytest.mark.parametrize(
    ('s1', 't1', 's2', 'eps'),
    [
        (400.0, 32.0, 0.0, 1e-3),
        (400.0, 32.0, 1000.0, 1e-2),
        (50.0, 11.3, 0.0, 1e-3),
        (1000.0, 50.6, 0.0, 1e-2),
    ],
)
def test_below_the_stated_damping_it_cycles_and_the_implicit_step_never_does(
    drive, s1, t1, s2, eps
):
    """
    T2 = 0.8 and 1.2 times h (S1 / eps + S2); the disturbance is constant and there is no noise.

    Explicit Euler swings in the first case and settles in the second, to rounding times the
    stiffness. The implicit step with the same gains, and with T2 = 0, does not swing.
    """
    bound = H * (s1 / eps + s2)
    cycling, settling = (make(s1, t1, s2, factor * bound, eps) for factor in (0.8, 1.2))
    assert cycling.locally_stable(H).tolist() == [False]
    assert settling.locally_stable(H).tolist() == [True]
    assert tail_swing(drive, cycling) > 1e-4
    assert tail_swing(drive, settling) < 1e-9
    for t2 in (0.0, 0.8 * bound):
        gains = {'sliding': s1, 'sliding_root': t1, 'linear': s2, 'linear_damping': t2}
        implicit = Sosml({name: [gain] for name, gain in gains.items()})
        assert tail_swing(drive, implicit) < 1e-9


@given(st.floats(0.0, 400.0), st.floats(1.0, 1e4), st.floats(1.0, 3e3), st.floats(1e-3, 1.0))
def test_local_stability_is_that_of_the_linearised_steps_eigenvalues(s1, s2, t2, eps):
    observer = make(s1, 1.0, s2, t2, eps)
    K = s1 / eps + s2
    matrix = np.array([[1.0 - H * t2, H], [-H * K, 1.0]])
    radius = np.abs(np.linalg.eigvals(matrix)).max()
    # At the border itself rounding decides.
    if abs(radius - 1.0) > 1e-9:
        assert observer.locally_stable(H).tolist() == [radius < 1.0]


@given(st.floats(0.0, 2.0), st.floats(100.0, 3e3), st.floats(1.1, 5.0))
def test_the_lag_filter_is_the_response_to_a_small_disturbance(
    drive, held_momentum, s1, s2, factor
):
    """Without the root term (its slope is zero), inside the layer, it is linear."""
    eps = 1.0
    observer = make(s1, 0.0, s2, factor * H * (s1 / eps + s2), eps)
    b, a = observer.lag_filter(H, 0)
    assert b.sum() / a.sum() == pytest.approx(1.0, rel=1e-9)
    d = 1e-3 * np.random.default_rng(3).normal(size=300)
    estimate = drive(observer, held_momentum(d, 0.0 * d, H), 0.0 * d, H)
    np.testing.assert_allclose(estimate, lfilter(b, a, d[1:]), atol=1e-10)


def test_an_observer_that_cycles_is_taken_to_have_no_lag():
    b, a = make(400.0, 32.0, 0.0, 0.0, 1e-3).lag_filter(H, 0)
    assert (b.tolist(), a.tolist()) == ([1.0], [1.0])


def test_an_estimate_that_diverges_is_nan_and_starts_afresh(drive):
    """T2 h = 50: the error grows by 49 a step and overflows after about 180, again and again."""
    p, u = driven(4, 700)
    with np.errstate(all='raise'):
        estimate = drive(make(1.0, 1.0, 100.0, 5e4, 1e-2), p, u, H)
    lost = np.flatnonzero(np.isnan(estimate))
    assert len(lost) >= 2
    assert np.diff(lost).min() > 100
    assert not np.isinf(estimate).any()
    fresh = drive(make(1.0, 1.0, 100.0, 5e4, 1e-2), p[lost[0] + 1 :], u[lost[0] + 1 :], H)
    np.testing.assert_array_equal(estimate[lost[0] + 1 :], fresh)


def test_a_nan_stays_with_its_joint_until_it_is_started_again(drive):
    rng = np.random.default_rng(6)
    p, u = rng.normal(size=(2, 50, 2))
    u[20, 0] = np.nan
    values = (1.0, 1.0, 100.0, 10.0, 0.1)
    names = SosmlExplicit.gain_units
    pair = drive(
        SosmlExplicit({name: [x, 2.0 * x] for name, x in zip(names, values, strict=True)}), p, u, H
    )
    second = make(*(2.0 * x for x in values))
    np.testing.assert_array_equal(pair[:, 1], drive(second, p[:, 1], u[:, 1], H))
    assert np.flatnonzero(np.isnan(pair[:, 0])).tolist() == [19]
    again = drive(make(*values), p[20:, 0], u[20:, 0], H)
    np.testing.assert_array_equal(pair[20:, 0], again)


def test_an_observer_that_cannot_move_or_has_no_layer_is_refused():
    with pytest.raises(ConfigurationError, match='observer sosml_explicit needs sliding > 0 or'):
        make(0.0, 1.0, 0.0, 1.0, 1.0)
    with pytest.raises(ConfigurationError, match='gain boundary of observer sosml_explicit'):
        make(1.0, 1.0, 1.0, 1.0, 0.0)
