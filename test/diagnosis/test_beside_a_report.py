# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Causes beside a report of the torque that is wrong, or that has another joint's in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_runs import in_full
from known_robots import arm_model, arm_motion, recording, rigid_effort

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import Diagnosis, diagnose
from sosml_friction.identification.term_fit import fit_terms
from sosml_friction.model.model_folder import EffectTerm
from sosml_friction.model.parameter import Z_95, Parameter

STEP, NOISE = 4e-3, 0.02
SPRING, ZERO = 1.5, 0.9


def log(
    seed: int, scale: float = 1.0, spring: float = 0.0, inertia: float = 0.0, coupling: float = 0.0
) -> JointLog:
    """
    Return a minute of the arm, whose elbow has a spring [Nm/rad] and a rotor [kg m2] more.

    The effort of the elbow is reported ``scale`` times as large; that of the shoulder has
    ``coupling`` of the elbow's torque in it.
    """
    t = STEP * np.arange(15000)
    phases = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (2, 3))
    lines = [[(0.5, 0.9, a), (0.1, 4.0, b), (0.2, 2.1, c)] for a, b, c in phases.tolist()]
    q, v, a = arm_motion(t, lines)
    model = arm_model()
    tau = rigid_effort(model, q, v, a) + 0.5 * np.tanh(v / 2e-3) + 0.2 * v
    tau[:, 1] += spring * (q[:, 1] - ZERO) + inertia * a[:, 1]
    tau[:, 0] += coupling * tau[:, 1]
    tau[:, 1] *= scale
    tau += np.random.default_rng(seed + 1).normal(0.0, NOISE, tau.shape)
    return recording(tuple(model.joint_names), t, q, tau)


def within(found: Diagnosis, effect: str, name: str, truth: float) -> bool:
    (cause,) = (each for each in found.causes if each.effect == effect)
    p = cause.parameters[name]
    low, high = p.interval or (p.value - Z_95 * p.std_error, p.value + Z_95 * p.std_error)
    return low <= truth <= high


@pytest.mark.parametrize(('seed', 'scale'), [(1, 0.75), in_full(2, 1.3)])
def test_a_spring_beside_a_wrong_torque_constant_has_the_stiffness_of_the_torque(seed, scale):
    """As reported it would be 25 % too soft, or 30 % too stiff."""
    model = arm_model()
    found = diagnose([log(seed, scale=scale, spring=SPRING)], model)
    assert {cause.effect for cause in found.causes} == {'effort_scale', 'spring'}
    assert within(found, 'effort_scale', 'error', scale - 1.0)
    assert within(found, 'spring', 'stiffness', SPRING)


def test_a_fit_of_both_says_the_same():
    model = arm_model()
    terms = ['coulomb', 'viscous', 'spring@elbow', 'effort_scale@elbow']
    fit = fit_terms([log(1, scale=0.75, spring=SPRING)], model, terms)
    truth = {'coulomb': 0.5, 'viscous': 0.2, 'stiffness': SPRING, 'error': -0.25}
    told = {
        name: p
        for term in fit.terms
        if term.joint == 'elbow'
        for name, p in term.parameters.items()
        if name in truth
    }
    assert set(told) == set(truth)
    for name, p in told.items():
        assert p.interval[0] <= truth[name] <= p.interval[1]


@pytest.mark.parametrize('scale', [in_full(0.75), 1.3])
def test_a_coupling_from_a_joint_whose_report_is_wrong_has_its_torque(scale):
    """Of what is reported it would be a third too large, or a quarter too small."""
    found = diagnose([log(5, scale=scale, coupling=0.15)], arm_model())
    assert {cause.effect for cause in found.causes} == {'joint_coupling', 'effort_scale'}
    assert within(found, 'joint_coupling', 'coupling', 0.15)
    fit = fit_terms(
        [log(5, scale=scale, coupling=0.15)],
        arm_model(),
        ['coulomb', 'viscous', 'joint_coupling@shoulder', 'effort_scale@elbow'],
    )
    told = {(x.joint, name): p for x in fit.terms for name, p in x.parameters.items()}
    for key, truth in (
        (('shoulder', 'coupling'), 0.15),
        (('elbow', 'coulomb'), 0.5),
        (('elbow', 'error'), scale - 1.0),
    ):
        low, high = told[key].interval
        assert low <= truth <= high


def test_a_spring_beside_a_report_that_the_model_states_is_the_torques_too():
    term = EffectTerm('effort_scale', 'elbow', {'error': Parameter(-0.25, '1')})
    model = replace(arm_model(), effects=(term,))
    found = diagnose([log(1, scale=0.75, spring=SPRING)], model)
    assert within(found, 'spring', 'stiffness', SPRING)


@pytest.mark.parametrize('seed', [3, in_full(4)])
def test_a_coupling_passes_on_what_the_model_lacks_of_the_other_torque(seed):
    """A third of the elbow's inertia is missing: c would be a fifth too large, with it or not."""
    found = diagnose([log(seed, inertia=0.06, coupling=0.15)], arm_model())
    assert {cause.key for cause in found.causes} == {
        ('joint_coupling', 'shoulder'),
        ('inertia', 'elbow'),
    }
    assert within(found, 'joint_coupling', 'coupling', 0.15)
    assert within(found, 'inertia', 'change', 0.06)
