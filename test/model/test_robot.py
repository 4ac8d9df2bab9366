# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid-body terms against a closed form, against each other, and on bad input."""

from __future__ import annotations

import re

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
        (lambda s: s, ('shoulder', 'wrist'), (0, 0), 'names shoulder, wrist'),
        (lambda s: s, ('shoulder', 'shoulder'), (0, 0), 'make them the same'),
        (lambda s: s, JOINTS, (0, -1e-3), 'rotor inertia >= 0'),
        (lambda s: s, JOINTS, (0, float('nan')), 'rotor inertia >= 0'),
        (lambda s: s, JOINTS, (0, float('inf')), 'rotor inertia >= 0'),
        (lambda s: s, JOINTS, (0,), 'for joints shoulder, elbow'),
        (lambda s: s.replace('"revolute"', '"floating"'), JOINTS, (0, 0), 'of type floating'),
        (lambda s: f'{s[:-9]}<xacro:arm/></robot>', JOINTS, (0, 0), 'cannot be read'),
        (lambda s: s.replace('upper="0.7"', 'upper="high"'), JOINTS, (0, 0), "'high', no number"),
        (lambda s: s.replace('"revolute"', '"fixed"'), JOINTS, (0, 0), 'moves the joints none'),
    ],
)
def test_a_urdf_that_cannot_serve_is_refused_in_one_sentence(
    exoskeleton_urdf, change, joints, armature, words
):
    with pytest.raises(ConfigurationError, match=words) as caught:
        Robot(change(exoskeleton_urdf), joints, armature)
    assert '\n' not in str(caught.value)


def reduced(urdf, names):
    return Robot(urdf, names, [0.01] * len(names))


def test_joints_that_the_model_does_not_name_are_held_and_it_says_so(make_serial_arm):
    """The same as the arm at rest in those joints: effort of the others, and nothing else."""
    urdf = make_serial_arm(['revolute', 'prismatic', 'continuous', 'revolute'])
    whole = Robot(urdf, ['j1', 'j2', 'j3', 'j4'], [0.01] * 4)
    some = Robot(urdf, ['j4', 'j1'], [0.01] * 2, {'j2': 0.3})
    assert some.held == {'j2': 0.3, 'j3': 0.0}
    # Only what nobody stated is remarked upon.
    (remark,) = some.remarks
    assert 'joint j3 of the URDF' in remark
    assert whole.remarks == ()
    rng = np.random.default_rng(2)
    for q, v, a in rng.normal(size=(20, 3, 2)):
        full = [np.array([x[1], still, 0.0, x[0]]) for x, still in ((q, 0.3), (v, 0.0), (a, 0.0))]
        expected = whole.inverse_dynamics(*full)[[3, 0]]
        assert some.inverse_dynamics(q, v, a) == pytest.approx(expected, abs=1e-12)
    for wrong in ({'j1': 0.0}, {'j9': 0.0}, {'j2': float('nan')}):
        with pytest.raises(ConfigurationError, match='cannot be locked'):
            Robot(urdf, ['j4', 'j1'], [0.01] * 2, wrong)


def test_a_continuous_joint_goes_round_and_has_no_limits(make_serial_arm):
    urdf = make_serial_arm(['revolute', 'continuous'])
    robot = reduced(urdf, ['j1', 'j2'])
    limit = robot.limits[1]
    assert (limit.lower, limit.upper, limit.velocity) == (-np.inf, np.inf, 4.0)
    q, v, a = np.random.default_rng(3).normal(size=(3, 2))
    turned = q + np.array([0.0, 14 * np.pi])
    assert robot.inverse_dynamics(turned, v, a) == pytest.approx(robot.inverse_dynamics(q, v, a))


def test_a_joint_without_limits_has_none(make_serial_arm):
    robot = reduced(re.sub('<limit[^>]*>', '', make_serial_arm(['revolute'])), ['j1'])
    limit = robot.limits[0]
    assert (limit.lower, limit.upper) == (-np.inf, np.inf)
    assert np.isnan([limit.velocity, limit.effort]).all()


def with_mimic(urdf, ratio=-2.0, offset=0.4):
    """Return the URDF in which j3 follows j1."""
    mimic = f'<mimic joint="j1" multiplier="{ratio}" offset="{offset}"/><limit lower="-3"'
    assert '<limit lower="-3"' in urdf
    return urdf.replace('<limit lower="-3"', mimic)


def test_a_mimic_joint_follows_its_leader_with_its_body(make_serial_arm):
    """q3 = -2 q1 + 0.4: what it needs and stores is seen at j1, by the principle of power."""
    urdf = make_serial_arm(['revolute', 'revolute', 'revolute', 'prismatic'])
    whole = Robot(urdf, ['j1', 'j2', 'j3', 'j4'], [0.01, 0.01, 0.0, 0.01])
    robot = reduced(with_mimic(urdf), ['j4', 'j1', 'j2'])
    assert robot.remarks == ()
    assert [robot.carriers(i) for i in range(3)] == [(1, 2), (), (1,)]
    G = np.array([[0, 1, 0], [0, 0, 1], [0, -2.0, 0], [1, 0, 0]])
    h = np.array([0.0, 0.0, 0.4, 0.0])
    for q, v, a in np.random.default_rng(4).normal(size=(20, 3, 3)):
        x, u = G @ q + h, G @ v
        tau = robot.inverse_dynamics(q, v, a)
        assert tau == pytest.approx(G.T @ whole.inverse_dynamics(x, u, G @ a), abs=1e-11)
        assert robot.acceleration(q, v, tau) == pytest.approx(a, abs=1e-9)
        assert robot.energy(q, v) == pytest.approx(whole.energy(x, u))
        p, drift, M = robot.momentum_terms(q, v)
        assert p == pytest.approx(M @ v, abs=1e-12)
        assert drift == pytest.approx(robot.coriolis(q, v).T @ v - robot.gravity(q), abs=1e-12)
        assert pytest.approx(robot.inertia(q), abs=1e-12) == M
        assert M @ a + robot.coriolis(q, v) @ v + robot.gravity(q) == pytest.approx(tau, abs=1e-11)
        # The regressor has the bodies of the joints that are named, not of what follows them.
        pi = robot.inertial_parameters().ravel() * 1e-3
        heavier = robot.changed(1.001 * robot.inertial_parameters(), [0.01] * 3, [0, 0, -9.81])
        more = heavier.inverse_dynamics(q, v, a) - tau
        assert robot.torque_regressor(q, v, a) @ pi == pytest.approx(more, abs=1e-9)


def test_a_mimic_joint_of_one_that_is_held_is_held_with_it(make_serial_arm):
    urdf = with_mimic(make_serial_arm(['revolute', 'revolute', 'revolute']))
    robot = Robot(urdf, ['j2'], [0.0], {'j1': 0.5})
    assert robot.held == {'j1': 0.5, 'j3': pytest.approx(-0.6)}
    assert robot.remarks == ()
    # One that the model names moves by itself.
    assert reduced(urdf, ['j1', 'j2', 'j3']).followers == {}


@pytest.mark.parametrize('leader', ['j9', 'j3'])
def test_a_mimic_joint_of_nothing_is_refused(make_serial_arm, leader):
    urdf = with_mimic(make_serial_arm(['revolute'] * 3)).replace('joint="j1"', f'joint="{leader}"')
    with pytest.raises(ConfigurationError, match='joint j3 mimics'):
        reduced(urdf, ['j1'])


def test_what_a_robot_is_drawn_and_driven_with_does_not_matter(exoskeleton_urdf):
    more = (
        '<link name="tool"><visual><geometry><mesh filename="package://nowhere/tool.dae"/>'
        '</geometry></visual></link><joint name="mount" type="fixed"><parent link="forearm"/>'
        '<child link="tool"/></joint><transmission name="t"><joint name="shoulder">'
        '<hardwareInterface>Effort</hardwareInterface></joint></transmission>'
        '<gazebo reference="forearm"><plugin name="p" filename="libx.so"/></gazebo>'
        '<ros2_control name="c" type="system"><joint name="elbow"/></ros2_control></robot>'
    )
    dressed = exoskeleton_urdf.replace('</robot>', more)
    bare, robot = reduced(exoskeleton_urdf, JOINTS), reduced(dressed, JOINTS)
    q, v, a = np.random.default_rng(5).normal(size=(3, 2))
    assert (robot.inverse_dynamics(q, v, a) == bare.inverse_dynamics(q, v, a)).all()


def test_an_arm_with_a_body_of_no_mass_can_be_changed(make_serial_arm):
    """Its centre is nowhere; what is left of it is its rotor."""
    urdf = re.sub('<inertial>.*?</inertial>', '', make_serial_arm(['revolute']))
    robot = Robot(urdf, ['j1'], [0.3])
    again = robot.changed(robot.inertial_parameters(), np.array([0.2]), np.zeros(3))
    assert again.inertia(np.zeros(1)) == pytest.approx(np.array([[0.2]]))
