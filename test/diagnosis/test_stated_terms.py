# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms that a model states are nominal parameters: they have a tolerance, and may be wrong."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from known_robots import coulomb_viscous, recording, sines

from sosml_friction.diagnosis.decision.forward_gain import ForwardGain
from sosml_friction.diagnosis.decision.scorer import Scorer
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.diagnosis.library import make_library
from sosml_friction.diagnosis.residual.refitted_parameters import refitted_parameters
from sosml_friction.diagnosis.trust import trusting
from sosml_friction.model.known_terms import stated_terms
from sosml_friction.model.model_folder import EffectTerm, FrictionParameters
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.plain_document import to_plain
from sosml_friction.regression.known_effort import with_known
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression

SCHEMA = Path(__file__).parents[2] / 'docs/schema/diagnosis.schema.json'
MASS, LENGTH, INERTIA, ARMATURE = 1.2, 0.15, 0.01, 0.03
COULOMB, VISCOUS = 0.25, 0.2
STIFFNESS, REST, LOAD = 1.0, 0.3, 0.1
STRIBECK, STRIBECK_VELOCITY = 0.2, 0.15
SETTINGS = DiagnosisSettings(band=12.0)
#: Causes that these tests have nothing to do with: the search takes a tenth of its time.
WITHOUT = (
    'backlash', 'joint_elasticity', 'encoder_eccentricity', 'thermal_drift',
    'presliding_hysteresis', 'effort_saturation', 'payload',
)  # fmt: skip


def recorded(more=lambda q, v, load, s: 0.0, scale=1.0, seed=11):
    """Return a pendulum with an effort of its own beside C and B, in closed form."""
    t = 5e-3 * np.arange(6000)
    q, v, a = sines(t, ((1.3, 0.9, 0.0), (0.5, 2.3, 1.0), (0.06, 7.3, 2.0)))
    load = (INERTIA + MASS * LENGTH**2) * a + 9.81 * MASS * LENGTH * np.sin(q)
    s = np.tanh(v / 4e-3)
    tau = load + ARMATURE * a + COULOMB * s + VISCOUS * v + more(q, v, load, s)
    rng = np.random.default_rng(seed)
    q = q + 2e-5 * rng.standard_normal(len(t))
    return recording(('joint',), t, q, scale * tau + 0.02 * rng.standard_normal(len(t)))


def with_spring_and_load(q, v, load, s):
    return STIFFNESS * (q - REST) + LOAD * np.abs(load) * s


def entry(name, **values):
    return EffectTerm(name, 'joint', {k: Parameter(x, '1') for k, x in values.items()})


def stating(*entries, law=None):
    model = pendulum_model(MASS, LENGTH, INERTIA, ARMATURE, 'joint')
    friction = law or coulomb_viscous(COULOMB, VISCOUS)
    joints = {'joint': replace(model.joints['joint'], friction=friction)}
    return replace(model, joints=joints, effects=entries)


def spring(factor=1.0):
    stiffness = factor * STIFFNESS
    return entry('spring', stiffness=stiffness, offset=-stiffness * REST)


def by_load(factor=1.0):
    return entry('load_dependent_friction', load_coefficient=factor * LOAD)


def law_with_stribeck(stribeck):
    own = coulomb_viscous(COULOMB, VISCOUS).parameters
    more = {'stribeck': Parameter(stribeck, 'Nm')}
    more['stribeck_velocity'] = Parameter(STRIBECK_VELOCITY, 'rad/s')
    return FrictionParameters('stribeck', 0.0, {**own, **more})


def found_in(log, model):
    return diagnose([log], model, settings=SETTINGS, without=WITHOUT)


def is_within(p, true):
    # Of one recording: three standard errors.
    assert abs(p.value - true) < 3.0 * p.std_error
    assert p.std_error < 0.1 * abs(true)


@pytest.mark.parametrize('factor', [1.003, 0.98])
def test_within_the_tolerance_an_error_is_told_silently(factor):
    found = found_in(recorded(with_spring_and_load), stating(spring(factor), by_load(factor)))
    assert found.verdict == 'nothing_above_floor'
    assert found.refit['joint spring stiffness'] == pytest.approx(1.0 - factor, abs=0.01)


def test_terms_that_are_stated_threefold_are_named_with_their_sizes_and_written_as_they_are():
    """As much too large: the change alone would be an impossible spring and friction."""
    log, model = recorded(with_spring_and_load), stating(spring(3.0), by_load(3.0))
    found = found_in(log, model)
    assert found.verdict == 'named'
    causes = {cause.effect: cause for cause in found.causes}
    assert set(causes) == {'spring', 'load_dependent_friction'}
    sizes = causes['spring'].parameters
    is_within(sizes['stiffness'], STIFFNESS)
    is_within(sizes['offset'], -STIFFNESS * REST)
    is_within(causes['load_dependent_friction'].parameters['load_coefficient'], LOAD)
    assert causes['spring'].stated == pytest.approx({'stiffness': 3.0, 'offset': -0.9})
    document = to_plain(causes['spring'].to_dict())
    assert document['stated'] == causes['spring'].stated
    schema = json.loads(SCHEMA.read_text())
    jsonschema.validate(document, {'$defs': schema['$defs'], '$ref': '#/$defs/cause'})
    assert 'spring as stated is off (stiffness ' in found.sentence
    assert 'Nm/rad and not 3, ' in found.sentence
    extended = extended_model(model, found, {})
    assert [term.effect for term in extended.effects] == ['spring', 'load_dependent_friction']
    written = extended.effects[0].parameters['stiffness']
    assert written.value == pytest.approx(sizes['stiffness'].value, abs=0.01)
    assert written.std_error == sizes['stiffness'].std_error
    changed = {p.name: p for p in refitted_parameters(found)}
    assert changed['joint spring stiffness'].old == pytest.approx(3.0)


def test_beside_a_spring_that_is_slightly_off_what_is_planted_is_named_alone():
    log = recorded(lambda q, v, load, s: STIFFNESS * (q - REST) + 0.1 * np.cos(12.0 * q))
    found = found_in(log, stating(spring(1.02)))
    (cause,) = found.causes
    assert (cause.effect, cause.rivals) == ('cogging', ())
    is_within(cause.parameters['cosine'], 0.1)


def test_a_spring_that_is_not_there_is_no_impossible_one():
    found = found_in(recorded(), stating(spring()))
    (cause,) = found.causes
    assert cause.effect == 'spring'
    assert abs(cause.parameters['stiffness'].value) < 0.01


def test_a_stribeck_term_of_the_law_that_is_off_is_named_as_stated_and_stays_in_the_law():
    def more(q, v, load, s):
        return STRIBECK * s * np.exp(-np.abs(v) / STRIBECK_VELOCITY)

    model = stating(law=law_with_stribeck(3.0 * STRIBECK))
    found = found_in(recorded(more), model)
    (cause,) = found.causes
    assert cause.effect == 'stribeck'
    assert cause.parameters['stribeck_velocity'].value == STRIBECK_VELOCITY
    is_within(cause.parameters['stribeck'], STRIBECK)
    extended = extended_model(model, found, {})
    law = extended.joints['joint'].friction
    assert law.parameters['stribeck'].value == pytest.approx(STRIBECK, rel=0.1)
    assert extended.effects == ()


WAVE = entry('cogging', cosine=0.1, sine=0.0, frequency=12.0)
NOTHING = entry('quadratic_load_friction', quadratic_load_coefficient=0.0)


@pytest.fixture(scope='module')
def laboratory():
    model = stating(spring(), WAVE, NOTHING, law=law_with_stribeck(STRIBECK))
    signals = prepare([recorded()], model, model.make_robot(), SETTINGS)
    without = tuple(name for name in make_library() if name not in ('spring', 'stribeck'))
    return WhitenedRegression.make(with_known(signals, model), make_library(without), SETTINGS)


def test_each_size_is_off_in_proportion_to_itself_or_to_all_of_the_terms_effort(laboratory):
    nominal, tolerance = laboratory.nominal, SETTINGS.tolerance
    bound = dict(zip(nominal.names, nominal.bound / tolerance, strict=True))
    (signals,) = laboratory.signals
    assert bound['joint stribeck'] == pytest.approx(STRIBECK)
    # A pendulum that swings by 1.9 rad to each side of where gravity has it.
    stretched = np.abs(signals.q - REST).max()
    assert bound['joint spring stiffness'] == pytest.approx(stretched / np.abs(signals.q).max())
    assert bound['joint spring offset'] == pytest.approx(stretched)
    # The angle of a wave is as uncertain as its size.
    assert bound['joint cogging sine'] == pytest.approx(0.1, rel=1e-3)
    most = np.square(signals.motion.load).max()
    wanted = signals.scales.effort[0] / most
    assert bound['joint quadratic_load_friction quadratic_load_coefficient'] == pytest.approx(
        wanted, rel=1e-3
    )


def test_a_group_of_trust_is_that_of_the_term(laboratory):
    settings = replace(SETTINGS, trust={'friction': 0.5, 'terms': np.inf})
    nominal = trusting(replace(laboratory, settings=settings)).nominal
    bound = dict(zip(nominal.names, nominal.bound, strict=True))
    assert bound['joint stribeck'] == pytest.approx(0.5 * STRIBECK)
    assert bound['joint coulomb'] == pytest.approx(0.5 * COULOMB)
    assert np.isinf(bound['joint spring stiffness'])
    assert np.isinf(bound['joint cogging cosine'])


def test_a_stated_term_is_a_candidate_as_it_is_stated_and_in_any_other_form(laboratory):
    keys = [candidate.key for candidate in laboratory.candidates]
    # A spring has no other form, and nobody looks for friction by the square of load.
    assert keys == [
        ('stribeck', 0),
        ('joint stribeck', 0),
        ('joint spring stiffness', 0),
        ('joint quadratic_load_friction quadratic_load_coefficient', 0),
    ]


@pytest.mark.parametrize(
    ('change', 'is_possible'), [(-0.6, True), (-1.02, True), (-1.2, False), (0.5, True)]
)
def test_the_physical_range_is_that_of_the_whole(laboratory, change, is_possible):
    """A spring may be nothing, and less than that within its tolerance."""
    scorer, error = Scorer(laboratory), np.array([1e-3, 1e-3])
    stated = next(c.effect for c in laboratory.candidates if c.key[0].startswith('joint spring'))
    found = np.array([change, 0.0])
    assert (scorer.objection(stated, 0, {}, found, error) == '') == is_possible


def test_the_simulation_has_stated_terms_with_what_they_are_off_by(laboratory):
    """As a model that states them so."""
    model = stating(spring(), WAVE, NOTHING, law=law_with_stribeck(STRIBECK))
    x = np.zeros(len(laboratory.nominal.names))
    names = laboratory.nominal.names
    x[names.index('joint spring stiffness')] = 0.4
    x[names.index('joint stribeck')] = 0.1
    off = ForwardGain(laboratory, model).squares((), x, np.tile(x, (SETTINGS.folds, 1)))
    other = entry('spring', stiffness=1.4 * STIFFNESS, offset=-STIFFNESS * REST)
    truth = stating(other, WAVE, NOTHING, law=law_with_stribeck(STRIBECK + 0.1))
    none = np.zeros_like(x)
    wanted = ForwardGain(laboratory, truth).squares((), none, np.tile(none, (SETTINGS.folds, 1)))
    np.testing.assert_allclose(off, wanted, rtol=1e-9)


def test_terms_of_one_kind_have_names_of_their_own():
    again = entry('cogging', cosine=0.1, sine=0.0, frequency=5.0, cosine_2=0.2, sine_2=0.0,
                  frequency_2=10.0)  # fmt: skip
    names = [known.names for known in stated_terms(stating(WAVE, again))]
    assert names == [
        ('joint cogging cosine', 'joint cogging sine'),
        ('joint cogging 2 cosine', 'joint cogging 2 sine'),
        ('joint cogging 2 cosine_2', 'joint cogging 2 sine_2'),
    ]
