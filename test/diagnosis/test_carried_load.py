# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A payload that the URDF lacks, and friction by the load that it makes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import coulomb_viscous, recording, sines

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.next_experiment.conditions import conditions
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.term_fit import fit_terms
from sosml_friction.model.model_folder import EffectTerm
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.known_effort import with_known
from sosml_friction.regression.nominal import make_nominal
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

MASS, LENGTH, INERTIA, ARMATURE = 1.2, 0.15, 0.01, 0.03
COULOMB, VISCOUS, LOAD = 0.25, 0.2, 0.11
PAYLOAD, REACH = 0.4, 0.3


def recorded(payload=0.0, bias=0.0, asymmetry=0.0):
    """Return a pendulum with friction by load; ``asymmetry`` of its slope [Nm s/rad]."""
    t = 4e-3 * np.arange(12000)
    q, v, a = sines(t, ((1.3, 0.7, 0.0), (0.5, 1.9, 1.0), (0.06, 6.3, 2.0)))
    body = INERTIA + MASS * LENGTH**2 + payload * REACH**2
    weight = 9.81 * (MASS * LENGTH + payload * REACH) * np.sin(q)
    load = body * a + weight
    s = np.tanh(v / 4e-3)
    tau = load + ARMATURE * a + (COULOMB + LOAD * np.abs(load)) * s + VISCOUS * v
    tau += bias + asymmetry * np.abs(v)
    rng = np.random.default_rng(1)
    q = q + 2e-5 * rng.standard_normal(len(t))
    return recording(('joint',), t, q, tau + 0.02 * rng.standard_normal(len(t)))


@pytest.fixture(scope='module')
def log():
    return recorded(PAYLOAD)


@pytest.fixture(scope='module')
def model():
    model = pendulum_model(MASS, LENGTH, INERTIA, ARMATURE, 'joint')
    law = coulomb_viscous(COULOMB, VISCOUS)
    return replace(model, joints={'joint': replace(model.joints['joint'], friction=law)})


def is_right(p, true, most=0.05):
    assert abs(p.value - true) < max(3.0 * p.std_error, 0.01 * true)
    assert p.std_error < most * true


def test_both_are_named_with_their_sizes(log, model):
    """A wrong torque constant explains more than either alone, and was named with three more."""
    found = diagnose([log], model)
    causes = {cause.effect: cause for cause in found.causes}
    assert 'load_dependent_friction' in causes
    assert set(causes) - {'load_dependent_friction'} <= {'payload', 'gravity', 'inertia'}
    is_right(causes['load_dependent_friction'].parameters['load_coefficient'], LOAD)


def test_a_fit_of_these_terms_has_the_same_load(log, model):
    terms = ('coulomb', 'viscous', 'payload', 'load_dependent_friction')
    found = fit_terms([log], model, terms, body_tolerance=0.035)
    by_name = {term.term: term.parameters for term in found.terms}
    is_right(by_name['load_dependent_friction']['load_coefficient'], LOAD)


def test_so_has_a_fit_that_refits_the_bodies(log, model):
    (load,) = BodyComparison.of([log], model).refit.loads
    is_right(load.parameters['load_coefficient'], LOAD)


@pytest.fixture(scope='module')
def known_load(model):
    """Return the model with its friction by load, and without a payload."""
    parameters = {'load_coefficient': Parameter(LOAD, '1')}
    term = EffectTerm('load_dependent_friction', 'joint', parameters)
    return replace(model, effects=(term,))


def test_a_body_takes_with_it_what_its_weight_costs_in_friction_that_the_model_has(known_load):
    """
    (1 + k sign(load) s) of what the gear passes on, and the rotor, which is before it.

    But where the load is within the step of the slope, half a percent of its root mean square.
    """
    prepared = prepare([recorded()], known_load, known_load.make_robot(), DiagnosisSettings())
    (signals,) = with_known(prepared, known_load)
    load, s = signals.motion.load, signals.sign
    far = np.abs(load) > 0.006 * np.sqrt(np.mean(load**2))
    grows = np.where(far, 1.0 + LOAD * np.sign(load) * s, np.nan)
    for term in (TERMS['gravity'](), TERMS['inertia']()):
        (plain,) = prepared
        wanted = term.columns(plain, 0, {})
        rotor = wanted - term.carried(plain, 0, {})
        expected = (wanted - rotor) * grows[..., None] + rotor
        seen = np.isfinite(expected)
        assert seen.mean() > 0.97
        np.testing.assert_allclose(
            term.columns(signals, 0, {})[seen], expected[seen], rtol=1e-6, atol=1e-9
        )


def test_deviations_of_the_nominal_bodies_take_it_with_them_too(known_load):
    prepared = prepare([recorded()], known_load, known_load.make_robot(), DiagnosisSettings())
    (signals,) = with_known(prepared, known_load)
    nominal = make_nominal(signals, 0.035)
    plain, found = (nominal.columns(s) for s in (*prepared, signals))
    for index, k in zip(nominal.rigid, nominal.rigid_columns, strict=True):
        grows = 1.0 + signals.by_load if index < 10 else 1.0
        np.testing.assert_allclose(found[:, :, k], plain[:, :, k] * grows)
    assert np.abs(found - plain).max() > 0.1


def test_a_hold_that_is_proposed_has_no_friction_whatever_the_model_has(known_load):
    settings = DiagnosisSettings()
    signals = prepare([recorded()], known_load, known_load.make_robot(), settings)
    (hold,) = conditions(tuple(with_known(signals, known_load)))['free_hanging_hold'].stretches
    np.testing.assert_array_equal(hold.signals.torque, np.zeros_like(hold.signals.q))
    gear = TERMS['joint_elasticity']().columns(hold.signals, 0, {'stiffness': 100.0})
    assert gear.shape == (*hold.signals.q.shape, 1)


@pytest.mark.parametrize(('bias', 'is_possible'), [(np.nan, True), (0.0, False)])
def test_beside_a_bias_that_nobody_states_a_constant_by_direction_is_any_number(
    known_load, bias, is_possible
):
    """Their sum alone is known: it may be of any size, and its opposite in the bias."""
    settings = DiagnosisSettings()
    (signals,) = prepare([recorded()], known_load, known_load.make_robot(), settings)
    signals = replace(signals, scales=replace(signals.scales, bias=np.array([bias])))
    amplitude, error = np.array([0.1 * VISCOUS, 4.0 * COULOMB]), np.array([0.01, 5.0])
    fit = Fitted(signals, 0, {'by_speed': 1.0}, amplitude, error)
    assert (TERMS['asymmetric_friction']().implausible(fit) == '') == is_possible


def test_friction_that_a_model_does_not_state_is_told(known_load):
    joint = known_load.joints['joint']
    model = replace(known_load, joints={'joint': replace(joint, friction=None)})
    found = diagnose([recorded()], model)
    assert found.verdict == 'nothing_above_floor'
    end = found.sentence.rpartition('Not stated in the model, and fitted: joint: coulomb ')[2]
    assert float(end.split()[0]) == pytest.approx(COULOMB, rel=0.01)
