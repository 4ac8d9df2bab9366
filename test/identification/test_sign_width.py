# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that changes its sign smoothly: its width is found, and is no cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording, rigid_effort, sines, slider_model

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.identification.term_fit import fit_terms
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import AT_BOUND
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.smooth_sign import softened

STEP = 4e-3
#: v0 of the sign [m/s], and sines of slow motion in which it is seen: size [m], frequency [rad/s].
WIDTH, SLOW = 2e-3, ((0.06, 0.25), (0.02, 0.6))
COULOMB, VISCOUS = 20.3, 196.0


@pytest.fixture(scope='module')
def log() -> JointLog:
    """Return a minute of the axis, its friction C tanh(v / v0) + B v, an encoder and noise."""
    t = STEP * np.arange(15000)
    q, v, a = sines(t, SLOW)[:, :, None]
    rng = np.random.default_rng(20261123)
    tau = rigid_effort(slider_model(), q, v, a)
    tau += COULOMB * np.tanh(v / WIDTH) + VISCOUS * v + rng.normal(0.0, 0.3, v.shape)
    q = 1e-6 * np.round(q / 1e-6)
    return JointLog(('slider',), np.rint(t * 1e9).astype(np.int64), q, v, tau)


def with_width(width: float) -> RobotModelFile:
    joint = slider_model().joints['slider']
    friction = replace(joint.friction, smoothing_velocity=width)
    return replace(slider_model(), joints={'slider': replace(joint, friction=friction)})


def test_a_width_beside_a_knee_is_found():
    """A slow pendulum, Stribeck friction beside a sign of 5 mrad/s, an encoder of 19 bits."""
    t = 4e-3 * np.arange(10000)
    q, v, a = sines(t, ((0.8, 0.25, 0.0), (0.1, 1.1, 0.5), (0.3, 0.7, 1.0)))
    rng = np.random.default_rng(30)
    model = pendulum_model(1.2, 0.3, 0.0, 0.02, 'joint')
    friction = np.tanh(v / 5e-3) * (0.25 + 0.25 * np.exp(-np.abs(v) / 0.05)) + 0.15 * v
    tau = rigid_effort(model, *(x[:, None] for x in (q, v, a)))[:, 0] + friction
    tau += 0.02 * rng.standard_normal(len(t))
    count = 2.0 * np.pi / 2**19
    q = count * np.rint(q / count + 0.5 * rng.standard_normal(len(t)))
    log = recording(('joint',), t, q, tau)
    fit = fit_terms([log], model, ['coulomb', 'viscous', 'stribeck'])
    assert fit.model.joints['joint'].sign_width == pytest.approx(5e-3, rel=0.3)
    told = fit.terms[-1].parameters['stribeck']
    assert told.value == pytest.approx(0.25, abs=2.0 * told.std_error)
    assert told.std_error < 0.02


def test_terms_are_right_where_friction_changes_its_sign_smoothly(log):
    """A Stribeck term of the size of C, and negative, would make up for the width."""
    fit = fit_terms([log], slider_model(), ['coulomb', 'viscous', 'stribeck'])
    truth = {'coulomb': COULOMB, 'viscous': VISCOUS, 'stribeck': 0.0}
    for term in fit.terms:
        told = term.parameters[term.term]
        assert abs(told.value - truth[term.term]) < 3.0 * told.std_error
    assert fit.model.joints['slider'].sign_width == pytest.approx(WIDTH, rel=0.15)


def test_a_sign_that_is_as_smooth_as_the_model_says_is_no_cause(log):
    assert diagnose([log], with_width(WIDTH)).verdict == 'nothing_above_floor'


def test_friction_that_would_be_negative_is_zero_and_says_so(log):
    falling = replace(log, tau=log.tau - (2.0 * VISCOUS) * log.v)
    fit = fit_terms([falling], slider_model(), ['coulomb', 'viscous'])
    viscous = next(term for term in fit.terms if term.term == 'viscous').parameters['viscous']
    assert viscous.value == 0.0
    assert viscous.flags == (AT_BOUND,)
    assert viscous.interval[0] == 0.0 < viscous.interval[1]


def test_a_state_of_friction_is_softened_by_velocity_alone():
    v = np.array([-0.1, 0.0, 0.001, 0.1])
    z = np.sign(v)
    assert np.allclose(softened(z, v, 0.002), np.tanh(v / 0.002))
    assert softened(z, v, 0.0) is z
