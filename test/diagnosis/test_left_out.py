# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint that says nothing is named and left out, and the others are diagnosed as ever."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, recording, rigid_effort

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.library import make_library, searched_terms
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression

JOINTS = ('shoulder', 'elbow')
T = np.arange(0.0, 24.0, 4e-3)
#: Looked for: few causes, so that a diagnosis takes seconds.
SOUGHT = ('asymmetric_friction', 'load_dependent_friction', 'effort_scale')
WITHOUT = tuple(name for name in searched_terms() if name not in SOUGHT)


def motion(elbow_rests: bool):
    """Return a log in which the shoulder needs 0.25 Nm more forwards and less backwards."""
    model = arm_model()
    q, v, a = arm_motion(T)
    if elbow_rests:
        q[:, 1], v[:, 1], a[:, 1] = 1.2, 0.0, 0.0
    tau = rigid_effort(model, q, v, a) + 0.5 * np.sign(v) + 0.2 * v
    tau[:, 0] += 0.25 * (1.0 - 0.2 * np.abs(v[:, 0]))
    tau += np.random.default_rng(0).normal(0.0, 0.01, tau.shape)
    if elbow_rests:
        # It gives way to its load by a tenth of a millirad, in steps of an encoder.
        q[:, 1] += 1e-5 * np.rint(10.0 * tau[:, 1])
    return recording(JOINTS, T, q, tau, v), model


def unknown(log, joint):
    tau = log.tau.copy()
    tau[:, joint] = np.nan
    return replace(log, tau=tau)


@pytest.mark.parametrize('rests', [True, False], ids=['rests', 'has_no_effort'])
def test_the_other_joint_is_diagnosed_and_the_silent_one_named(rests):
    log, model = motion(rests)
    found = diagnose([log if rests else unknown(log, 1)], model, without=WITHOUT)
    told = [check for check in found.checks if check.severity == 'bad']
    assert [(check.joint, check.kind) for check in told] == [
        ('elbow', 'motion' if rests else 'effort')
    ]
    assert found.verdict in ('named', 'ambiguous')
    assert {cause.joint for cause in found.causes} <= {'shoulder', '*'}
    assert 'asymmetric_friction' in {cause.effect for cause in found.causes}
    assert list(found.gain.to_dict(found.names, found.units)) == ['shoulder']
    assert found.gain.forward_after[0] < found.gain.forward_before[0]
    assert 'nan' not in found.sentence


def test_the_model_explains_the_data_of_the_joints_that_say_something():
    log, model = motion(False)
    tau = log.tau.copy()
    tau[:, 0] -= 0.25 * (1.0 - 0.2 * np.abs(log.v[:, 0]))
    found = diagnose([unknown(replace(log, tau=tau), 1)], model, without=WITHOUT)
    assert found.verdict == 'nothing_above_floor'
    assert found.sentence.startswith('The refitted model explains the data of shoulder: ')
    assert ' Of elbow nothing is known' in found.sentence


def test_an_unknown_structure_of_one_joint_says_that_nothing_is_known_of_the_other():
    log, model = motion(False)
    tau = log.tau.copy()
    tau[:, 0] += 0.5 * np.sin(2.0 * np.pi * 1.3 * log.time)
    found = diagnose([unknown(replace(log, tau=tau), 1)], model, without=WITHOUT)
    assert found.verdict == 'unknown_structure'
    assert ' Of elbow nothing is known: see first what is said of the data.' in found.sentence


def test_silent_rows_are_zero_and_count_for_nothing():
    log, model = motion(False)
    settings = DiagnosisSettings(band=15.0)
    signals = prepare([unknown(log, 1)], model, model.make_robot(), settings)
    made = WhitenedRegression.make(signals, make_library(WITHOUT), settings)
    assert not made.y[:, 1].any()
    assert made.y[:, 0].std() > 0.5
    assert made.known[1] == 0.0
    assert made.known[0] > 0.0
    assert not [name for name in made.nominal.names if name.startswith('elbow coulomb')]
    assert {c.joint for c in made.candidates if not c.effect.of_robot} <= {-1, 0}


def test_a_joint_that_moves_in_one_of_two_recordings_is_known_there():
    resting, model = motion(True)
    moving, _ = motion(False)
    settings = DiagnosisSettings(band=15.0)
    logs = [unknown(resting, 1), moving]
    signals = prepare(logs, model, model.make_robot(), settings)
    made = WhitenedRegression.make(signals, make_library(WITHOUT), settings)
    half = len(made.y) // 2
    assert not made.y[: half - 20, 1].any()
    assert made.y[half + 20 :, 1].any()
    assert made.known[1] == pytest.approx(0.5 * made.known[0], rel=0.05)
    assert 'elbow coulomb' in made.nominal.names


def test_nothing_is_diagnosed_where_no_joint_has_effort():
    log, model = motion(False)
    found = diagnose([unknown(unknown(log, 0), 1)], model, without=WITHOUT)
    assert found.verdict == 'bad_data'
    assert 'shoulder has no effort' in found.sentence


@pytest.mark.parametrize(
    ('q', 'tau', 'said'),
    [(180.0 / np.pi, 1.0, 'is in degrees'), (1.0, -1.0, 'turn the sign'), (1.0, 0.05, 'not in')],
)
def test_what_is_wrong_with_columns_is_said_of_them(q, tau, said):
    log, model = motion(False)
    log = replace(log, q=q * log.q, v=q * log.v, tau=tau * log.tau)
    found = diagnose([log], model, without=WITHOUT)
    assert found.verdict == 'bad_data'
    assert said in found.sentence
