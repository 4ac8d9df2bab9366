# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid-body terms against a closed form, against each other, and on bad input."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot

JOINTS = ('shoulder', 'elbow')


def random_states(n, count, seed=0):
    rng = np.random.default_rng(seed)
    return zip(
        rng.uniform(-np.pi, np.pi, (count, n)),
        rng.normal(scale=3.0, size=(count, n)),
        rng.normal(scale=5.0, size=(count, n)),
        rng.uniform(0.0, 0.5, (count, n)),
        strict=True,
    )


def test_every_term_agrees_with_the_closed_form_to_1e_12(planar_arm, exoskeleton_urdf):
    """Issue 2: <= 1e-12 on random states with random armature (terms are of order 1 to 100)."""
    for q, v, tau, rotor in random_states(2, 100):
        robot = Robot(exoskeleton_urdf, JOINTS, rotor)
        arm = planar_arm(rotor=tuple(rotor))
        M, C, g = arm.inertia(q), arm.coriolis(q, v), arm.gravity(q)
        p, drift, inertia = robot.momentum_terms(q, v)
        a = np.linalg.solve(M, tau - C @ v - g)
        for ours, truth in (
            (robot.inertia(q), M),
            (inertia, M),
            (robot.coriolis(q, v), C),
            (robot.gravity(q), g),
            (p, M @ v),
            (drift, C.T @ v - g),
            (robot.inverse_dynamics(q, v, a), tau),
        ):
            np.testing.assert_allclose(ours, truth, rtol=1e-12, atol=1e-12)
        # M is inverted: the error grows by its condition number, about 40.
        np.testing.assert_allclose(robot.acceleration(q, v, tau), a, rtol=1e-12, atol=1e-10)


def test_energy_is_the_closed_form_up_to_the_zero_of_height(planar_arm, exoskeleton_urdf):
    rotor = (0.02, 0.01)
    robot, arm = Robot(exoskeleton_urdf, JOINTS, rotor), planar_arm(rotor=rotor)
    offsets = [robot.energy(q, v) - arm.energy(q, v) for q, v, _, _ in random_states(2, 20)]
    np.testing.assert_allclose(offsets, offsets[0], atol=1e-12)


def test_joints_in_another_order_give_every_result_in_that_order(seven_joints, make_serial_arm):
    order = np.array([3, 0, 6, 1, 5, 2, 4])
    names = [seven_joints.names[k] for k in order]
    armature = np.linspace(0.01, 0.07, 7)[order]
    urdf = make_serial_arm(['revolute'] * 5 + ['prismatic', 'revolute'])
    other = Robot(urdf, names, armature)
    assert other.effort_units == tuple(seven_joints.effort_units[k] for k in order)
    assert other.limits == tuple(seven_joints.limits[k] for k in order)
    for q, v, tau, _ in random_states(7, 10):
        here, there = (q, v, tau), (q[order], v[order], tau[order])
        for vector in ('gravity', 'acceleration', 'inverse_dynamics'):
            count = 1 if vector == 'gravity' else 3
            expected = getattr(seven_joints, vector)(*here[:count])[order]
            ours = getattr(other, vector)(*there[:count])
            np.testing.assert_allclose(ours, expected, rtol=1e-13, atol=1e-13)
        for matrix, count in (('inertia', 1), ('coriolis', 2)):
            expected = getattr(seven_joints, matrix)(*here[:count])[np.ix_(order, order)]
            ours = getattr(other, matrix)(*there[:count])
            np.testing.assert_allclose(ours, expected, rtol=1e-13, atol=1e-13)
        for mine, theirs in zip(
            other.momentum_terms(*there[:2]), seven_joints.momentum_terms(*here[:2]), strict=True
        ):
            theirs = theirs[np.ix_(*[order] * theirs.ndim)]
            np.testing.assert_allclose(mine, theirs, rtol=1e-13, atol=1e-13)
        assert other.energy(*there[:2]) == pytest.approx(seven_joints.energy(*here[:2]), rel=1e-13)


def test_the_inertia_changes_at_the_rate_c_plus_its_transpose(seven_joints):
    """M' = C + C^T, C by Christoffel symbols; central difference, error h^2 M''' / 6 ~ 1e-8."""
    h = 1e-5
    for q, v, _, _ in random_states(7, 10):
        rate = (seven_joints.inertia(q + h * v) - seven_joints.inertia(q - h * v)) / (2 * h)
        C = seven_joints.coriolis(q, v)
        np.testing.assert_allclose(C + C.T, rate, atol=1e-7 * np.abs(rate).max() + 1e-7)


def test_the_drift_is_the_gradient_of_the_lagrangian(seven_joints):
    """C^T q' - g = d/dq (q'^T M q' / 2 - V), Lagrange's own form of p' without effort."""
    h, identity = 1e-5, np.eye(7)
    for q, v, _, _ in random_states(7, 10):

        def lagrangian(x, v=v):
            kinetic = 0.5 * v @ seven_joints.inertia(x) @ v
            return kinetic - seven_joints.energy(x, np.zeros(7))

        gradient = [(lagrangian(q + h * e) - lagrangian(q - h * e)) / (2 * h) for e in identity]
        _, drift, _ = seven_joints.momentum_terms(q, v)
        np.testing.assert_allclose(drift, gradient, atol=1e-7 * np.abs(drift).max())


def test_inverse_dynamics_undoes_acceleration_and_momentum_is_m_v(seven_joints):
    for q, v, tau, _ in random_states(7, 20):
        a = seven_joints.acceleration(q, v, tau)
        back = seven_joints.inverse_dynamics(q, v, a)
        np.testing.assert_allclose(back, tau, atol=1e-10 * (1 + np.abs(a).max()))
        M = seven_joints.inertia(q)
        np.testing.assert_array_equal(M, M.T)
        p, _, _ = seven_joints.momentum_terms(q, v)
        np.testing.assert_allclose(p, M @ v, rtol=1e-13, atol=1e-13)
        C, g = seven_joints.coriolis(q, v), seven_joints.gravity(q)
        np.testing.assert_allclose(M @ a + C @ v + g, tau, atol=1e-10 * (1 + np.abs(a).max()))


def test_results_are_not_overwritten_by_the_next_call(seven_joints):
    (q, v, tau, _), (x, w, f, _) = random_states(7, 2)
    calls = {
        'inertia': ((q,), (x,)),
        'coriolis': ((q, v), (x, w)),
        'gravity': ((q,), (x,)),
        'momentum_terms': ((q, v), (x, w)),
        'acceleration': ((q, v, tau), (x, w, f)),
        'inverse_dynamics': ((q, v, tau), (x, w, f)),
    }
    for name, (first, second) in calls.items():
        result = getattr(seven_joints, name)(*first)
        results = result if isinstance(result, tuple) else (result,)
        kept = [one.copy() for one in results]
        getattr(seven_joints, name)(*second)
        for one, before in zip(results, kept, strict=True):
            np.testing.assert_array_equal(one, before, err_msg=name)


def test_strided_views_are_read_like_contiguous_arrays(seven_joints):
    (q, v, _, _), (x, w, _, _) = random_states(7, 2)
    wide = np.stack([q, v, x, w], axis=1)
    for ours, expected in zip(
        seven_joints.momentum_terms(wide[:, 0], wide[:, 1]),
        seven_joints.momentum_terms(q, v),
        strict=True,
    ):
        # Sums may be taken in another order.
        np.testing.assert_allclose(ours, expected, rtol=1e-13, atol=1e-13)


def test_a_prismatic_axis_has_newtons_and_kilograms(emps_urdf):
    """The published mass of EMPS, a horizontal slide: M = mass + rotor, no other term."""
    robot = Robot(emps_urdf, ['slider'], [0.5])
    q, v = np.array([0.1]), np.array([0.2])
    assert robot.effort_units == ('N',)
    np.testing.assert_allclose(robot.inertia(q), [[95.1089 + 0.5]], rtol=1e-15)
    p, drift, _ = robot.momentum_terms(q, v)
    np.testing.assert_allclose(p, [95.6089 * 0.2], rtol=1e-15)
    np.testing.assert_allclose(drift, [0.0], atol=1e-12)
    np.testing.assert_allclose(robot.acceleration(q, v, np.array([95.6089])), [1.0], rtol=1e-12)


def test_limits_are_those_of_the_urdf(exoskeleton_urdf):
    elbow, shoulder = Robot(exoskeleton_urdf, ('elbow', 'shoulder'), (0.0, 0.0)).limits
    assert (elbow.lower, elbow.upper, elbow.effort, elbow.velocity) == (-0.05, 2.5, 5.0, 3.0)
    assert (shoulder.lower, shoulder.upper, shoulder.effort) == (-2.3, 0.7, 8.0)


@pytest.mark.parametrize(
    ('change', 'joints', 'armature', 'words'),
    [
        (lambda s: 'no xml at all', JOINTS, (0, 0), 'the URDF cannot be read'),
        (lambda s: s[: len(s) // 2], JOINTS, (0, 0), 'the URDF cannot be read'),
        (lambda s: '<html/>', JOINTS, (0, 0), 'the URDF cannot be read'),
        (lambda s: s, ('shoulder',), (0,), 'moves the joints shoulder, elbow where'),
        (lambda s: s, ('shoulder', 'wrist'), (0, 0), 'names shoulder, wrist'),
        (lambda s: s, ('shoulder', 'shoulder'), (0, 0), 'make them the same'),
        (lambda s: s, JOINTS, (0, -1e-3), 'rotor inertia >= 0'),
        (lambda s: s, JOINTS, (0, float('nan')), 'rotor inertia >= 0'),
        (lambda s: s, JOINTS, (0, float('inf')), 'rotor inertia >= 0'),
        (lambda s: s, JOINTS, (0,), 'for joints shoulder, elbow'),
        (lambda s: s.replace('"revolute"', '"continuous"'), JOINTS, (0, 0), 'continuous'),
        (lambda s: s.replace('"revolute"', '"floating"'), JOINTS, (0, 0), 'continuous or multi'),
        (lambda s: s.replace('"revolute"', '"fixed"'), JOINTS, (0, 0), 'moves the joints none'),
    ],
)
def test_a_urdf_that_cannot_serve_is_refused_in_one_sentence(
    exoskeleton_urdf, change, joints, armature, words
):
    with pytest.raises(ConfigurationError, match=words) as caught:
        Robot(change(exoskeleton_urdf), joints, armature)
    assert '\n' not in str(caught.value)
