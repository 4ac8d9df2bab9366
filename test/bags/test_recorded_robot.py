# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The robot in a bag that holds joint_states and robot_description alone."""

from dataclasses import replace

import numpy as np
import pytest
from gripper_arm import ARM, gripper_arm_log, gripper_arm_urdf

from sosml_friction.api.model import Model
from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.recorded_robot import read_recorded_robot, stated_armature
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.simple_models import skeleton_model


@pytest.fixture(scope='module')
def arm(make_serial_arm):
    urdf = gripper_arm_urdf(make_serial_arm)
    return urdf, gripper_arm_log(urdf, 0.5)


def test_columns_go_to_joints_by_name(arm, tmp_path):
    """The model's order is that of the URDF, whatever the order of joint_states."""
    urdf, log = arm
    path = write_joint_log(log, tmp_path / 'bag', urdf, None)
    model = stated_armature(Bag.open(path), path, None, None, {'*': 0.1, 'j3': 0.2})
    found = read_recorded_robot(path, model)
    assert found.log.names == found.robot.names == (*ARM, 'finger_a')
    assert found.robot.armature == (0.1, 0.1, 0.2, 0.1, 0.1, 0.1, 0.1, 0.1)
    assert list(found.robot.followers) == ['finger_b']
    again = Model.from_bag(path, armature={'*': 0.1, 'j3': 0.2})
    assert again.content.to_yaml() == model.to_yaml()
    for name in ARM:
        own = found.log.q[:, found.log.names.index(name)]
        np.testing.assert_array_equal(own, log.q[:, log.names.index(name)])


def test_joints_that_are_not_recorded_are_held(arm, tmp_path):
    urdf, log = arm
    path = write_joint_log(log.select(ARM[:3]), tmp_path / 'bag', urdf, None)
    whole = skeleton_model(urdf).with_armature({'*': 0.1})
    stated = stated_armature(Bag.open(path), path, None, None, {'*': 0.1})
    for model in (whole, stated):
        found = read_recorded_robot(path, model)
        assert found.robot.names == ARM[:3]
        assert set(found.robot.held) == {*ARM[3:], 'finger_a', 'finger_b'}
        (remark,) = found.robot.remarks
        assert 'joints j4, j5, j6, j7, finger_a of the URDF are not in the model' in remark


def test_a_gripper_that_publishes_by_itself_is_not_in_the_model(arm, tmp_path):
    urdf, log = arm
    turns = np.arange(len(log)) % 2 == 0
    hidden = np.where(np.isin(log.names, ARM), turns[:, None], ~turns[:, None])
    mixed = [np.where(hidden, x, np.nan) for x in (log.q, log.v, log.tau)]
    path = write_joint_log(type(log)(log.names, log.t_ns, *mixed), tmp_path / 'bag', urdf, None)
    model = stated_armature(Bag.open(path), path, None, None, {'*': 0.0})
    assert model.joint_names == ARM
    assert len(read_recorded_robot(path, model).log) == turns.sum()


def test_an_armature_that_is_not_stated_is_asked_for(arm, tmp_path):
    urdf, log = arm
    path = write_joint_log(log, tmp_path / 'bag', urdf, None)
    with pytest.raises(ConfigurationError, match=r'armature of joint j1, j2, .* --armature'):
        _ = read_recorded_robot(path).robot
    model = stated_armature(Bag.open(path), path, None, None, {'j1': 0.0})
    with pytest.raises(ConfigurationError, match='armature of joint j2, j3'):
        _ = read_recorded_robot(path, model).robot


def test_a_recording_of_another_robot_is_refused(arm, tmp_path):
    urdf, log = arm
    other = type(log)(tuple(f'x{k}' for k in range(9)), log.t_ns, log.q, log.v, log.tau)
    path = write_joint_log(other, tmp_path / 'bag', urdf, None)
    with pytest.raises(DataError, match='is not in the recording'):
        read_recorded_robot(path, skeleton_model(urdf).with_armature({'*': 0.1}))
    with pytest.raises(ConfigurationError, match='no joint of type revolute'):
        stated_armature(Bag.open(path), path, None, None, {'*': 0.0})


def test_a_joint_that_a_person_wrote_into_the_model_must_be_recorded(arm, tmp_path):
    """Unlike one that the model has only because the URDF has it."""
    urdf, log = arm
    path = write_joint_log(log.select(ARM[:3]), tmp_path / 'part', urdf, None)
    written = replace(skeleton_model(urdf).with_armature({'*': 0.1}), provenance={})
    with pytest.raises(DataError, match='joint j4, j5, j6, j7, finger_a is not in the recording'):
        read_recorded_robot(path, written)


def test_a_joint_that_is_not_in_the_model_is_held_where_it_was_recorded(arm, tmp_path):
    """Unless it is stated where; and if it moves, it is said by how much."""
    urdf, log = arm
    path = write_joint_log(log, tmp_path / 'bag', urdf, None)
    model = skeleton_model(urdf, ARM[3:]).with_armature({'*': 0.1}).with_locked({'j2': 0.3})
    found = read_recorded_robot(path, model).robot
    q = dict(zip(log.names, log.q.T, strict=True))
    where = {'j1': q['j1'][0], 'j2': 0.3, 'j3': q['j3'][0], 'finger_a': 0.0, 'finger_b': 0.0}
    assert found.held == pytest.approx(where)
    assert len(found.remarks) == 3
    (told,) = (text for text in found.remarks if text.startswith('joint j1 '))
    assert f'held at {q["j1"][0]:.4g} rad' in told
    assert f'moves by {np.ptp(q["j1"]):.2g} rad all the same' in told
    (still,) = (text for text in found.remarks if text.startswith('joint finger_a '))
    assert 'moves by' not in still
