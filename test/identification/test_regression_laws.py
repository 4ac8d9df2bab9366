# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The law beside friction by load, of a pendulum whose friction is known."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import recording, rigid_effort, sines

from sosml_friction.identification.friction_fit import REGRESSION, FitSettings
from sosml_friction.identification.log_analysis import analyse_log
from sosml_friction.model.simple_models import pendulum_model

COULOMB, VISCOUS, LOAD = 0.35, 0.2, 0.1


def fitted(stribeck, stribeck_velocity, seed):
    """Return the law of 30 s of sines of four drawn sizes and phases, noise of effort 30 mNm."""
    rng = np.random.default_rng(seed)
    model = pendulum_model(2.0, 0.3).with_armature({'*': 0.0})
    t = 2e-3 * np.arange(15_000)
    phases, sizes = rng.uniform(0.0, 2.0 * np.pi, 4), rng.uniform(0.7, 1.3, 4)
    lines = zip(
        np.array([0.8, 0.3, 0.12, 0.05]) * sizes, (0.5, 1.4, 2.6, 4.1), phases, strict=True
    )
    q, v, a = sines(t, list(lines))
    load = rigid_effort(model, q[:, None], v[:, None], a[:, None])[:, 0]
    level = COULOMB + LOAD * np.abs(load) + stribeck * np.exp(-np.abs(v) / stribeck_velocity)
    tau = load + np.tanh(v / 2e-3) * level + VISCOUS * v + 0.03 * rng.standard_normal(len(t))
    log = recording(('joint',), t, q + 1e-5 * rng.standard_normal(len(t)), tau)
    found = analyse_log(log, model, FitSettings(), effort_hold='start')
    return found.fit.joints['joint'][REGRESSION].fit, found.model


@pytest.mark.parametrize(('stribeck', 'stribeck_velocity'), [(0.5, 0.1), (0.2, 0.05)])
def test_a_law_with_a_knee_stands_beside_friction_by_load(stribeck, stribeck_velocity):
    """The weak form, which has no load, makes C 0.80: all that a gear under load has."""
    law, model = fitted(stribeck, stribeck_velocity, 0)
    truth = {
        'coulomb': COULOMB,
        'viscous': VISCOUS,
        'stribeck': stribeck,
        'stribeck_velocity': stribeck_velocity,
    }
    for name, value in truth.items():
        low, high = law.parameters[name].interval
        assert low < value < high, name
    low, high = law.parameters['coulomb'].interval
    assert high - low < 0.05 * COULOMB
    (term,) = model.effects
    assert term.parameters['load_coefficient'].value == pytest.approx(LOAD, rel=0.05)


def test_a_knee_that_is_not_shown_is_in_the_errors_of_the_law():
    """Of this motion S = 0.2 may be nothing, and C and B without it are 2.5 errors off."""
    law, _ = fitted(0.2, 0.05, 2)
    assert law.law == 'coulomb_viscous'
    for name, value in (('coulomb', COULOMB), ('viscous', VISCOUS)):
        low, high = law.parameters[name].interval
        assert low < value < high, name
