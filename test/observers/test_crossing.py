# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The chance of a change of sign against drawn samples, Rice's rate and its own sum."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.observers.crossing import crossing_probability


def states(p, tau, variance):
    """Return x and P of joints with these momenta, disturbances and variances of momentum."""
    n = len(p)
    x, P = np.zeros((n, 3)), np.zeros((n, 3, 3))
    x[:, 1], x[:, 2] = p, tau
    P[:, 0, 0] = P[:, 2, 2] = 1.0
    P[:, 1, 1] = variance
    return x, P


def test_it_is_the_share_of_drawn_velocities_that_change_their_sign():
    """Three coupled joints, 1e6 draws of all momenta: within 5 standard errors, 5 sqrt(pi / N)."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    mobility = np.linalg.inv(root @ root.T + np.eye(3))
    p, tau, u = rng.normal(size=(3, 3))
    variance, h = np.array([0.3, 0.1, 0.5]), 0.4
    x, P = states(p, tau, variance)
    drawn = p + np.sqrt(variance) * rng.normal(size=(1_000_000, 3))
    before = drawn @ mobility.T
    after = (drawn + h * (u + tau)) @ mobility.T
    for i in range(3):
        share = np.mean(np.sign(before[:, i]) != np.sign(after[:, i]))
        found = crossing_probability(x, P, mobility[i], u, h)
        assert found == pytest.approx(share, abs=5.0 * np.sqrt(share / 1e6))
        assert share > 0.01


@given(
    st.floats(1e-3, 1e3), st.floats(1e-9, 1.0), st.integers(1, 400), st.sampled_from([-1.0, 1.0])
)
def test_over_one_passage_it_adds_up_to_one(force, deviation, steps, direction):
    """However fast the passage, however coarse the sampling, however good the encoder: 1e-12."""
    mobility = np.array([2.0])
    reach = 8.0 * deviation
    h = 2.0 * reach / (force * steps)
    total = 0.0
    for k in range(steps):
        p = direction * (-reach + h * force * k)
        x, P = states([p], [0.0], deviation**2)
        total += crossing_probability(x, P, mobility, np.array([direction * force]), h)
    assert total == pytest.approx(1.0, abs=1e-12)


@given(st.floats(-3.0, 3.0), st.floats(0.1, 10.0))
def test_over_a_short_interval_it_is_rices_rate(v, force):
    """|a| N(0; v, s^2) h, the next term being h a v / (2 s^2) of it: 1e-5 at h = 1e-6."""
    s, h = 0.7, 1e-6
    x, P = states([v], [0.0], s**2)
    rate = force * np.exp(-0.5 * (v / s) ** 2) / (s * np.sqrt(2.0 * np.pi))
    found = crossing_probability(x, P, np.ones(1), np.array([force]), h)
    assert found == pytest.approx(rate * h, rel=1e-4)


def test_no_joint_crosses_without_force_or_doubt():
    mobility = np.linalg.inv(np.array([[0.4, 0.1], [0.1, 0.1]]))
    x, P = states([1e-6, 0.0], [-0.3, 0.7], [1e-6, 1e-6])
    assert crossing_probability(x, P, mobility[0], np.array([0.3, -0.7]), 1e-3) == 0.0
    x, P = states([-1e-6, 0.0], [0.0, 0.0], [0.0, 0.0])
    assert crossing_probability(x, P, mobility[0], np.array([9.0, 9.0]), 1e-3) == 0.0


def test_a_joint_of_unknown_force_keeps_its_momentum_and_a_wild_one_is_left_out():
    mobility = np.linalg.inv(np.array([[0.4, 0.1], [0.1, 0.1]]))
    x, P = states([0.01, -0.02], [0.1, 0.2], [1e-3, 1e-3])
    unknown = crossing_probability(x, P, mobility[0], np.array([3.0, np.nan]), 1e-2)
    assert unknown == crossing_probability(x, P, mobility[0], np.array([3.0, -0.2]), 1e-2) > 0.0
    x[1] = 1e308
    assert crossing_probability(x, P, np.array([1.0, 0.0]), np.array([3.0, 1e308]), 1e-2) == 0.0
