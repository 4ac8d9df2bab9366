# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The overlap of causes is that of least squares, and orders them as their equations do."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, recording, rigid_effort

from sosml_friction.diagnosis.decision.confusability import Confusability, confusability
from sosml_friction.diagnosis.library import make_library
from sosml_friction.model.terms.kinds.term import ALL_JOINTS
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression


@pytest.fixture(scope='module')
def laboratory():
    """Return the exoskeleton along two sinusoids in each joint, without anything hidden."""
    model = arm_model()
    t = np.arange(0.0, 40.0, 4e-3)
    lines = (((0.5, 0.9, 0.0), (0.1, 4.0, 0.0)), ((0.6, 1.3, 1.0), (0.1, 5.0, 1.0)))
    q, v, a = arm_motion(t, lines)
    tau = rigid_effort(model, q, v, a) + 0.5 * np.tanh(v / 2e-3) + 0.2 * v
    tau += np.random.default_rng(0).normal(0.0, 0.05, tau.shape)
    log = recording(('shoulder', 'elbow'), t, q, tau, v)
    settings = DiagnosisSettings(band=15.0)
    library = make_library(('cogging',))
    return WhitenedRegression.make(
        prepare([log], model, model.make_robot(), settings), library, settings
    )


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


def test_a_cause_is_itself_in_the_order_of_the_candidates(laboratory):
    found = confusability(laboratory)
    assert np.diag(found.share) == pytest.approx(1.0)
    names = [(x.effect.identifier, x.joint) for x in laboratory.candidates]
    assert list(found.effects) == [effect for effect, _ in names]
    assert found.share.shape == (len(names), len(names))
    # Not all of them are the same.
    assert np.median(found.share) < 0.5


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
