# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""FO against the zero-order hold of its transfer function, and its noise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import StateSpace, cont2discrete, lfilter, lsim

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.kinds.first_order import FirstOrder

cutoffs = st.floats(0.1, 1e4)
periods = st.floats(1e-4, 0.05)


def momentum(disturbance, forcing, h):
    """Return the exact momentum under inputs held over each interval, p_0 = 0."""
    steps = h * (forcing[1:] + disturbance[1:])
    return np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])


@given(cutoffs, periods)
def test_a_held_disturbance_is_filtered_by_the_exact_zoh_of_c0_over_s_plus_c0(drive, c0, h):
    rng = np.random.default_rng(0)
    d, u = rng.normal(size=(2, 60, 1))
    estimate = drive(FirstOrder({'cutoff': [c0]}), momentum(d, u, h), u, h)[:, 0]
    A, B, _, _, _ = cont2discrete(tuple(np.array([[x]]) for x in (-c0, c0, 1.0, 0.0)), h, 'zoh')
    x, truth = 0.0, []
    for value in d[1:, 0]:
        x = A[0, 0] * x + B[0, 0] * value
        truth.append(x)
    # p is differenced: rounding of p over h.
    np.testing.assert_allclose(estimate, truth, atol=1e-10)


@given(cutoffs, periods, st.floats(-100.0, 100.0))
def test_a_constant_disturbance_is_found_without_error(drive, c0, h, size):
    """Within 40 time constants exp(-40) = 4e-18 is left: k0 = c0 leaks no inertial torque."""
    steps = int(np.ceil(40.0 / (c0 * h)))
    h, steps = (40.0 / (c0 * 4000), 4000) if steps > 4000 else (h, steps)
    p = np.arange(steps + 1) * h * (size + 3.0)
    estimate = drive(FirstOrder({'cutoff': [c0]}), p, np.full(steps + 1, 3.0), h)
    assert estimate[-1] == pytest.approx(size, abs=1e-9 * (1.0 + abs(size)))


@pytest.mark.parametrize(('c0', 'ratio'), [(4.5, 1.2), (40.0, 2.0), (300.0, 0.5)])
def test_a_second_gain_leaks_the_inertial_torque_as_the_formula_says(drive, c0, ratio):
    """
    The paper's (11)-(12) with k0 != c0, integrated as printed, z' = c0 (k0 p - z + u).

    It is c0 / (s + c0) tau_e + (k0 - c0) s / (s + c0) p: FO plus exactly that leak. p is linear
    between samples and u held, so both sides are exact; 1e-9 of the larger one.
    """
    rng = np.random.default_rng(7)
    h, k0, count = 1e-3, ratio * c0, 400
    t = h * np.arange(count)
    d, u = rng.normal(size=(2, count, 1))
    p = momentum(d, u, h)
    A, B = [[-c0]], [[c0]]
    from_p = lsim(StateSpace(A, B, [[1.0]], [[0.0]]), k0 * p, t)[1]
    held = np.append(u[1:], [[0.0]], axis=0)
    from_u = lsim(StateSpace(A, B, [[1.0]], [[0.0]]), held, t, interp=False)[1]
    two_gains = k0 * p[:, 0] - from_p - from_u
    # (k0 - c0) s / (s + c0) = (k0 - c0) (1 - c0 / (s + c0)).
    leak = lsim(StateSpace(A, B, [[c0 - k0]], [[k0 - c0]]), p, t)[1]
    estimate = drive(FirstOrder({'cutoff': [c0]}), p, u, h)[:, 0]
    assert np.abs(leak).max() > 0.01
    scale = max(1.0, np.abs(two_gains).max())
    np.testing.assert_allclose(two_gains[1:], estimate + leak[1:], atol=1e-9 * scale)


def test_acceleration_that_the_forcing_explains_is_not_taken_for_a_disturbance(drive):
    """With k0 = c0 the observer is blind to p itself: a momentum ramp of its own effort is 0."""
    h, u = 1e-3, np.full(500, 7.0)
    estimate = drive(FirstOrder({'cutoff': [30.0]}), 2.0 + h * 7.0 * np.arange(500), u, h)
    assert np.abs(estimate).max() < 1e-10


@pytest.mark.parametrize('c0', [4.5, 40.0, 400.0])
def test_momentum_noise_comes_out_as_the_docstring_says(drive, c0):
    """(1 - a) / h sqrt(2 / (1 + a)) s; 4e5 samples, correlated over 1 / (c0 h): within 2 %."""
    h, s = 1e-3, 0.02
    noise = np.random.default_rng(1).normal(scale=s, size=(400_000, 1))
    observer = FirstOrder({'cutoff': [c0]})
    b, a = observer.lag_filter(h, 0)
    out = lfilter(b, a, np.diff(noise[:, 0]) / h)
    # The observer itself, on the first part, is that filter.
    estimate = drive(observer, noise[:2000], np.zeros((2000, 1)), h)
    np.testing.assert_allclose(estimate[:, 0], out[:1999], atol=1e-10)
    pole = np.exp(-c0 * h)
    predicted = (1 - pole) / h * np.sqrt(2 / (1 + pole)) * s
    assert out[2000:].std() == pytest.approx(predicted, rel=0.02)
    if c0 * h < 0.05:
        assert predicted == pytest.approx(c0 * s, rel=0.02)


@given(cutoffs, periods)
def test_the_lag_filter_is_the_response_and_has_gain_one_at_rest(drive, c0, h):
    rng = np.random.default_rng(2)
    d, u = rng.normal(size=(2, 50, 1))
    observer = FirstOrder({'cutoff': [c0]})
    b, a = observer.lag_filter(h, 0)
    assert b.sum() / a.sum() == pytest.approx(1.0, rel=1e-9)
    estimate = drive(observer, momentum(d, u, h), u, h)[:, 0]
    np.testing.assert_allclose(estimate, lfilter(b, a, d[1:, 0]), atol=1e-10)


def test_joints_have_their_own_gains_and_a_nan_stays_with_its_joint(drive):
    rng = np.random.default_rng(3)
    p, u = rng.normal(size=(2, 50, 2))
    u[20, 0] = np.nan
    pair = drive(FirstOrder({'cutoff': [10.0, 200.0]}), p, u, 1e-3)
    alone = drive(FirstOrder({'cutoff': [200.0]}), p[:, 1:], u[:, 1:], 1e-3)
    np.testing.assert_array_equal(pair[:, 1:], alone)
    # Row 19 of the estimates ends the interval without forcing; the joint starts again there.
    assert np.flatnonzero(np.isnan(pair[:, 0])).tolist() == [19]
    again = drive(FirstOrder({'cutoff': [10.0]}), p[20:, :1], u[20:, :1], 1e-3)
    np.testing.assert_array_equal(pair[20:, :1], again)


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
