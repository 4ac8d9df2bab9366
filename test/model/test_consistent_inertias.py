# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bodies that can exist: the pseudo-inertia, and the repair that no motion feels."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.consistent_inertias import (
    body_numbers,
    consistent_inertias,
    is_possible,
    pseudo_inertia,
)
from sosml_friction.model.robot import Robot

ROTORS = np.array([0.0054, 0.004])


@pytest.fixture
def arm(exoskeleton_urdf):
    return Robot(exoskeleton_urdf, ('shoulder', 'elbow'), ROTORS)


def effort(robot, bodies, rotors, state):
    """Return inverse dynamics (n,) of other bodies and rotors, by the regressor."""
    q, v, a = state
    return robot.torque_regressor(q, v, a) @ bodies.ravel() + rotors * a


def cloud(rng, points=6):
    """Return ten numbers of some point masses, by their definition."""
    body = np.zeros(10)
    for m, r in zip(rng.uniform(0.1, 1.0, points), rng.normal(size=(points, 3)), strict=True):
        tensor = m * (float(r @ r) * np.eye(3) - np.outer(r, r))
        body += np.concatenate([[m], m * r, tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])
    return body


def test_any_cloud_of_masses_is_possible_and_the_numbers_come_back():
    rng = np.random.default_rng(0)
    for _ in range(20):
        body = cloud(rng)
        assert is_possible(body)
        assert body_numbers(pseudo_inertia(body)) == pytest.approx(body)


def test_a_body_against_the_triangle_inequality_is_not_possible():
    """Ixx + Iyy < Izz: no mass is so far from one axis and so near the other two."""
    body = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 2.5])
    assert not is_possible(body)
    body[9] = 1.9
    assert is_possible(body)
    body[0] = -1.0
    assert not is_possible(body)
    assert is_possible(np.zeros(10))


def test_a_thin_rod_whose_centre_moved_gets_thicker_and_needs_the_same_effort(arm):
    """A rod with its centre beside its axis cannot be thin; what is added no motion feels."""
    bodies = arm.inertial_parameters()
    bodies[0, 2] += 0.02
    bodies[1, 2] -= 0.01
    assert not is_possible(bodies[0])
    found, rotors = consistent_inertias(arm, bodies, ROTORS)
    assert is_possible(found[0])
    assert is_possible(found[1])
    assert (rotors >= 0.0).all()
    rng = np.random.default_rng(1)
    for state in rng.uniform(-4.0, 4.0, (30, 3, 2)):
        expected = effort(arm, bodies, ROTORS, state)
        assert effort(arm, found, rotors, state) == pytest.approx(expected, abs=1e-10)


def test_what_is_possible_is_not_touched(arm):
    bodies = 1.02 * arm.inertial_parameters()
    found, rotors = consistent_inertias(arm, bodies, ROTORS)
    assert found is bodies
    assert rotors is ROTORS


def test_a_negative_rotor_of_the_first_joint_is_taken_from_the_bodies(arm):
    """Its rotor turns as the first body does: nothing tells the two apart."""
    rotors = np.array([-0.01, 0.004])
    bodies = arm.inertial_parameters()
    found, new = consistent_inertias(arm, bodies, rotors)
    assert (new >= 0.0).all()
    for state in np.random.default_rng(1).uniform(-4.0, 4.0, (10, 3, 2)):
        expected = effort(arm, bodies, rotors, state)
        assert effort(arm, found, new, state) == pytest.approx(expected, abs=1e-10)


def test_a_negative_rotor_of_a_later_joint_is_refused(arm):
    with pytest.raises(ConfigurationError, match='no bodies of positive mass'):
        consistent_inertias(arm, arm.inertial_parameters(), np.array([0.0054, -0.01]))


def test_seven_joints_with_a_prismatic_one(make_serial_arm):
    urdf = make_serial_arm(['revolute'] * 5 + ['prismatic', 'revolute'])
    robot = Robot(urdf, [f'j{k}' for k in range(1, 8)], [0.01] * 7)
    rng = np.random.default_rng(2)
    bodies = robot.inertial_parameters()
    bodies[:, 1:4] += 0.05 * np.abs(bodies[:, 1:4]).max() * rng.normal(size=(7, 3))
    rotors = np.full(7, 0.01)
    found, new = consistent_inertias(robot, bodies, rotors)
    assert all(is_possible(body) for body in found)
    for state in rng.uniform(-2.0, 2.0, (10, 3, 7)):
        expected = effort(robot, bodies, rotors, state)
        assert effort(robot, found, new, state) == pytest.approx(expected, abs=1e-9)
