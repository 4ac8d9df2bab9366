# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml diagnose`` on what cannot be diagnosed: one sentence, exit code 2, nothing written."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.diagnosis.library import searched_terms
from sosml_friction.model.model_folder import EffectTerm, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory

CONFIG = share_directory() / 'config'


def log_of(names=('slider',), effort=True, seed=0):
    """Return four seconds of motion."""
    t = np.arange(0.0, 4.0, 4e-3)
    q = np.column_stack([0.1 * np.sin(2.0 * t + k) for k in range(len(names))])
    tau = np.random.default_rng(seed).normal(0.0, 1.0, q.shape)
    unknown = np.full_like(q, np.nan)
    return JointLog(
        names, np.rint(t * 1e9).astype(np.int64), q, unknown, tau if effort else unknown
    )


def bag_of(folder, log=None, model='emps'):
    """Return a bag that knows its robot, or with ``model`` None does not."""
    if model is None:
        return write_joint_log(log or log_of(), folder)
    known = read_model(CONFIG / model)
    return write_joint_log(log or log_of(), folder, known.urdf, known.to_yaml())


@pytest.fixture
def refused(refused):
    """Return a function that runs the command, and returns its one sentence."""
    return partial(refused, 'diagnose')


def test_a_bag_without_model(refused, tmp_path):
    err = refused(bag_of(tmp_path / 'bag', model=None))
    assert 'no robot_description' in err
    assert '--urdf' in err


def test_a_model_folder_that_is_not_there(refused, tmp_path):
    assert 'nowhere' in refused(bag_of(tmp_path / 'bag'), '--model', tmp_path / 'nowhere')


def test_a_model_of_another_robot(refused, tmp_path):
    err = refused(bag_of(tmp_path / 'bag'), '--model', CONFIG / 'exoskeleton')
    assert 'shoulder' in err
    assert 'slider' in err


def test_a_bag_without_effort(refused, tmp_path):
    assert 'no effort' in refused(bag_of(tmp_path / 'bag', log_of(effort=False)))


def test_an_empty_bag(refused, tmp_path):
    with BagRecorder(tmp_path / 'bag') as recorder:
        recorder.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
    assert 'holds no message' in refused(tmp_path / 'bag')


def test_no_bag(refused, tmp_path):
    assert 'does not exist' in refused(tmp_path / 'nowhere')


def test_two_bags_of_different_robots(refused, tmp_path):
    slider = bag_of(tmp_path / 'slider')
    arm = bag_of(tmp_path / 'arm', log_of(('shoulder', 'elbow')), 'exoskeleton')
    err = refused(slider, arm)
    assert 'not of the same robot' in err
    assert 'shoulder, elbow' in err


def test_two_bags_that_were_recorded_with_different_models(refused, tmp_path):
    """Which of them is put to the test is for the user to say."""
    known = read_model(CONFIG / 'emps')
    numbers = {'stiffness': Parameter(10.0, 'N/m'), 'offset': Parameter(0.0, 'N')}
    sprung = replace(known, effects=(EffectTerm('spring', 'slider', numbers),))
    first = bag_of(tmp_path / 'first')
    second = write_joint_log(log_of(seed=1), tmp_path / 'second', sprung.urdf, sprung.to_yaml())
    err = refused(first, second)
    assert 'different models' in err
    assert '--model' in err


def test_a_bag_twice_and_a_copy_of_it(refused, tmp_path):
    bag = bag_of(tmp_path / 'bag')
    assert 'given twice' in refused(bag, bag)
    shutil.copytree(bag, tmp_path / 'copy')
    assert 'copies of one recording' in refused(bag, tmp_path / 'copy')


def test_a_recording_left_out_that_is_of_another_robot(refused, tmp_path):
    bag = bag_of(tmp_path / 'bag')
    arm = bag_of(tmp_path / 'arm', log_of(('shoulder', 'elbow')), 'exoskeleton')
    assert 'not of the same robot' in refused(bag, '--holdout', arm)
    err = refused(bag, '--holdout', arm, '--model', CONFIG / 'emps')
    assert 'arm (holdout): joint slider is not in the recording' in err


def test_a_recording_left_out_that_is_the_one_diagnosed(refused, tmp_path):
    bag = bag_of(tmp_path / 'bag')
    shutil.copytree(bag, tmp_path / 'copy')
    assert 'another one' in refused(bag, '--holdout', tmp_path / 'copy')


def test_an_effect_in_the_model_that_nobody_knows(refused, tmp_path):
    shutil.copytree(CONFIG / 'emps', tmp_path / 'model')
    file = tmp_path / 'model' / 'model.yaml'
    (tmp_path / 'model' / 'robot.urdf').write_text(str(read_model(CONFIG / 'emps').urdf))
    text = file.read_text().replace('../../urdf/emps.urdf', 'robot.urdf')
    file.write_text(text + '\neffects: [{effect: stiction, joint: slider, parameters: {}}]\n')
    err = refused(bag_of(tmp_path / 'bag'), '--model', tmp_path / 'model')
    assert "'stiction'" in err
    assert 'stribeck' in err


def test_an_effect_to_leave_out_that_nobody_knows(refused, tmp_path):
    err = refused(bag_of(tmp_path / 'bag'), '--without', 'stribeck,magic')
    assert "'magic'" in err


def test_a_place_that_cannot_be_written_is_refused_before_anything_is_computed(
    refused, tmp_path, monkeypatch
):
    bag = bag_of(tmp_path / 'bag')
    (tmp_path / 'file').write_text('mine')
    monkeypatch.setattr('sosml_friction.diagnosis.bag_diagnosis.diagnose_bags', pytest.fail)
    assert 'cannot be written' in refused(bag, '--out', tmp_path / 'file' / 'why')
    assert 'not overwritten' in refused(bag, '--out', tmp_path / 'file')
    (tmp_path / 'thesis').mkdir()
    (tmp_path / 'thesis' / 'model.yaml').write_text('mine')
    assert 'not overwritten' in refused(bag, '--out', tmp_path / 'thesis')


def test_without_every_cause(refused, tmp_path):
    err = refused(bag_of(tmp_path / 'bag'), '--without', ','.join(searched_terms()))
    assert 'no cause is left' in err
