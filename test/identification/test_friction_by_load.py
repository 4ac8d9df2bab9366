# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A law by velocity says so where friction grows with load: C has some of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording, sines

import sosml_friction as sf
from sosml_friction.identification.data_finding import WARNING
from sosml_friction.model.model_folder import EffectTerm
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model

MASS, LENGTH, ARMATURE, COULOMB, VISCOUS = 1.2, 0.3, 0.02, 0.25, 0.15
LINES = ((0.8, 1.1, 0.3), (0.3, 3.7, 1.0), (0.08, 9.1, 2.0), (0.03, 17.0, 0.4))
STEP = 5e-3
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
    return [f for f in fit.analysis.data_checks.findings if f.check == 'load']


def test_a_law_of_a_joint_whose_friction_grows_with_load_says_so():
    fit = sf.fit(log(0.08, 1), sf.Model(MODEL))
    assert fit.parameters['joint']['coulomb'].value - COULOMB > 0.02
    (found,) = told(fit)
    assert (found.joint, found.level) == ('joint', WARNING)
    share = float(found.sentence.split(' ± ')[0])
    assert share == pytest.approx(8.0, abs=1.0)
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
