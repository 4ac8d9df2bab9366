# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A nominal friction that is a guess: told with its sizes, or trusted as little as it is worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_runs import in_full
from known_robots import (
    SLIDER_MASS,
    SLIDER_STEP,
    arm_model,
    arm_motion,
    recording,
    rigid_effort,
    sines,
    slider_model,
    slider_recording,
    smooth_sign,
)

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.model_folder import FrictionParameters
from sosml_friction.model.parameter import Parameter
from sosml_friction.regression.nominal import make_nominal
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

#: Looked for besides what is asked here, none of which is there.
WITHOUT = ('cogging', 'backlash', 'joint_elasticity', 'thermal_drift', 'encoder_eccentricity')


def diagnosed(model, stribeck=0.0, bias=0.0, **settings):
    """Return the diagnosis of friction 20 s + 200 v, of more at low speed, of a slider [N]."""

    def sign(q, v):
        s = dahl_path(q, 4e-5)
        return s * (1.0 + stribeck / 20.0 * np.exp(-np.abs(v) / 0.03))

    log = slider_recording(lambda v: np.full_like(v, bias), seed=1, sign=sign)
    return diagnose([log], model, None, DiagnosisSettings(**settings), WITHOUT)


@pytest.mark.parametrize('stribeck', [0.0, 12.5])
def test_coulomb_and_viscous_friction_both_off_are_both_told_and_stribeck_only_where_it_is(
    stribeck,
):
    """One after the other, a Stribeck term stood for what both lacked."""
    found = diagnosed(slider_model(15.0, 500.0), stribeck)
    sizes = {cause.effect: cause.parameters for cause in found.causes}
    assert set(sizes) == {'coulomb', 'viscous', *(['stribeck'] if stribeck else [])}
    assert all(not cause.rivals for cause in found.causes)
    for name, change in (('coulomb', 5.0), ('viscous', -300.0)):
        size = sizes[name]['change']
        assert size.value == pytest.approx(change, abs=max(3.0 * size.std_error, 0.5))


def test_a_law_that_is_too_large_as_a_whole_is_off_in_all_its_numbers_and_effort_is_not():
    """Without gravity, less effort of bodies with more inertia is the same equation."""
    size = {'coulomb': (20.0, 'N'), 'viscous': (100.0, 'N s/m'), 'stribeck': (10.0, 'N')}
    law = {name: Parameter(1.3 * value, unit) for name, (value, unit) in size.items()}
    law |= {'stribeck_velocity': Parameter(0.05, 'm/s'), 'bias': Parameter(0.0, 'N')}
    model = slider_model()
    joint = replace(
        model.joints['slider'], friction=FrictionParameters('stribeck_gaussian', 0.0, law)
    )
    t = np.arange(0.0, 40.0, SLIDER_STEP)
    q, v, a = sines(t, ((1.0, 0.2), (0.2, 0.5, 1.0)))
    tau = SLIDER_MASS * a + dahl_path(q, 4e-5) * (20.0 + 10.0 * np.exp(-((v / 0.05) ** 2)))
    tau += 100.0 * v + np.random.default_rng(8).normal(0.0, 1.0, len(t))
    log = recording(('slider',), t, q, tau)
    found = diagnose([log], replace(model, joints={'slider': joint}))
    told = {cause.effect: cause.parameters for cause in found.causes}
    assert set(told) == set(size)
    for name, change in (('coulomb', -6.0), ('viscous', -30.0)):
        own = told[name]['change']
        assert abs(own.value - change) < 3.0 * own.std_error
    own = told['stribeck']['stribeck']
    assert abs(own.value - 10.0) < 3.0 * own.std_error


def test_a_friction_that_is_not_trusted_is_refitted_and_no_cause():
    model = slider_model(15.0, 500.0)
    found = diagnosed(model, trust={'friction': np.inf})
    assert found.verdict == 'nothing_above_floor'
    assert found.refit['slider coulomb'] == pytest.approx(5.0, abs=0.5)
    assert found.refit['slider viscous'] == pytest.approx(-300.0, abs=5.0)
    (cause,) = diagnosed(model, 12.5, trust={'friction': np.inf}).causes
    assert cause.effect == 'stribeck'


@pytest.mark.parametrize('guess', [in_full(0.3), 3.0, in_full(None)])
def test_a_coupling_is_of_the_whole_torque_however_wrong_the_friction_is(guess):
    """The elbow's effort is mostly friction: one made of the guess is wrong by as much."""
    t = 4e-3 * np.arange(10000)
    q, v, a = arm_motion(t)
    tau = rigid_effort(arm_model(), q, v, a) + np.array([0.5, 1.5]) * smooth_sign(q, v) + 0.2 * v
    tau[:, 0] += 0.1 * tau[:, 1]
    tau += 0.02 * np.random.default_rng(6).standard_normal(tau.shape)
    model = arm_model((0.5, 0.2), (1.5 * (guess or 1.0), 0.2 * (guess or 1.0)))
    if guess is None:
        joints = {name: replace(joint, friction=None) for name, joint in model.joints.items()}
        model = replace(model, joints=joints)
    settings = DiagnosisSettings(trust={} if guess is None else {'friction': np.inf})
    found = diagnose([recording(('shoulder', 'elbow'), t, q, tau)], model, None, settings, WITHOUT)
    (cause,) = found.causes
    assert (cause.effect, cause.joint) == ('joint_coupling', 'shoulder')
    size = cause.parameters['coupling']
    assert abs(size.value - 0.1) < 3.0 * size.std_error
    assert size.std_error < 0.01


def test_a_bias_is_told_where_the_friction_is_guessed():
    found = diagnosed(slider_model(15.0, 500.0), bias=6.0, trust={'friction': np.inf})
    (cause,) = found.causes
    assert 'effort_bias' in (cause.effect, *cause.rivals)
    assert {cause.effect, *cause.rivals} <= {'effort_bias', 'asymmetric_friction'}
    assert found.refit['slider coulomb'] == pytest.approx(5.0, abs=0.5)


@pytest.mark.parametrize(
    ('trust', 'said'), [({'frction': 0.5}, 'use masses, armature'), ({'masses': -1.0}, 'is -1')]
)
def test_trust_in_what_there_is_not_is_refused(trust, said):
    with pytest.raises(ConfigurationError, match=said):
        diagnosed(slider_model(), trust=trust)


def test_a_friction_of_zero_has_the_tolerance_of_one_that_needs_all_effort():
    log, settings = slider_recording(seed=1), DiagnosisSettings(band=15.0)
    model = slider_model(0.0, 0.0)
    (signals,) = prepare([log], model, model.make_robot(), settings)
    nominal = make_nominal(signals, 0.035)
    bound = dict(zip(nominal.names, nominal.bound, strict=True))
    effort, speed = float(signals.scales.effort[0]), float(signals.scales.speed[0])
    assert bound['slider coulomb'] == pytest.approx(0.035 * effort)
    assert bound['slider viscous'] == pytest.approx(0.035 * effort / speed)
