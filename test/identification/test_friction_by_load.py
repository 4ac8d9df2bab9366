# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that grows with load stands beside the law, or the law says so: C has some of it."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording, sines

import sosml_friction as sf
from sosml_friction.identification.data_finding import WARNING
from sosml_friction.identification.law.law_checks import ODD_EVEN
from sosml_friction.model.model_folder import EffectTerm
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model

MASS, LENGTH, ARMATURE, COULOMB, VISCOUS = 1.2, 0.3, 0.02, 0.25, 0.15
LINES = ((0.8, 1.1, 0.3), (0.3, 3.7, 1.0), (0.08, 9.1, 2.0), (0.03, 17.0, 0.4))
STEP = 5e-3
SEEDS = int(os.environ.get('SOSML_FRICTION_SEEDS', '1'))
MODEL = pendulum_model(MASS, LENGTH, 0.0, ARMATURE, 'joint')


def log(share: float, seed: int):
    """Return a pendulum of which this share of the load is friction, masses 1 % off."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(round(40.0 / STEP))
    q, v, a = sines(t, LINES)
    load = 1.01 * MASS * (LENGTH**2 * a + 9.81 * LENGTH * np.sin(q))
    friction = (COULOMB + share * np.abs(load)) * np.tanh(v / 5e-3) + VISCOUS * v
    tau = load + ARMATURE * a + friction + 0.02 * rng.standard_normal(len(t))
    return recording(('joint',), t, q + 2e-5 * rng.standard_normal(len(t)), tau)


def told(fit):
    known = getattr(fit.analysis, 'bags', {'': fit.analysis})
    return [f for one in known.values() for f in one.data_checks.findings if f.check == 'load']


def test_friction_by_load_that_the_data_show_is_in_the_model_beside_the_law():
    """C was 0.05 Nm too large, B as far off as load goes with speed, and a remark on direction."""
    held = {'coulomb': 0, 'viscous': 0}
    for seed in range(SEEDS):
        fit = sf.fit(log(0.08, 1 + seed), sf.Model(MODEL))
        for name, true in (('coulomb', COULOMB), ('viscous', VISCOUS)):
            p = fit.parameters['joint'][name]
            held[name] += p.interval[0] < true < p.interval[1]
            assert abs(p.value - true) < 4.0 * p.std_error
            assert p.std_error < 0.05 * true
        (term,) = fit.analysis.model.effects
        assert (term.effect, term.joint) == ('load_dependent_friction', 'joint')
        assert term.parameters['load_coefficient'].value == pytest.approx(0.08, abs=0.01)
        assert not told(fit)
        for one in fit.analysis.fit.joints['joint'].values():
            assert not [c for c in one.fit.checks if c.name == ODD_EVEN and not c.passed]
        assert 'of its load is friction besides' in fit.summary()
    print(f'C and B within their intervals, of {SEEDS}: {held}')
    assert min(held.values()) >= 0.85 * SEEDS - 1


def test_a_law_that_has_no_friction_by_load_beside_it_says_so():
    """Of two recordings, whose laws are put together from rows that have none."""
    fit = sf.fit({'one': log(0.08, 1), 'two': log(0.08, 2)}, sf.Model(MODEL))
    assert fit.parameters['joint']['coulomb'].value - COULOMB > 0.02
    found, again = told(fit)
    assert (found.joint, found.level) == ('joint', WARNING)
    assert found.sentence == again.sentence
    share = float(found.sentence.split(' ± ')[0])
    assert share == pytest.approx(8.0, abs=1.0)
    assert 'viscous friction' in found.sentence
    # What a user is told of a recording is in the words of the fit, too.
    assert found.sentence in fit.summary()
    terms = found.sentence.split('--terms ')[1].split()[0].split(',')
    low, high = sf.fit(log(0.08, 1), sf.Model(MODEL), terms=terms).conf_int()['coulomb@joint'][
        'coulomb'
    ]
    assert low < COULOMB < high


def test_nothing_is_said_where_friction_does_not_or_the_model_has_it():
    assert not told(sf.fit(log(0.0, 2), sf.Model(MODEL)))
    k = {'load_coefficient': Parameter(0.08, '1')}
    term = EffectTerm('load_dependent_friction', 'joint', k)
    stated = sf.Model(replace(MODEL, effects=(term,)))
    assert not told(sf.fit(log(0.08, 3), stated))
