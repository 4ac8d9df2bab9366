# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The wrong model: consistent in itself, and wrong by exactly what it says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.study.condition import observe
from sosml_friction.study.mismatched_robot import MismatchedRobot
from sosml_friction.study.plant import ARMATURE, JOINTS, study_urdf

OFFSET = np.array([0.10, 0.05])


@pytest.fixture(scope='module')
def make():
    return lambda scale, offset=OFFSET: MismatchedRobot(
        study_urdf(), JOINTS, ARMATURE, scale, offset
    )


@given(st.integers(0, 1000), st.sampled_from([0.9, 1.1]))
def test_its_equations_belong_together(study_arm, make, seed, scale):
    rng = np.random.default_rng(seed)
    q, v, a = rng.normal(size=(3, 2))
    wrong = make(scale)
    M, C, g = wrong.inertia(q), wrong.coriolis(q, v), wrong.gravity(q)
    np.testing.assert_allclose(M, scale * study_arm.inertia(q), rtol=1e-13)
    np.testing.assert_allclose(g, study_arm.gravity(q) + OFFSET, rtol=1e-13)
    p, drift, inertia = wrong.momentum_terms(q, v)
    np.testing.assert_allclose(p, M @ v, atol=1e-13)
    np.testing.assert_allclose(drift, C.T @ v - g, atol=1e-12)
    np.testing.assert_allclose(inertia, M, atol=1e-15)
    tau = wrong.inverse_dynamics(q, v, a)
    np.testing.assert_allclose(tau, M @ a + C @ v + g, atol=1e-12)
    np.testing.assert_allclose(wrong.acceleration(q, v, tau), a, atol=1e-10)
    # M' = C + C^T, along v, by a central difference.
    h = 1e-5
    slope = (wrong.inertia(q + h * v) - wrong.inertia(q - h * v)) / (2.0 * h)
    np.testing.assert_allclose(slope, C + C.T, atol=1e-8)
    # Power: v (tau - M a - C v - g) = 0 is dE/dt = v tau for motion without friction.
    q1, v1, q0, v0 = q + h * v, v + h * a, q - h * v, v - h * a
    rate = (wrong.energy(q1, v1) - wrong.energy(q0, v0)) / (2.0 * h)
    assert rate == pytest.approx(v @ tau, abs=1e-6)


def test_without_mismatch_it_is_the_robot(study_arm, make):
    right = make(1.0, (0.0, 0.0))
    q, v = np.array([-0.7, 1.1]), np.array([0.4, -1.3])
    for ours, theirs in zip(
        right.momentum_terms(q, v), study_arm.momentum_terms(q, v), strict=True
    ):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize('index', [0, 1])
@pytest.mark.parametrize('name', ['slow', 'reversal'])
def test_the_disturbance_it_sees_is_the_derived_one(study_arm, study_runs, name, index):
    """
    Compare with the observer-free residual (p_k - p_{k-1}) / h - u_k of the samples.

    That of the wrong model minus that of the right one is d/dt(dM q') - dC^T q' + dg over each
    interval, and minus it the error of the reported friction. (s - 1)(M q'' + C q') jumps by up to
    1 % of the effort's steps at a sample; away from reversals means over two samples agree.
    """
    run = study_runs[name]

    def residual(observation):
        p = np.vstack([observation.p_start, observation.samples.p])
        s = observation.samples
        return np.diff(p, axis=0) / s.h[:, None] - s.forcing

    (right,) = observe(run, study_arm, 'nominal', 16, ())
    wrong = observe(run, study_arm, 'mismatch', 16, ())[index]
    seen = residual(right) - residual(wrong)
    mean_floor = 0.5 * (wrong.floor[1:] + wrong.floor[:-1])
    difference = (seen[1:] - mean_floor)[600:]
    assert np.sqrt(np.mean(difference**2)) < 0.004
    assert np.sqrt(np.mean(mean_floor[600:, 0] ** 2)) > 0.09
    # Without mismatch the residual is -tau_f over the interval, whatever the observer.
    friction = 0.5 * (right.friction[1:] + right.friction[:-1])
    assert np.sqrt(np.mean((residual(right)[1:] + friction)[600:] ** 2)) < 0.004
