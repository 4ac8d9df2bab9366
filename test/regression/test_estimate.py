# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number of a term that a free parameter of the model could have as well is the term's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.identification.term_fit import fit_terms
from sosml_friction.model.known_terms import known_terms

STIFFNESS, OFFSET = 150.0, 7.0


@pytest.fixture(scope='module')
def log():
    """Return the slider on a spring, of which 1 N of noise in 7000 samples leaves 0.1 N open."""
    log = slider_recording()
    return replace(log, tau=log.tau + STIFFNESS * log.q + OFFSET)


@pytest.fixture(scope='module')
def model():
    """Return the slider, of whose friction and bias the model knows nothing."""
    known = slider_model()
    joint = replace(known.joints['slider'], friction=None)
    return replace(known, joints={'slider': joint})


def is_told(parameters):
    """Tell whether stiffness and offset are true within three of their own standard errors."""
    off = [parameters['stiffness'].value - STIFFNESS, parameters['offset'].value - OFFSET]
    errors = [parameters[name].std_error for name in ('stiffness', 'offset')]
    return bool((np.abs(off) < 3.0 * np.array(errors)).all()) and errors[1] < 0.05 * OFFSET


def constants(model):
    """Return the constants [N] of a model's law and of its spring."""
    (spring,) = known_terms(model)
    friction = model.joints['slider'].friction
    bias = None if friction is None else friction.parameters.get('bias')
    return 0.0 if bias is None else bias.value, float(spring.amplitude[1])


def test_a_diagnosis_gives_a_spring_all_of_a_constant_that_the_model_does_not_know(log, model):
    found = diagnose([log], model)
    (cause,) = found.causes
    assert cause.effect == 'spring'
    assert is_told(cause.parameters)
    assert found.refit['slider bias'] == 0.0
    offset = cause.parameters['offset'].value
    assert constants(extended_model(model, found, {})) == (0.0, offset)


@pytest.mark.parametrize('terms', [['spring'], ['coulomb', 'viscous', 'bias', 'spring']])
def test_a_fit_gives_a_spring_all_of_a_constant_that_is_free_beside_it(log, model, terms):
    fit = fit_terms([log], model, terms)
    spring = next(term for term in fit.terms if term.term == 'spring')
    assert is_told(spring.parameters)
    assert fit.refit['slider bias'] == 0.0
    assert constants(fit.model) == (0.0, spring.parameters['offset'].value)
