# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint that the model holds still and that moves: what it carries would pass for friction."""

import numpy as np
import pytest
from gripper_arm import ARM, gripper_arm_urdf

from sosml_friction.model.robot import Robot
from sosml_friction.observers.held_joints import HeldJoints

Q = np.zeros(6)
ERROR = np.full(6, 0.05)


@pytest.fixture
def robot(make_serial_arm) -> Robot:
    """Return the arm without its fourth joint and its gripper."""
    names = [name for name in ARM if name != 'j4']
    return Robot(gripper_arm_urdf(make_serial_arm), names, [0.1] * 6, {'j4': 0.3, 'finger_a': 0.0})


def test_what_carries_a_joint_that_moves_is_not_known(robot):
    held = HeldJoints(robot)
    held.see({'j4': 1.1})
    held.look(0.0, Q, ERROR)
    moved = Robot(robot.document, robot.names, robot.armature, {'j4': 1.1})
    weight = np.abs(moved.gravity(Q) - robot.gravity(Q))
    assert weight.max() > 1.0
    assert set(np.flatnonzero(weight > 0.15)) <= set(held.causes)
    assert 'joint j4 is at 1.1 and the model holds it at 0.3' in held.causes[int(weight.argmax())]
    held.see({'j4': 0.3})
    held.look(0.3, Q, ERROR)
    assert not held.causes


def test_the_noise_of_an_encoder_and_a_gripper_that_opens_are_no_motion(robot):
    held = HeldJoints(robot)
    held.see({'j4': 0.3002, 'finger_a': 0.04})
    held.look(0.0, Q, ERROR)
    assert not held.causes


def test_what_is_not_given_any_more_is_judged_by_the_error_it_had(robot):
    held = HeldJoints(robot)
    held.see({'j4': 1.1})
    held.look(0.0, Q, ERROR)
    first = held.causes
    held.look(0.3, Q, np.where([i in first for i in range(6)], np.nan, ERROR))
    assert held.causes == first
