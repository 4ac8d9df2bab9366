# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The filter and its way back against the normal distribution of all states at once."""

import numpy as np
import pytest

from sosml_friction.identification.motion_filter import smooth_motion

COUNT = 6


def problem(n):
    rng = np.random.default_rng(n)
    root = 0.3 * rng.standard_normal((COUNT - 1, n, n)) + np.eye(n)
    return {
        'h': rng.uniform(0.01, 0.02, COUNT - 1),
        'q': np.cumsum(0.01 * rng.standard_normal((COUNT, n)), axis=0),
        'mobility': 5.0 * root @ np.swapaxes(root, 1, 2),
        'drive': rng.standard_normal((COUNT - 1, n)),
        # Friction that falls with speed as well.
        'slope': rng.uniform(-2.0, 8.0, (COUNT - 1, n)),
        'white': rng.uniform(0.01, 0.1, (COUNT - 1, n)),
        'friction': rng.uniform(0.01, 0.04, n),
        'kept': rng.uniform(0.8, 0.9, COUNT - 1),
        'position': rng.uniform(1e-6, 1e-5, (COUNT, n)),
        'slow': 0.1 * rng.standard_normal((COUNT, n)),
        'free': rng.uniform(size=(COUNT, n)) < 0.5,
        'counted': np.ones((COUNT, n), dtype=bool),
        'velocity': rng.uniform(0.01, 0.1, n),
    }


def all_at_once(p):
    """Return the means and variances of velocity, and the likelihood of the measurements."""
    n = p['q'].shape[1]
    m = 3 * n
    mean, spread = np.zeros((COUNT, m)), np.zeros((COUNT, m, COUNT, m))
    mean[0, :n], mean[0, n : 2 * n] = p['q'][0], p['slow'][0]
    spread[0, :, 0] = np.diag(np.concatenate([p['position'][0], p['velocity'], p['friction']]))
    for k in range(1, COUNT):
        h, one = p['h'][k - 1], np.eye(n)
        X = h * p['mobility'][k - 1] * p['slope'][k - 1]
        F = np.linalg.inv(one + X + 0.5 * X @ X)
        G = h * F @ (one + 0.5 * X) @ p['mobility'][k - 1]
        zero, keeps = np.zeros((n, n)), p['kept'][k - 1] * one
        A = np.block(
            [
                [one, 0.5 * h * (one + F), -0.5 * h * G],
                [zero, F, -G],
                [zero, zero, keeps],
            ]
        )
        B = np.vstack([0.5 * h * G, G, zero])
        mean[k] = A @ mean[k - 1] + B @ p['drive'][k - 1]
        spread[k, :, :k] = np.einsum('ab,bjc->ajc', A, spread[k - 1, :, :k])
        spread[:k, :, k] = np.moveaxis(spread[k, :, :k], 0, 2)
        fresh = np.zeros((m, m))
        fresh[2 * n :, 2 * n :] = np.diag(p['friction'] * (1.0 - p['kept'][k - 1] ** 2))
        spread[k, :, k] = (
            A @ spread[k - 1, :, k - 1] @ A.T + B @ np.diag(p['white'][k - 1]) @ B.T + fresh
        )
    picks, values, noise = [], [], []
    for k in range(1, COUNT):
        for i in range(n):
            picks.append(k * m + i)
            values.append(p['q'][k, i])
            noise.append(p['position'][k, i])
            if p['free'][k, i]:
                picks.append(k * m + n + i)
                values.append(p['slow'][k, i])
                noise.append(p['velocity'][i])
    S = spread.reshape(COUNT * m, COUNT * m)
    total = S[np.ix_(picks, picks)] + np.diag(noise)
    gain = np.linalg.solve(total, S[picks]).T
    error = np.array(values) - mean.ravel()[picks]
    v = (mean.ravel() + gain @ error).reshape(COUNT, m)[:, n : 2 * n]
    variance = np.diag(S - gain @ S[picks]).reshape(COUNT, m)[:, n : 2 * n]
    likelihood = -0.5 * (error @ np.linalg.solve(total, error) + np.linalg.slogdet(total)[1])
    return v, variance, likelihood


@pytest.mark.parametrize('n', [1, 2, 3])
def test_velocities_are_those_given_all_measurements(n):
    p = problem(n)
    v, variance, _ = smooth_motion(*p.values(), True)
    expected, spread, _ = all_at_once(p)
    # Rounding, which the conditioning of all measurements at once makes larger.
    np.testing.assert_allclose(v, expected, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(variance, spread, rtol=1e-7)


@pytest.mark.parametrize('n', [1, 2])
def test_the_likelihood_is_that_of_all_positions(n):
    p = problem(n)
    p['free'][:] = False
    likelihood = smooth_motion(*p.values(), False)[2]
    assert likelihood == pytest.approx(all_at_once(p)[2], rel=1e-9)
    assert likelihood == smooth_motion(*p.values(), True)[2]


def test_innovations_that_do_not_count_are_left_out_of_the_likelihood():
    p = problem(1)
    p['counted'][:] = False
    assert smooth_motion(*p.values(), False)[2] == 0.0
