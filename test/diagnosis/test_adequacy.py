# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A cause whose own axis holds more than it explains is not the whole."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.settings import DiagnosisSettings
from sosml_friction.diagnosis.sign_state import sign_state
from sosml_friction.model.model_folder import (
    FrictionParameters,
    JointModel,
    RobotModelFile,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory

STEP = 4e-3


def diagnosed(extra):
    """Return the diagnosis of a slider with friction 20 s + 200 v + extra(v) [N]."""
    shipped = read_model(share_directory() / 'config/emps')
    parameters = {
        'coulomb': Parameter(20.3, 'N'),
        'viscous': Parameter(196.0, 'N s/m'),
        'bias': Parameter(0.0, 'N'),
    }
    friction = FrictionParameters('coulomb_viscous', 0.0, parameters)
    slider = JointModel(shipped.joints['slider'].armature, friction)
    model = RobotModelFile('slider', {'slider': slider}, shipped.urdf)
    t = np.arange(0.0, 28.0, STEP)
    q, v, a = np.zeros((3, len(t)))
    for size, w in ((0.08, 0.9), (0.02, 2.1)):
        q += size * np.sin(w * t)
        v += size * w * np.cos(w * t)
        a -= size * w**2 * np.sin(w * t)
    tau = 95.1089 * a + 20.0 * sign_state(q, 4e-5) + 200.0 * v + extra(v)
    tau += np.random.default_rng(1).normal(0.0, 1.0, len(t))
    log = JointLog(
        ('slider',), np.rint(t * 1e9).astype(np.int64), q[:, None],
        np.full((len(t), 1), np.nan), tau[:, None],
    )  # fmt: skip
    return diagnose([log], model, settings=DiagnosisSettings(nulls=8))


@pytest.mark.parametrize(
    ('extra', 'verdict'),
    [
        (lambda v: 60.0 * v, 'named'),
        # Quadratic drag is in no catalogue; a viscous friction of its mean slope fits most of it.
        (lambda v: 250.0 * v * np.abs(v), 'unknown_structure'),
    ],
)
def test_viscous_friction_is_named_and_quadratic_drag_is_not_called_viscous(extra, verdict):
    found = diagnosed(extra)
    assert found.verdict == verdict
    assert found.causes[0].effect == 'viscous'
    (axis,) = found.structure['axes']
    assert axis['unknown'] == (verdict == 'unknown_structure')
    assert ('depends on speed in another way' in found.sentence) == axis['unknown']


def test_a_constant_offset_while_moving_is_a_bias_or_an_asymmetry_and_said_to_be_either():
    """Without rest only reversals tell them apart, and how friction turns around is not known."""
    found = diagnosed(lambda v: 8.0 + 0.0 * v)
    first = found.causes[0]
    assert {first.effect, *first.rivals} == {'effort_bias', 'asymmetric_friction'}
    assert found.verdict == 'ambiguous'
