# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the model gained for the diagnosis: the torque regressor, gravity by vector, effects."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import parse_model, read_model
from sosml_friction.model.robot import Robot
from sosml_friction.share import share_directory


def test_the_regressor_times_the_inertias_is_inverse_dynamics(seven_joints, make_serial_arm):
    """Of a chain with a prismatic joint, and with its joints in another order than the URDF's."""
    urdf = make_serial_arm(['revolute'] * 5 + ['prismatic', 'revolute'])
    names = [f'j{k}' for k in (3, 1, 7, 2, 5, 6, 4)]
    rng = np.random.default_rng(0)
    for robot in (
        Robot(urdf, [f'j{k}' for k in range(1, 8)], [0.0] * 7),
        Robot(urdf, names, [0.0] * 7),
    ):
        q, v, a = rng.normal(size=(3, 7))
        predicted = robot.torque_regressor(q, v, a) @ robot.inertial_parameters().ravel()
        # Rounding of sums of terms of size 100.
        assert predicted == pytest.approx(robot.inverse_dynamics(q, v, a), abs=1e-9)


def test_gravity_under_its_own_vector_is_gravity_and_the_model_keeps_it(seven_joints):
    q = np.linspace(-0.5, 0.5, 7)
    g = seven_joints.gravity(q)
    own = seven_joints.gravity_acceleration
    assert own == pytest.approx([0.0, 0.0, -9.81])
    assert seven_joints.gravity_under(q, 2.0 * own) == pytest.approx(2.0 * g)
    assert seven_joints.gravity(q) == pytest.approx(g)


@pytest.mark.parametrize(
    ('entry', 'what'),
    [
        ('terms: {a: 1}', 'no list'),
        ('terms: [{term: stribeck}]', 'term, joint and parameters'),
        ('terms: [{term: spring, joint: knee, parameters: {}}]', 'knee'),
        ('terms: [{term: spring, joint: elbow, parameters: 3}]', 'no mapping'),
        ('terms: [{term: spring, joint: elbow, parameters: {k: 3}}]', 'value: NUMBER'),
        ('effects: []', 'unknown entry effects'),
    ],
)
def test_a_wrong_list_of_terms_is_refused_in_one_sentence(entry, what):
    text = (share_directory() / 'config/exoskeleton/model.yaml').read_text() + '\n' + entry
    with pytest.raises(ConfigurationError, match=what):
        parse_model(text, 'model.yaml')


def test_a_model_without_effects_has_none():
    assert read_model(share_directory() / 'config/exoskeleton').effects == ()
