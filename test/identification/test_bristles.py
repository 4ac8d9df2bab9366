# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms of friction that follows its level over a displacement, as bristles do."""

from __future__ import annotations

from dataclasses import replace

import pytest
from full_runs import in_full

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.next_experiment.experiment import _planned
from sosml_friction.identification.term_fit import TermFit, fit_terms
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.motion.trajectory_kinds.symmetric_reversals import symmetric_reversals
from validation import bristles
from validation.bristles import COULOMB, KNEE, MODEL, VISCOUS

STRIBECK = 0.4 * COULOMB


def log(seed: int, displacement: float, stribeck: float = STRIBECK) -> JointLog:
    """Return a minute of a pendulum that crosses the knee within the bristles' displacement."""
    form = 'bristles' if displacement else 'at once'
    return bristles.recording(form, displacement, 1.0, stribeck, seed, noise=0.01)


def fitted(of: JointLog) -> TermFit:
    return fit_terms([of], MODEL, ['coulomb', 'viscous', 'stribeck'])


def follows(fit: TermFit) -> float:
    (placed,) = fit.estimate.placed
    return placed.inner.get('follows', 0.0)


@pytest.mark.parametrize('seed', [1, in_full(2)])
def test_s_and_v_s_are_those_of_the_bristles(seed):
    """With friction that is at its level at once, S is a fifth too small."""
    fit = fitted(log(seed, 1e-3))
    told = fit.terms[-1].parameters
    assert told['stribeck'].value == pytest.approx(STRIBECK, rel=0.1)
    for name, truth in (('stribeck', STRIBECK), ('stribeck_velocity', KNEE)):
        low, high = told[name].interval
        assert low <= truth <= high
    # One displacement for all: theirs, C / s_0 to (C + S) / s_0.
    assert 0.9e-3 < follows(fit) < 1.5e-3
    # It is a number of the fit alone.
    assert set(told) == {'stribeck', 'stribeck_velocity', 'exponent'}
    assert 'follows' not in fit.model.joints['joint'].friction.parameters


def test_friction_that_is_at_its_level_at_once_has_none():
    fit = fitted(log(3, 0.0))
    assert follows(fit) == 0.0
    told = fit.terms[-1].parameters['stribeck']
    assert told.value == pytest.approx(STRIBECK, abs=2.0 * told.std_error)


def test_a_diagnosis_has_the_same_numbers():
    """Of a model that has the friction but for its Stribeck term."""
    of = log(1, 1e-3)
    fit = fitted(of)
    found = diagnose([of], MODEL)
    (cause,) = (each for each in found.causes if each.effect == 'stribeck')
    told = fit.terms[-1].parameters['stribeck']
    assert cause.parameters['stribeck'].value == pytest.approx(told.value, abs=told.std_error)
    assert all('follows' in inner for inner, _ in cause.terms)
    assert 'follows' not in cause.parameters


def test_bristles_longer_than_a_sign_are_those_of_presliding():
    """Whichever of the two is found first."""
    of = log(4, 3e-3)
    for order in (['stribeck', 'presliding_hysteresis'], ['presliding_hysteresis', 'stribeck']):
        fit = fit_terms([of], MODEL, ['coulomb', 'viscous', *order])
        told = {name: p for term in fit.terms for name, p in term.parameters.items()}
        low, high = told['stribeck'].interval
        assert low <= STRIBECK <= high
        assert told['displacement'].value == pytest.approx(3e-3, rel=0.15)
        (follows,) = (x.inner['follows'] for x in fit.estimate.placed if 'follows' in x.inner)
        assert follows == pytest.approx(3e-3, rel=0.5)


def with_stribeck(size: float) -> RobotModelFile:
    """Return the model that states the friction, but for the size of its Stribeck term."""
    parameters = {
        'coulomb': Parameter(COULOMB, 'Nm'),
        'viscous': Parameter(VISCOUS, 'Nm s/rad'),
        'stribeck': Parameter(size, 'Nm'),
        'stribeck_velocity': Parameter(KNEE, 'rad/s'),
        'bias': Parameter(0.0, 'Nm'),
    }
    friction = FrictionParameters('stribeck', 0.0, parameters)
    return replace(MODEL, joints={'joint': replace(MODEL.joints['joint'], friction=friction)})


@pytest.mark.parametrize('stated', [1e-4, 0.05])
def test_a_stribeck_term_that_the_model_states_too_small_is_told(stated):
    found = diagnose([log(1, 1e-3)], with_stribeck(stated))
    assert any(cause.effect == 'stribeck' for cause in found.causes)


def test_a_stribeck_term_that_the_model_states_follows_as_well():
    """At once it left an unknown structure; the bristles are those of presliding."""
    large = 0.8 * COULOMB
    assert diagnose([log(1, 3e-4)], with_stribeck(STRIBECK)).verdict == 'nothing_above_floor'
    found = diagnose([log(1, 1e-3, large)], with_stribeck(large))
    assert found.verdict == 'named'
    assert [cause.effect for cause in found.causes] == ['presliding_hysteresis']


def test_a_stribeck_term_that_is_there_at_once_does_not_follow():
    found = diagnose([log(1, 0.0)], with_stribeck(STRIBECK))
    assert found.verdict == 'nothing_above_floor'
    (stated,) = found.laboratory.signals[0].stated
    # Nor where over less than a step of position it makes no difference.
    assert stated.known.inner.get('follows', 0.0) < 1e-5


def test_what_a_trajectory_would_show_has_the_columns_of_the_nominal():
    """Stated terms have one, and how they build up: the columns behind were another's."""
    laboratory = diagnose([log(1, 3e-4)], with_stribeck(STRIBECK)).laboratory
    nominal, (signals,) = laboratory.nominal, laboratory.signals
    plan = symmetric_reversals({'joint': 0.0}, {'joint': 0.0}, (0.1, 0.2))
    columns = nominal.columns(_planned(signals, plan))
    assert columns.shape[2] == len(nominal.names)
    with pytest.raises(ValueError, match='deviations have'):
        nominal.columns(replace(signals, stated=()))
