# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""FO against the zero-order hold of its transfer function, and its noise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import cont2discrete, lfilter

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.first_order import FirstOrder

cutoffs = st.floats(0.1, 1e4)
periods = st.floats(1e-4, 0.05)


def run(observer, p, forcing, h):
    observer.start(p[0], np.ones(observer.n, dtype=bool))
    return np.array([observer.step(p[k], forcing[k], h).copy() for k in range(1, len(p))])


def momentum(disturbance, forcing, h):
    """Return the exact momentum under inputs held over each interval, p_0 = 0."""
    steps = h * (forcing[1:] + disturbance[1:])
    return np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])


@given(cutoffs, periods)
def test_a_held_disturbance_is_filtered_by_the_exact_zoh_of_c0_over_s_plus_c0(c0, h):
    rng = np.random.default_rng(0)
    d, u = rng.normal(size=(2, 60, 1))
    estimate = run(FirstOrder({'cutoff': [c0]}), momentum(d, u, h), u, h)[:, 0]
    A, B, _, _, _ = cont2discrete(tuple(np.array([[x]]) for x in (-c0, c0, 1.0, 0.0)), h, 'zoh')
    x, truth = 0.0, []
    for value in d[1:, 0]:
        x = A[0, 0] * x + B[0, 0] * value
        truth.append(x)
    # p is differenced: rounding of p over h.
    np.testing.assert_allclose(estimate, truth, atol=1e-10)


@given(cutoffs, periods, st.floats(-100.0, 100.0))
def test_a_constant_disturbance_is_found_without_error(c0, h, size):
    """Within 40 time constants exp(-40) = 4e-18 is left: k0 = c0 leaks no inertial torque."""
    steps = int(np.ceil(40.0 / (c0 * h)))
    h, steps = (40.0 / (c0 * 4000), 4000) if steps > 4000 else (h, steps)
    observer = FirstOrder({'cutoff': [c0]})
    observer.start(np.zeros(1), np.ones(1, dtype=bool))
    for k in range(1, steps + 1):
        estimate = observer.step(np.array([k * h * (size + 3.0)]), np.array([3.0]), h)
    assert estimate[0] == pytest.approx(size, abs=1e-9 * (1.0 + abs(size)))


def test_acceleration_that_the_forcing_explains_is_not_taken_for_a_disturbance():
    """With k0 = c0 the observer is blind to p itself: a momentum ramp of its own effort is 0."""
    observer, h, u = FirstOrder({'cutoff': [30.0]}), 1e-3, np.array([7.0])
    observer.start(np.array([2.0]), np.ones(1, dtype=bool))
    for k in range(1, 500):
        assert abs(observer.step(2.0 + k * h * u, u, h)[0]) < 1e-10


@pytest.mark.parametrize('c0', [4.5, 40.0, 400.0])
def test_momentum_noise_comes_out_as_the_docstring_says(c0):
    """(1 - a) / h sqrt(2 / (1 + a)) s; 4e5 samples, correlated over 1 / (c0 h): within 2 %."""
    h, s = 1e-3, 0.02
    noise = np.random.default_rng(1).normal(scale=s, size=(400_000, 1))
    observer = FirstOrder({'cutoff': [c0]})
    b, a = observer.lag_filter(h, 0)
    out = lfilter(b, a, np.diff(noise[:, 0]) / h)
    # The observer itself, on the first part, is that filter.
    estimate = run(observer, noise[:2000], np.zeros((2000, 1)), h)
    np.testing.assert_allclose(estimate[:, 0], out[:1999], atol=1e-10)
    pole = np.exp(-c0 * h)
    predicted = (1 - pole) / h * np.sqrt(2 / (1 + pole)) * s
    assert out[2000:].std() == pytest.approx(predicted, rel=0.02)
    if c0 * h < 0.05:
        assert predicted == pytest.approx(c0 * s, rel=0.02)


@given(cutoffs, periods)
def test_the_lag_filter_is_the_response_and_has_gain_one_at_rest(c0, h):
    rng = np.random.default_rng(2)
    d, u = rng.normal(size=(2, 50, 1))
    observer = FirstOrder({'cutoff': [c0]})
    b, a = observer.lag_filter(h, 0)
    assert b.sum() / a.sum() == pytest.approx(1.0, rel=1e-9)
    estimate = run(observer, momentum(d, u, h), u, h)[:, 0]
    np.testing.assert_allclose(estimate, lfilter(b, a, d[1:, 0]), atol=1e-10)


def test_joints_have_their_own_gains_and_a_nan_stays_with_its_joint():
    h = 1e-3
    both = FirstOrder({'cutoff': [10.0, 200.0]})
    alone = FirstOrder({'cutoff': [200.0]})
    both.start(np.zeros(2), np.ones(2, dtype=bool))
    alone.start(np.zeros(1), np.ones(1, dtype=bool))
    rng = np.random.default_rng(3)
    for k in range(50):
        p, u = rng.normal(size=2), rng.normal(size=2)
        if k == 20:
            u[0] = np.nan
        pair = both.step(p, u, h)
        np.testing.assert_array_equal(pair[1:], alone.step(p[1:], u[1:], h))
        assert np.isnan(pair[0]) == (k >= 20)
    both.start(np.ones(2), np.array([True, False]))
    pair = both.step(np.ones(2), np.zeros(2), h)
    assert pair[0] == 0.0


@pytest.mark.parametrize(
    ('gains', 'words'),
    [
        ({}, 'missing cutoff, unknown none'),
        ({'cutoff': [1.0], 'pole': [1.0]}, 'unknown pole'),
        ({'cutoff': [0.0]}, 'must be positive'),
        ({'cutoff': [-1.0]}, 'one finite gain >= 0'),
        ({'cutoff': [float('nan')]}, 'one finite gain >= 0'),
        ({'cutoff': [float('inf')]}, 'one finite gain >= 0'),
        ({'cutoff': 40.0}, 'for each joint'),
        ({'cutoff': [[40.0]]}, 'for each joint'),
        ({'cutoff': ['fast']}, 'list of numbers'),
        ({'cutoff': None}, 'for each joint'),
    ],
)
def test_gains_that_make_no_sense_are_refused_in_one_sentence(gains, words):
    with pytest.raises(ConfigurationError, match=words) as caught:
        FirstOrder(gains)
    assert '\n' not in str(caught.value)
