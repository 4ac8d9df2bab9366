# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A nominal that is wrong in its torque constant or lacks a spring is not called friction."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.settings import DiagnosisSettings
from sosml_friction.model.model_folder import (
    FrictionParameters,
    JointModel,
    RobotModelFile,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory

STEP, DURATION = 5e-3, 24.0
#: The floor needs the largest of some nulls, not a quantile: fewer make these tests shorter, and
#: the effects here are many times the floor.
SETTINGS = DiagnosisSettings(band=15.0, nulls=5)


def arm(duration=DURATION):
    """Return the model of the arm, its exact motion, and the effort that is the model's own."""
    shipped = read_model(share_directory() / 'config/exoskeleton')
    parameters = {
        'coulomb': Parameter(0.5, 'Nm'),
        'viscous': Parameter(0.2, 'Nm s/rad'),
        'bias': Parameter(0.0, 'Nm'),
    }
    friction = FrictionParameters('coulomb_viscous', 0.0, parameters)
    joints = {name: JointModel(j.armature, friction) for name, j in shipped.joints.items()}
    model = RobotModelFile('arm', joints, shipped.urdf)
    t = np.arange(0.0, duration, STEP)
    q, v, a = np.zeros((3, len(t), 2))
    for i, lines in enumerate(
        (((0.5, 0.9, 0.0), (0.1, 4.0, 1.0)), ((0.6, 1.3, 0.5), (0.1, 5.0, 2.0)))
    ):
        for size, w, phase in lines:
            q[:, i] += size * np.sin(w * t + phase)
            v[:, i] += size * w * np.cos(w * t + phase)
            a[:, i] -= size * w**2 * np.sin(w * t + phase)
    return model, t, q + np.array([-0.8, 0.9]), v, a


@pytest.fixture(scope='module')
def motion():
    """Return the model, time, position, and rigid and whole effort (N, 2)."""
    model, t, q, v, a = arm()
    robot = model.make_robot()
    rigid = np.array([robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
    return model, t, q, rigid + 0.5 * np.tanh(v / 5e-3) + 0.2 * v


@pytest.mark.parametrize(
    ('fault', 'joint'),
    [
        ('effort_scale', 'shoulder'),
        ('spring', 'elbow'),
    ],
)
def test_a_wrong_nominal_is_named_as_such_and_not_as_friction(motion, fault, joint):
    model, t, q, tau = motion
    tau = tau.copy()
    if fault == 'effort_scale':
        tau[:, 0] *= 1.04
    else:
        tau[:, 1] += 0.4 * (q[:, 1] - 0.3)
    tau += np.random.default_rng(0).normal(0.0, 0.02, tau.shape)
    log = JointLog(
        ('shoulder', 'elbow'), np.rint(t * 1e9).astype(np.int64), q, np.full_like(q, np.nan), tau
    )
    found = diagnose([log], model, settings=SETTINGS)
    first = found.causes[0]
    assert fault in {first.effect, *first.rivals}
    assert first.joint == joint
