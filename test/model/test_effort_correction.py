# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that a model knows to be measured wrongly becomes the torque that it was."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.effort_correction import EffortCorrection
from sosml_friction.model.model_folder import EffectTerm, JointModel, RobotModelFile
from sosml_friction.model.parameter import Parameter

NAMES = ('shoulder', 'elbow')


def term(effect, joint, **values):
    return EffectTerm(effect, joint, {key: Parameter(value, '1') for key, value in values.items()})


def model(*effects):
    joints = {name: JointModel(Parameter(0.01, 'kg m2')) for name in NAMES}
    return RobotModelFile('arm', joints, effects=tuple(effects))


SCALE = term('effort_scale', 'shoulder', error=0.08)
COMMON = term('effort_scale', '*', error=0.08)
BIAS = term('effort_bias', 'elbow', bias=-0.2)
CUBE = term('effort_saturation', 'shoulder', excess=0.45, reference=1.0)
CROSS = term('joint_coupling', 'shoulder', coupling=0.1, source=1.0)


@pytest.mark.parametrize(
    ('effects', 'reported'),
    [
        ((SCALE,), lambda a, b: (1.08 * a, b)),
        ((COMMON, BIAS), lambda a, b: (1.08 * a, 1.08 * b - 0.2)),
        ((BIAS,), lambda a, b: (a, b - 0.2)),
        ((CUBE,), lambda a, b: (a + 0.45 * a**3, b)),
        ((CROSS,), lambda a, b: (a + 0.1 * b, b)),
        ((SCALE, BIAS, CROSS), lambda a, b: (1.08 * a + 0.1 * (b - 0.2), b - 0.2)),
    ],
)
def test_the_torque_comes_back(effects, reported):
    """At three times the reference too, where the cube is four times the torque."""
    tau = np.random.default_rng(0).uniform(-3.0, 3.0, (200, 2))
    effort = np.column_stack(reported(*tau.T))
    correction = EffortCorrection(model(*effects))
    assert correction
    assert correction.torque(effort) == pytest.approx(tau, abs=1e-12)
    # One sample after another gives the same bits: a replay is the live run.
    one_by_one = np.array([correction.torque(row) for row in effort])
    np.testing.assert_array_equal(one_by_one, correction.torque(effort))


def test_unknown_effort_stays_unknown_and_spoils_only_what_it_is_passed_to():
    effort = np.array([1.0, np.nan])
    assert np.isnan(EffortCorrection(model(BIAS)).torque(effort)[1])
    assert EffortCorrection(model(SCALE)).torque(effort)[0] == pytest.approx(1.0 / 1.08, rel=1e-15)
    assert np.isnan(EffortCorrection(model(CROSS)).torque(effort)).all()


def test_what_is_friction_or_a_load_is_not_touched():
    other = [
        term('load_dependent_friction', 'shoulder', load_coefficient=0.1),
        term('spring', 'elbow', stiffness=0.4, offset=0.0),
    ]
    correction = EffortCorrection(model(*other))
    assert not correction
    assert correction.left_out == ()
    np.testing.assert_array_equal(correction.torque(np.array([1.0, 2.0])), [1.0, 2.0])


def test_a_delay_is_left_out_and_told_in_one_sentence():
    correction = EffortCorrection(model(term('effort_delay', '*', delay=4e-3)))
    assert not correction
    (sentence,) = correction.left_out
    assert 'effort_delay' in sentence
    assert 'all joints' in sentence


@pytest.mark.parametrize(
    ('effect', 'words'),
    [
        (term('effort_scale', 'shoulder'), 'no error'),
        (term('effort_scale', 'shoulder', error=float('nan')), 'no value of error'),
        (term('effort_scale', 'shoulder', error=-1.0), 'cannot be undone'),
        (term('effort_saturation', 'elbow', excess=-0.1, reference=1.0), 'cannot be undone'),
        (term('joint_coupling', 'elbow', coupling=0.1, source=1.0), 'cannot be undone'),
        (term('joint_coupling', 'elbow', coupling=0.1, source=7.0), 'cannot be undone'),
        (term('effort_bias', '*', bias=0.1), 'acts in one joint'),
    ],
)
def test_what_cannot_be_undone_is_refused(effect, words):
    with pytest.raises(ConfigurationError, match=words):
        EffortCorrection(model(effect))


def test_a_coupling_with_two_joints_is_undone_with_both():
    """A diagnosis lists the second source of one joint as ``coupling_2`` and ``source_2``."""
    names = ('a', 'b', 'c')
    joints = {name: JointModel(Parameter(0.01, 'kg m2')) for name in names}
    both = term('joint_coupling', 'a', coupling=0.1, source=1.0, coupling_2=-0.3, source_2=2.0)
    tau = np.random.default_rng(1).uniform(-3.0, 3.0, (50, 3))
    reported = tau + np.outer(0.1 * tau[:, 1] - 0.3 * tau[:, 2], [1.0, 0.0, 0.0])
    correction = EffortCorrection(RobotModelFile('arm', joints, effects=(both,)))
    assert correction.torque(reported) == pytest.approx(tau, abs=1e-12)
    half = term('joint_coupling', 'a', coupling=0.1, source=1.0, coupling_2=-0.3)
    with pytest.raises(ConfigurationError, match='has no source'):
        EffortCorrection(RobotModelFile('arm', joints, effects=(half,)))
