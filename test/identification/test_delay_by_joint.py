# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Drives of two kinds in one arm: each reports its effort late by its own time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from full_runs import in_full
from known_robots import arm_model, arm_motion, recording, rigid_effort

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.identification.effort_timing import TIMING
from sosml_friction.identification.log_analysis import analyse_log
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.settings import DiagnosisSettings

STEP = 5e-3
COULOMB, VISCOUS = 0.5, 0.2
NAMES = ('shoulder', 'elbow')


@pytest.fixture(scope='module')
def model() -> RobotModelFile:
    """Return the arm with its own friction."""
    return arm_model((COULOMB, VISCOUS), (COULOMB, VISCOUS))


def late_by(model: RobotModelFile, samples: Sequence[float], seed: int = 0) -> JointLog:
    """Return 40 s at 200 Hz whose efforts are late by so many samples each."""
    t = np.arange(0.0, 40.0, STEP)
    tau = np.empty((len(t), 2))
    for i, late in enumerate(samples):
        q, v, a = arm_motion(t - late * STEP)
        friction = COULOMB * np.tanh(v / 1e-3) + VISCOUS * v
        tau[:, i] = (rigid_effort(model, q, v, a) + friction)[:, i]
    rng = np.random.default_rng(seed)
    q = arm_motion(t)[0] + 1e-5 * rng.standard_normal(tau.shape)
    return recording(NAMES, t, q, tau + 0.02 * rng.standard_normal(tau.shape))


@pytest.mark.parametrize(
    'samples',
    [in_full((0.0, 0.0)), (-0.4, 0.4), (0.0, 2.0)],
    ids=['in time', 'within', 'by samples'],
)
def test_viscous_friction_is_right_whenever_efforts_of_joints_act(model, samples):
    found = analyse_log(late_by(model, samples), model)
    for fits in found.fit.joints.values():
        for name, true in (('coulomb', COULOMB), ('viscous', VISCOUS)):
            p = fits['weak_form'].fit.parameters[name]
            assert abs(p.value - true) < 3.0 * p.std_error
            assert p.std_error < 0.05 * true
    said = [(f.check, f.joint) for f in found.data_checks.findings]
    said = [each for each in said if each[0] in (TIMING, 'late_effort')]
    assert (
        said
        == {
            (0.0, 0.0): [(TIMING, '*')],
            (-0.4, 0.4): [(TIMING, 'shoulder'), (TIMING, 'elbow')],
            (0.0, 2.0): [('late_effort', 'elbow')],
        }[samples]
    )


@pytest.mark.parametrize(
    ('samples', 'named'),
    [((0.4, -0.4), {}), ((0.0, 1.2), {'elbow': 1.2}), ((1.2, 1.2), {'*': 1.2})],
    ids=['within an interval', 'one joint', 'both'],
)
def test_the_joint_whose_effort_is_late_is_named(model, samples, named):
    """
    Or all are, where it is within an interval of the others.

    An elbow that is 1.2 samples late may be 0.7 late as both are, and at the end of its interval.
    """
    found = diagnose([late_by(model, samples)], model, settings=DiagnosisSettings())
    answers = [
        {cause.joint, *(r.partition('@')[2] for r in cause.rivals)} for cause in found.causes
    ]
    assert {cause.effect for cause in found.causes} <= {'effort_delay'}
    assert len(answers) == len(named)
    assert all(set(named) <= answer <= {*named, '*'} for answer in answers)
    for cause in found.causes:
        delay = cause.parameters['delay']
        assert abs(delay.value - named[cause.joint] * STEP) < 2.0 * delay.std_error


def test_a_large_delay_of_one_joint_is_undone_in_that_joint(model):
    """By its column alone it was 17.4 ms: 2 pi f d is 2.2 of the fastest sine of the band."""
    found = diagnose([late_by(model, (0.0, 4.0))], model, settings=DiagnosisSettings())
    assert [cause.key for cause in found.causes] == [('effort_delay', 'elbow')], found.sentence
    assert [check.joint for check in found.checks if check.kind == 'effort_delay'] == ['elbow']
    delay = found.causes[0].parameters['delay']
    assert abs(delay.value - 4.0 * STEP) < 2.0 * delay.std_error
    assert delay.std_error < 0.1 * STEP
