# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A robot with other bodies, and maps of effort and position that have inverses."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import ChangedBody
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.terms.kinds.term import ROBOT, TERMS
from sosml_friction.simulation.forward_model import ForwardModel


def test_a_changed_robot_obeys_its_regressor_and_the_old_one_is_as_it_was(make_serial_arm):
    """Joints in another order than the URDF's, one of them prismatic."""
    urdf = make_serial_arm(['revolute'] * 5 + ['prismatic', 'revolute'])
    robot = Robot(urdf, [f'j{k}' for k in (3, 1, 7, 2, 5, 6, 4)], [0.1] * 7)
    rng = np.random.default_rng(0)
    q, v, a = rng.normal(size=(3, 7))
    before = robot.inverse_dynamics(q, v, a)
    inertias = robot.inertial_parameters() * rng.uniform(0.9, 1.1, (7, 1))
    inertias[2, 1:4] += 0.05
    rotors = rng.uniform(0.0, 0.2, 7)
    other = robot.changed(inertias, rotors, robot.gravity_acceleration)
    wanted = robot.torque_regressor(q, v, a) @ inertias.ravel() + rotors * a
    M, C, g = other.inertia(q), other.coriolis(q, v), other.gravity(q)
    # Rounding of sums of terms of size 100.
    assert M @ a + C @ v + g == pytest.approx(wanted, abs=1e-9)
    half = robot.changed(inertias, rotors, 0.5 * robot.gravity_acceleration)
    assert half.gravity(q) == pytest.approx(0.5 * g, abs=1e-9)
    assert robot.inverse_dynamics(q, v, a) == pytest.approx(before, abs=1e-12)


def test_reports_and_encoders_are_undone_in_the_reverse_order(seven_joints):
    robot = seven_joints
    heavier = Body.unchanged(7)
    heavier.rotors += 0.5
    terms = [
        TERMS['effort_scale'].counterpart().simulated(robot, ROBOT, {}, np.array([0.1])),
        *(TERMS['effort_bias']().simulated(robot, i, {}, np.array([0.3])) for i in range(7)),
        TERMS['effort_delay']().simulated(robot, 0, {}, np.array([3e-3])),
        TERMS['encoder_eccentricity']().simulated(robot, 1, {}, np.array([0.01, 0.0])),
        ChangedBody([heavier], [1.0]),
    ]
    friction = JointFriction([None] * 7)
    model = ForwardModel(seven_joints, friction, np.full(7, 1e-3), terms, 5e-4)
    torque = np.linspace(-3.0, 3.0, 14).reshape(2, 7)
    assert model.torque(1.1 * torque + 0.3) == pytest.approx(torque)
    assert model.delay == pytest.approx(3.5e-3)
    assert model.rotors == pytest.approx(np.array(seven_joints.armature) + 0.5)
    measured = np.linspace(-1.0, 1.0, 14).reshape(2, 7)
    true = model.true_position(measured)
    assert true[:, 1] - measured[:, 1] == pytest.approx(0.01 * np.cos(measured[:, 1]))
    # Four rounds of a map whose slope is 1 %: 1e-8 of 10 mrad.
    assert model.measured_position(true) == pytest.approx(measured, abs=1e-9)
