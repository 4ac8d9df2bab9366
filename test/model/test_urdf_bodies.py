# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A URDF with other bodies or another stand: Pinocchio reads back what was written."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.urdf_bodies import with_bodies, with_turned_base

NAMES = ('shoulder', 'elbow')

TOOL = """  <link name="tool"><inertial><origin xyz="0.02 0 0.01"/><mass value="0.4"/>
<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
  <joint name="mount" type="fixed"><parent link="forearm"/><child link="tool"/>
<origin xyz="0.27 0 0" rpy="0 0.3 0"/></joint>
</robot>"""


def test_bodies_are_read_back_as_they_were_written(exoskeleton_urdf):
    robot = Robot(exoskeleton_urdf, NAMES, [0.0, 0.0])
    bodies = robot.inertial_parameters() * [[1.1], [0.9]]
    bodies[0, 1:4] += [0.001, 0.002, -0.001]
    bodies[1, 4:] += 0.01 * np.array([1.0, 0.1, 1.0, -0.1, 0.05, 1.0])
    again = Robot(
        with_bodies(exoskeleton_urdf, dict(zip(NAMES, bodies, strict=True))), NAMES, [0.0, 0.0]
    )
    # Rounding of numbers of size 1.
    assert again.inertial_parameters() == pytest.approx(bodies, abs=1e-14)
    assert again.limits == robot.limits


def test_what_is_fixed_to_a_link_is_part_of_its_body(exoskeleton_urdf):
    urdf = exoskeleton_urdf.replace('</robot>', TOOL)
    robot = Robot(urdf, NAMES, [0.0, 0.0])
    bodies = robot.inertial_parameters()
    assert bodies[1, 0] == pytest.approx(1.8 + 0.4)
    bodies[1] *= 1.05
    again = Robot(with_bodies(urdf, {'elbow': bodies[1]}), NAMES, [0.0, 0.0])
    assert again.inertial_parameters() == pytest.approx(bodies, abs=1e-14)


def test_a_point_mass_keeps_no_inertia_of_rounding():
    urdf = pendulum_model(1.0, 0.25).urdf
    for mass in np.linspace(0.3, 3.0, 40):
        body = mass * Robot(urdf, ['joint'], [0.0]).inertial_parameters()[0]
        body *= np.array([1.0, *[0.9] * 3, *[0.9 * 0.9] * 6])
        # As it comes of a fit, whose ridge is 1e-10.
        body[4:] *= 1.0 - 1e-10
        text = with_bodies(urdf, {'joint': body})
        assert '<inertia ixx="0.0" ixy="0.0" ixz="0.0" iyy="0.0" iyz="0.0" izz="0.0"' in text


def test_comments_and_shapes_stay(exoskeleton_urdf):
    robot = Robot(exoskeleton_urdf, NAMES, [0.0, 0.0])
    text = with_bodies(exoskeleton_urdf, {'elbow': robot.inertial_parameters()[1]})
    assert "the plane's y axis is cos(20 deg) up" in text
    assert text.count('<visual>') == exoskeleton_urdf.count('<visual>')


def test_a_body_without_mass_or_joint_is_refused(exoskeleton_urdf):
    with pytest.raises(ConfigurationError, match='mass -1'):
        with_bodies(exoskeleton_urdf, {'elbow': np.array([-1.0] + [0.0] * 9)})
    with pytest.raises(ConfigurationError, match='no joint knee'):
        with_bodies(exoskeleton_urdf, {'knee': np.ones(10)})


@pytest.mark.parametrize('rotation', [(0.05, 0.0, 0.0), (-0.1, 0.2, 0.0), (0.3, -0.2, 0.7)])
def test_a_turned_base_feels_gravity_turned_back(exoskeleton_urdf, rotation):
    robot = Robot(exoskeleton_urdf, NAMES, [0.0, 0.0])
    urdf = with_turned_base(exoskeleton_urdf, np.array(rotation))
    turned = Robot(urdf, NAMES, [0.0, 0.0])
    felt = Rotation.from_rotvec(rotation).inv().apply(robot.gravity_acceleration)
    for q in np.random.default_rng(0).uniform(-2.0, 2.0, (10, 2)):
        assert turned.gravity(q) == pytest.approx(robot.gravity_under(q, felt), abs=1e-12)
        assert turned.inertia(q) == pytest.approx(robot.inertia(q), abs=1e-14)
    # And once more: the name of the added link is taken then.
    back = Robot(with_turned_base(urdf, -np.array(rotation)), NAMES, [0.0, 0.0])
    q = np.array([0.3, 0.8])
    assert back.gravity(q) == pytest.approx(robot.gravity(q), abs=1e-12)


def test_a_body_that_is_changed_has_what_is_held_on_it(make_serial_arm):
    urdf = make_serial_arm(['revolute', 'prismatic', 'revolute', 'continuous'])
    names, locked = ['j1', 'j3'], {'j2': 0.1, 'j4': -0.7}
    robot = Robot(urdf, names, [0.0, 0.0], locked)
    bodies = 1.2 * robot.inertial_parameters()
    text = with_bodies(urdf, dict(zip(names, bodies, strict=True)), robot.held)
    again = Robot(text, names, [0.0, 0.0], locked)
    np.testing.assert_allclose(again.inertial_parameters(), bodies, atol=1e-12)
