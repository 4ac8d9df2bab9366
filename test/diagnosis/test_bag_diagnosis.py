# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of a robot whose rotors are not known: they are fitted before it is diagnosed."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, recording, rigid_effort

from sosml_friction.bags.source import log_source
from sosml_friction.diagnosis.bag_diagnosis import diagnose_logs
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.regression.settings import DiagnosisSettings


def without_rotors(model):
    """Return a model that does not know the armature of its joints."""
    unknown = {
        name: replace(joint, armature=replace(joint.armature, value=np.nan))
        for name, joint in model.joints.items()
    }
    return replace(model, joints=unknown)


def told(q, v, a, tau=None):
    """Diagnose the arm along a motion, which needs the effort of its bodies and friction."""
    model = arm_model()
    if tau is None:
        tau = rigid_effort(model, q, v, a) + 0.5 * np.tanh(v / 5e-3) + 0.2 * v
        tau += np.random.default_rng(0).normal(0.0, 0.02, tau.shape)
    log = recording(model.joint_names, 5e-3 * np.arange(len(q)), q, tau)
    settings = DiagnosisSettings(band=15.0)
    return diagnose_logs([(log_source(log, 'log'), log)], without_rotors(model), settings=settings)


def test_the_rotor_of_a_joint_that_rests_is_not_fitted(monkeypatch):
    compared, compare = [], BodyComparison.of

    def watch(logs, *others):
        compared.append(compare(logs, *others))
        assert np.isnan(logs[0].tau[:, 0]).all()
        return compared[-1]

    monkeypatch.setattr(BodyComparison, 'of', watch)
    q, v, a = (x.copy() for x in arm_motion(np.arange(0.0, 24.0, 5e-3)))
    q[:, 0] = v[:, 0] = a[:, 0] = 0.0
    found = told(q, v, a).diagnosis
    assert found.verdict == 'nothing_above_floor'
    (own,) = compared
    rotors = own.refit.armature
    assert rotors['shoulder'].value == 0.0
    assert 'effort is not known' in rotors['shoulder'].reason
    elbow = arm_model().joints['elbow'].armature.value
    assert rotors['elbow'].value == pytest.approx(elbow, abs=3.0 * rotors['elbow'].std_error)


def test_data_that_are_of_no_use_are_bad_data_whatever_the_model_knows():
    q = np.zeros((4000, 2))
    found = told(q, q, q, q).diagnosis
    assert found.verdict == 'bad_data'
