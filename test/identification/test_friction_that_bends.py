# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A law says so where friction bends with speed, and the terms that it names fit that."""

import numpy as np
from known_robots import recording, sines

import sosml_friction as sf
from sosml_friction.identification.law.law_checks import BEND
from sosml_friction.model.simple_models import pendulum_model

MASS, LENGTH, ARMATURE, COULOMB, LEVEL, POWER = 1.2, 0.3, 0.02, 0.25, 0.5, 0.5
LINES = ((0.8, 1.1, 0.3), (0.3, 3.7, 1.0), (0.08, 9.1, 2.0), (0.03, 17.0, 0.4))
STEP = 5e-3
MODEL = sf.Model(pendulum_model(MASS, LENGTH, 0.0, ARMATURE, 'joint'))


def log(power, seed):
    """Return a pendulum with friction 0.5 |v|^power beside Coulomb's."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(round(60.0 / STEP))
    q, v, a = sines(t, LINES)
    friction = COULOMB * np.tanh(v / 5e-3) + LEVEL * np.sign(v) * np.abs(v) ** power
    tau = (MASS * LENGTH**2 + ARMATURE) * a + 9.81 * MASS * LENGTH * np.sin(q) + friction
    tau = tau + 0.02 * rng.standard_normal(len(t))
    return recording(('joint',), t, q + 2e-5 * rng.standard_normal(len(t)), tau)


def told(fit):
    (fits,) = fit.analysis.fit.joints.values()
    return [c for one in fits.values() for c in one.fit.checks if c.name == BEND]


def test_friction_that_bends_is_told_and_the_terms_named_there_fit_it():
    bent = log(POWER, 1)
    fit = sf.fit(bent, MODEL)
    # Of all ways to fit a law, that of the model speaks.
    (check,) = (c for c in told(fit) if c.sentence in fit.summary())
    terms = check.sentence.split('--terms ')[1].split()[0].split(',')
    terms = [name for name in terms if name != 'stribeck']
    found = sf.fit(bent, MODEL, terms=terms).conf_int()
    for term, name, truth in (
        ('coulomb', 'coulomb', COULOMB),
        ('nonlinear_viscous', 'nonlinear_viscous', LEVEL),
        ('nonlinear_viscous', 'power', POWER),
    ):
        low, high = found[f'{term}@joint'][name]
        assert low <= truth <= high, name


def test_viscous_friction_does_not_bend():
    assert not told(sf.fit(log(1.0, 2), MODEL))
