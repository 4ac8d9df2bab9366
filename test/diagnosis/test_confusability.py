# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The overlap of causes is that of least squares, and orders them as their equations do."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.confusability import Confusability, confusability
from sosml_friction.diagnosis.effect import ALL_JOINTS
from sosml_friction.diagnosis.laboratory import Laboratory
from sosml_friction.diagnosis.library import make_library
from sosml_friction.diagnosis.settings import DiagnosisSettings
from sosml_friction.diagnosis.signals import prepare
from sosml_friction.model.model_folder import (
    FrictionParameters,
    JointModel,
    RobotModelFile,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory

STEP = 4e-3


@pytest.fixture(scope='module')
def laboratory():
    """Return the exoskeleton along two sinusoids in each joint, without anything hidden."""
    shipped = read_model(share_directory() / 'config/exoskeleton')
    parameters = {
        'coulomb': Parameter(0.5, 'Nm'),
        'viscous': Parameter(0.2, 'Nm s/rad'),
        'bias': Parameter(0.0, 'Nm'),
    }
    friction = FrictionParameters('coulomb_viscous', 0.0, parameters)
    joints = {name: JointModel(j.armature, friction) for name, j in shipped.joints.items()}
    model = RobotModelFile('arm', joints, shipped.urdf)
    robot = model.make_robot()
    t = np.arange(0.0, 40.0, STEP)
    q, v, a = np.zeros((3, len(t), 2))
    for i, lines in enumerate((((0.5, 0.9), (0.1, 4.0)), ((0.6, 1.3), (0.1, 5.0)))):
        for size, w in lines:
            q[:, i] += size * np.sin(w * t + i)
            v[:, i] += size * w * np.cos(w * t + i)
            a[:, i] -= size * w**2 * np.sin(w * t + i)
    q += np.array([-0.8, 0.9])
    tau = np.array([robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
    tau += 0.5 * np.tanh(v / 2e-3) + 0.2 * v
    tau += np.random.default_rng(0).normal(0.0, 0.05, tau.shape)
    log = JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)
    settings = DiagnosisSettings(band=15.0)
    library = make_library(('cogging',))
    return Laboratory(prepare([log], model, robot, settings), library, settings)


def columns(laboratory, effect, joint, joints=(0, 1)):
    """Return the whitened columns (g, rows of both joints, k) of a candidate."""
    for candidate, its in zip(laboratory.candidates, laboratory.columns, strict=True):
        if candidate.effect.identifier == effect and candidate.joint == joint:
            rows, _, grid, k = its.C.shape
            wide = np.zeros((rows, len(joints), grid, k))
            wide[:, its.rows] = its.C
            return wide.reshape(rows * len(joints), grid, k).transpose(1, 0, 2)
    raise KeyError(effect)


def left(X, y):
    """Return what least squares leaves of the energy of y."""
    X = X / np.maximum(np.linalg.norm(X, axis=0), 1e-300)
    return float(np.sum((y - X @ np.linalg.lstsq(X, y, rcond=1e-10)[0]) ** 2))


@pytest.mark.parametrize('free', [False, True])
@pytest.mark.parametrize(
    ('one', 'other'),
    [('load_dependent_friction', 'position_dependent_friction'),
     ('load_dependent_friction', 'stribeck'), ('effort_saturation', 'presliding_hysteresis'),
     ('load_dependent_friction', 'gravity_tilt')],
)  # fmt: skip
def test_the_share_is_that_of_least_squares(laboratory, one, other, free):
    p = len(laboratory.nominal.bound)
    found = confusability(laboratory, bound=np.full(p, np.inf if free else 0.0))
    Z = laboratory.system.Z.reshape(-1, p) if free else np.zeros((2 * len(laboratory.y), 0))
    # One column, one point of the grid.
    y = columns(laboratory, one, 0)[0, :, 0]
    whole = left(Z, y)
    rivals = columns(laboratory, other, 0)
    rest = min(left(np.concatenate([Z, X], axis=1), y) for X in rivals)
    where = ALL_JOINTS if other == 'gravity_tilt' else 'shoulder'
    # 1e-6: what keeps the equations of free deviations regular.
    assert found.of((one, 'shoulder'), (other, where)) == pytest.approx(
        1.0 - rest / whole, abs=1e-5
    )
    absorbed = found.absorbed[found.effects.index(one)]
    assert absorbed == pytest.approx(1.0 - whole / float(y @ y), abs=1e-5)


def test_a_cause_is_itself_and_shares_lie_between_none_and_all(laboratory):
    found = confusability(laboratory)
    assert np.diag(found.share) == pytest.approx(1.0)
    assert found.share.min() >= 0.0
    assert found.share.max() <= 1.0
    assert len(found.share) == len(laboratory.candidates)


def test_the_narrower_cause_is_explained_by_the_wider_and_not_the_other_way_round(laboratory):
    fixed = confusability(laboratory, bound=np.zeros(len(laboratory.nominal.bound)))
    one, other = ('effort_bias', 'elbow'), ('spring', 'elbow')
    # A spring has its offset.
    assert fixed.of(one, other) == pytest.approx(1.0, abs=1e-6)
    assert fixed.of(other, one) < 0.8


def test_what_a_nominal_parameter_takes_wholly_is_no_cause_of_its_own(laboratory):
    free = confusability(laboratory, bound=np.full(len(laboratory.nominal.bound), np.inf))
    for effect in ('coulomb', 'viscous', 'inertia', 'gravity', 'effort_bias'):
        assert free.absorbed[free.effects.index(effect)] == pytest.approx(1.0, abs=1e-6)


def test_the_document_has_a_row_for_each_candidate():
    found = Confusability(('coulomb', 'payload'), ('elbow', '*'), np.eye(2), np.array([0.5, 0.25]))
    assert found.to_dict() == {
        'candidates': [
            {'effect': 'coulomb', 'joint': 'elbow', 'absorbed': 0.5},
            {'effect': 'payload', 'joint': '*', 'absorbed': 0.25},
        ],
        'share': [[1.0, 0.0], [0.0, 1.0]],
    }
    with pytest.raises(KeyError):
        found.of(('spring', 'elbow'), ('coulomb', 'elbow'))
