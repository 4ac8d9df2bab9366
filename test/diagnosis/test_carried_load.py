# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A payload that the URDF lacks, and friction by the load that it makes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import coulomb_viscous, recording, sines

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.term_fit import fit_terms
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.regression.settings import DiagnosisSettings

MASS, LENGTH, INERTIA, ARMATURE = 1.2, 0.15, 0.01, 0.03
COULOMB, VISCOUS, LOAD = 0.25, 0.2, 0.11
PAYLOAD, REACH = 0.4, 0.3


@pytest.fixture(scope='module')
def log():
    t = 4e-3 * np.arange(12000)
    q, v, a = sines(t, ((1.3, 0.7, 0.0), (0.5, 1.9, 1.0), (0.06, 6.3, 2.0)))
    body = INERTIA + MASS * LENGTH**2 + PAYLOAD * REACH**2
    weight = 9.81 * (MASS * LENGTH + PAYLOAD * REACH) * np.sin(q)
    load = body * a + weight
    s = np.tanh(v / 4e-3)
    tau = load + ARMATURE * a + (COULOMB + LOAD * np.abs(load)) * s + VISCOUS * v
    rng = np.random.default_rng(1)
    q = q + 2e-5 * rng.standard_normal(len(t))
    return recording(('joint',), t, q, tau + 0.02 * rng.standard_normal(len(t)))


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
    found = diagnose([log], model, settings=DiagnosisSettings(nulls=2))
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
