# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Models that need no file by hand."""

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.simple_models import (
    axis_model,
    free_model,
    pendulum_model,
    skeleton_model,
)

ANGLES = (-9.0, -1.0, 0.0, 0.7, 4.0, 40.0)


@pytest.mark.parametrize('inertia', [None, 0.0, 0.03])
def test_a_pendulum_is_that_of_the_book(inertia):
    mass, length, rotor = 1.3, 0.25, 0.004
    robot = pendulum_model(mass, length, inertia, rotor).make_robot()
    whole = (inertia or 0.0) + mass * length**2 + rotor
    for q in ANGLES:
        weight = mass * 9.81 * length * np.sin(q)
        tau = robot.inverse_dynamics(np.array([q]), np.array([1.0]), np.array([2.0]))
        assert tau == pytest.approx([2.0 * whole + weight], abs=1e-12)


def test_a_level_axis_and_a_shaft_feel_no_gravity():
    one = np.ones(1)
    for model, expected, unit in (
        (axis_model(95.0, 'slider'), 95.0, 'N'),
        (free_model(0.0566, 'motor'), 0.0566, 'Nm'),
    ):
        robot = model.make_robot()
        assert robot.effort_units == (unit,)
        for q in ANGLES:
            assert robot.inverse_dynamics(q * one, one, one) == pytest.approx([expected])


def test_a_simple_model_is_a_model_folder(tmp_path):
    for k, model in enumerate((pendulum_model(1, 0.25), axis_model(95), free_model(1e-3))):
        model.write(tmp_path / str(k))
        again = read_model(tmp_path / str(k))
        assert again.to_yaml() == model.to_yaml()
        assert again.urdf == model.urdf
        assert again.provenance['assumed']


def test_an_armature_that_nobody_stated_is_asked_for_and_can_be_stated_later():
    model = pendulum_model(1.0, 0.25)
    assert model.unknown_armature == ('joint',)
    with pytest.raises(ConfigurationError, match='armature of joint joint is not known'):
        model.make_robot()
    assert model.with_armature({'*': 0.002}).make_robot().armature == (0.002,)
    # A value that is known is not replaced.
    assert pendulum_model(1.0, 0.25, None, 0.1).with_armature({'*': 0.002}) == pendulum_model(
        1.0, 0.25, None, 0.1
    )
    for wrong in ({'elbow': 0.0}, {'joint': -1.0}, {'*': float('nan')}):
        with pytest.raises(ConfigurationError):
            model.with_armature(wrong)


@pytest.mark.parametrize(
    'make',
    [
        lambda: pendulum_model(0.0, 0.25),
        lambda: pendulum_model(1.0, -0.25),
        lambda: pendulum_model(1.0, 0.25, -1e-3),
        lambda: pendulum_model(1.0, 0.25, 0.0, float('inf')),
        lambda: pendulum_model(float('nan'), 0.25),
        lambda: axis_model(-95.0),
        lambda: free_model(0.0),
        lambda: free_model(1.0, ' '),
        lambda: skeleton_model('<robot name="r"><link name="l"/></robot>'),
        lambda: skeleton_model('no xml'),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(make):
    with pytest.raises(ConfigurationError) as caught:
        make()
    assert '\n' not in str(caught.value)


def test_a_skeleton_has_every_joint_and_says_what_is_missing(make_serial_arm):
    urdf = make_serial_arm(['revolute', 'continuous', 'prismatic']).replace('"20"', '"0"')
    model = skeleton_model(urdf)
    assert model.joint_names == ('j1', 'j2', 'j3') == model.unknown_armature
    assert [j.armature.unit for j in model.joints.values()] == ['kg m2', 'kg m2', 'kg']
    assert all(j.armature.reason for j in model.joints.values())
    missing = model.provenance['not_known']
    assert set(missing['j1']) == {'friction'}
    assert set(missing['j2']) == {'friction', 'effort limit'}
    assert skeleton_model(urdf, ['j3', 'nobody']).joint_names == ('j3',)


def test_a_simulators_friction_in_a_urdf_is_told_and_not_taken(make_serial_arm):
    head, *joints = make_serial_arm(['revolute', 'revolute']).split('</joint>')
    said = '<dynamics damping="0.5" friction="0.0"/>', '<dynamics damping="0"/>'
    urdf = head
    for dynamics, rest in zip(said, joints, strict=True):
        urdf += f'{dynamics}</joint>{rest}'
    model = skeleton_model(urdf)
    assert all(joint.friction is None for joint in model.joints.values())
    missing = model.provenance['not_known']
    assert '<dynamics> of the URDF, damping 0.5, is what' in missing['j1']['friction']
    assert '<dynamics>' not in missing['j2']['friction']
