# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Velocities smoothed by the torque: what they are in closed form, and what they do not invent."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from sosml_friction.identification.velocity_smoother import JointNoise, VelocitySmoother
from sosml_friction.model.laws import make_friction_law
from sosml_friction.observers.momentum_samples import MomentumSamples

STEP, COUNT, LASTING = 2e-3, 300, 0.1
INERTIA = np.array([[0.4, 0.1], [0.1, 0.05]])
POSITION, EFFORT, FRICTION = 5e-5, 0.02, 0.01


def stretch(torque, q):
    """Return intervals of two joints that a torque drives."""
    n = q.shape[1]
    inertia = np.broadcast_to(INERTIA[:n, :n], (COUNT, n, n)).copy()
    zero = np.zeros((COUNT, n))
    return MomentumSamples(np.full(COUNT, STEP), zero, zero, torque, inertia)


def smoother(torque, q, v, laws, inertia_factor=1.0):
    noise = JointNoise(POSITION, EFFORT, FRICTION, 1e-2, 1e-3, LASTING)
    n = q.shape[1]
    # The velocities to begin with are no means over a window: each is a sample's own.
    return VelocitySmoother(
        stretch(torque, q), q, v, laws, [noise] * n, np.full(n, inertia_factor), 0
    )


def driven(seed, scale=1.0):
    """Return torque, true velocity and rounded position of two joints with viscous friction."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(COUNT)[:, None]
    torque = scale * np.sin(2.0 * np.pi * 24.0 * t + np.array([0.0, 1.0])) + np.array([0.1, 0.03])
    v, d = np.zeros((COUNT + 1, 2)), np.zeros(2)
    v[0] = [0.2, 0.15]
    kept = np.exp(-STEP / LASTING)
    # M v' = u - D v with u held over an interval, solved exactly.
    damping = np.diag([0.5, 0.2])
    decay = expm(-STEP * np.linalg.solve(INERTIA, damping))
    gain = (np.eye(2) - decay) @ np.linalg.inv(damping)
    for k in range(COUNT):
        white = rng.normal(0.0, EFFORT, 2)
        v[k + 1] = decay @ v[k] + gain @ (torque[k] + white - d)
        d = kept * d + rng.normal(0.0, FRICTION * np.sqrt(1.0 - kept**2), 2)
    q = np.vstack([np.zeros(2), np.cumsum(0.5 * STEP * (v[1:] + v[:-1]), axis=0)])
    return torque, v, q + rng.normal(0.0, POSITION, q.shape)


VISCOUS = [
    make_friction_law('coulomb_viscous', {'coulomb': 0.0, 'viscous': B, 'bias': 0.0}, 0.0)
    for B in (0.5, 0.2)
]


def test_a_linear_joint_s_velocities_are_those_of_generalised_least_squares():
    """The oracle: all unknown noises at once, by the normal equations of the whole stretch."""
    torque, v, q = driven(1)
    torque, q = torque[:, :1], q[:, :1]
    own = smoother(torque, q, v[:, :1], VISCOUS[:1])
    own._weigh = lambda problem: None
    found, variance = own.run()

    # Unknowns: q_0, v_0, d_0 and the noises w_k, e_k of each interval; all with a known variance.
    kept, M, B = np.exp(-STEP / LASTING), INERTIA[0, 0], 0.5
    unknowns = 3 + 2 * COUNT
    X = STEP * B / M
    inverse = 1.0 / (1.0 + X + 0.5 * X * X)
    gain = STEP * inverse * (1.0 + 0.5 * X) / M
    prior = np.array(
        [POSITION**2, 1e-4, FRICTION**2]
        + [EFFORT**2] * COUNT
        + [FRICTION**2 * (1.0 - kept**2)] * COUNT
    )
    rows_q, rows_v, rows_d = (np.eye(unknowns)[k] for k in range(3))
    known_q, known_v = q[0, 0], v[0, 0]
    Q, V, kq, kv = [rows_q], [rows_v], [known_q], [known_v]
    for k in range(COUNT):
        white = np.eye(unknowns)[3 + k]
        after_v = inverse * V[-1] - gain * rows_d + gain * white
        after_kv = inverse * kv[-1] + gain * torque[k, 0]
        Q.append(Q[-1] + 0.5 * STEP * (V[-1] + after_v))
        kq.append(kq[-1] + 0.5 * STEP * (kv[-1] + after_kv))
        V.append(after_v)
        kv.append(after_kv)
        rows_d = kept * rows_d + np.eye(unknowns)[3 + COUNT + k]
    Q, V, kq, kv = (np.array(x) for x in (Q, V, kq, kv))
    # The position of the first sample is the prior of q_0.
    information = np.diag(1.0 / prior) + Q[1:].T @ Q[1:] / POSITION**2
    posterior = np.linalg.inv(information)
    theta = posterior @ (Q[1:].T @ (q[1:, 0] - kq[1:]) / POSITION**2)
    np.testing.assert_allclose(found[:, 0], kv + V @ theta, rtol=0, atol=1e-6)
    np.testing.assert_allclose(
        variance[:, 0], np.einsum('ki,ij,kj->k', V, posterior, V), rtol=1e-4
    )


def test_errors_of_coupled_joints_are_as_large_as_they_say():
    """Over 20 seeds the mean square of error over standard error is one, 3 sd of it around."""
    ratios = []
    for seed in range(20):
        torque, v, q = driven(seed)
        rough = v + np.random.default_rng(100 + seed).normal(0.0, 1e-2, v.shape)
        own = smoother(torque, q, rough, VISCOUS)
        own._weigh = lambda problem: None
        found, variance = own.run()
        ratios.append(np.mean((found - v) ** 2 / variance))
    # Velocities of one run hang together: the scatter over seeds is what there is.
    assert abs(np.mean(ratios) - 1.0) <= 3.0 * np.std(ratios) / np.sqrt(len(ratios)) + 0.05


def test_a_velocity_that_the_torque_does_not_make_surer_stays_as_it_was():
    """A torque that says nothing, and a velocity that is as good as it claims."""
    torque, v, q = driven(1)
    own = smoother(torque + np.random.default_rng(1).normal(0.0, 0.5, q[1:].shape), q, v, VISCOUS)
    own.noise = [replace(each, velocity=1e-4) for each in own.noise]
    found, variance = own.run()
    assert np.isnan(variance).all()
    np.testing.assert_array_equal(found, v)


def test_a_velocity_that_is_wrong_by_more_than_its_noise_is_replaced():
    """Ripple that a fine encoder shows and a slope over a window hides: noise is not its error."""
    torque, v, q = driven(1)
    hidden = np.broadcast_to(np.mean(v, axis=0), v.shape).copy()
    own = smoother(torque, q, hidden, VISCOUS)
    own.noise = [replace(each, velocity=1e-7) for each in own.noise]
    found, variance = own.run()
    assert np.isfinite(variance).all()
    assert np.std(found - v) < 0.3 * np.std(hidden - v)


def test_an_effort_that_is_missing_for_a_while_widens_the_variance_and_no_more():
    torque, v, q = driven(1)
    own = smoother(torque, q, v, VISCOUS)
    own._weigh = lambda problem: None
    whole = own.run()[1]
    holed = torque.copy()
    holed[100:120] = np.nan
    own = smoother(holed, q, v, VISCOUS)
    own._weigh = lambda problem: None
    found, variance = own.run()
    assert np.isfinite(found).all()
    assert (variance[102:118] > whole[102:118]).all()
    np.testing.assert_allclose(variance[280:], whole[280:], rtol=1e-2)


@pytest.mark.parametrize('longest', [100, 4000])
def test_pieces_of_a_long_stretch_agree_with_the_whole(monkeypatch, longest):
    torque, v, q = driven(2)
    whole = smoother(torque, q, v, VISCOUS)
    whole._weigh = lambda problem: None
    expected = whole.run()[0]
    monkeypatch.setattr('sosml_friction.identification.velocity_smoother._LONGEST', longest)
    own = smoother(torque, q, v, VISCOUS)
    own._overlap, own._weigh = 100, lambda problem: None
    np.testing.assert_allclose(own.run()[0], expected, atol=2e-4)


def test_a_joint_at_rest_does_not_hide_how_well_the_torque_explains_the_other():
    torque, v, q = driven(3)
    torque[:, 1], v[:, 1], q[:, 1] = 0.0, 0.0, np.random.default_rng(3).normal(0.0, POSITION, 301)
    # What holds the second joint keeps it from being driven by the first one's acceleration.
    rough = v + np.random.default_rng(4).normal(0.0, 1e-2, v.shape) * [1.0, 0.0]
    own = smoother(torque, q, rough, VISCOUS)
    own.run()
    assert own._factor[0] != 1.0
    assert own._factor[1] == 1.0


def test_where_a_mean_of_velocity_may_hide_a_stop_the_law_says_nothing():
    """Within the window about a standstill; elsewhere friction is the law's."""
    torque, v, q = driven(1)
    v[:] = 0.2
    v[150:160] = 0.0
    noise = JointNoise(POSITION, EFFORT, FRICTION, 1e-2, 1e-3, LASTING)
    own = VelocitySmoother(stretch(torque, q), q, v, VISCOUS, [noise] * 2, np.ones(2), 20)
    free = np.flatnonzero(own.free[:, 0])
    np.testing.assert_array_equal(free, np.arange(130, 180))
    drive, slope, white = own._linearised()
    assert (slope[140:170] == 0.0).all()
    np.testing.assert_array_equal(drive[140:170], torque[140:170])
    # What friction may be there is as large as the torque: far above its noise.
    assert (white[140:170, 0] > 100.0 * EFFORT**2).all()
    np.testing.assert_allclose(white[:100, 0], EFFORT**2)


def test_no_variance_of_a_nearly_exact_position_is_zero_or_below():
    torque, v, q = driven(3)
    noise = JointNoise(1e-12, EFFORT, FRICTION, 1e-10, 1e-3, LASTING)
    factor = np.ones(2)
    smooth = VelocitySmoother(stretch(torque, q), q, v, VISCOUS, [noise] * 2, factor, 0)
    variance = smooth.run()[1]
    known = np.isfinite(variance)
    assert (smooth.variance[known] > 0.0).all()
    assert np.isfinite(smooth.v).all()
