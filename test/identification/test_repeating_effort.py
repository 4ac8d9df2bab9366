# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that repeats with position, beside a rotor that nobody stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording, sines

from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.friction_fit import REGRESSION, FitSettings
from sosml_friction.identification.log_analysis import analyse_log
from sosml_friction.identification.repeating_effort import repeats_finding
from sosml_friction.model.simple_models import free_model

#: Size [rad], frequency [rad/s] and phase of what the loop of a direct drive is to follow.
LINES = ((0.9, 0.5, 0.3), (0.35, 1.5, 1.0), (0.12, 2.9, 2.0))
BODY, ROTOR, STIFFNESS, PERIODS = 0.002, 0.001, 10.8, 14.0


def drive(cogging):
    """Return 25 s of a drive whose loop gives way to cogging [Nm], and its model."""
    t = 4e-3 * np.arange(6250)
    rng = np.random.default_rng(1)
    goal, rate, change = sines(t, LINES)
    off = cogging / STIFFNESS
    q = goal - off * np.sin(PERIODS * goal)
    slope = 1.0 - off * PERIODS * np.cos(PERIODS * goal)
    v = slope * rate
    a = slope * change + off * PERIODS**2 * np.sin(PERIODS * goal) * rate**2
    tau = (BODY + ROTOR) * a + 0.05 * np.tanh(v / 5e-3) + 0.01 * v
    tau += cogging * np.sin(PERIODS * q) + 0.0025 * rng.standard_normal(len(t))
    log = recording(('j',), t, q + 1e-5 * rng.standard_normal(len(t)), tau)
    model = free_model(BODY, 'j')
    rotor = replace(model.joints['j'].armature, value=np.nan)
    return log, replace(model, joints={'j': replace(model.joints['j'], armature=rotor)})


def compared(cogging):
    """Return what is found of it."""
    log, model = drive(cogging)
    return BodyComparison.of([log], model)


def test_cogging_is_no_inertia_and_no_delay():
    """The loop gives way to it, with an acceleration that repeats as it does: 0.02 kg m2."""
    found = compared(0.08)
    (rotor,) = found.refit.armature.values()
    assert rotor.interval[0] <= ROTOR <= rotor.interval[1] < 6.0 * ROTOR
    assert not found.late
    said = repeats_finding(found.repeats['j']).sentence
    assert 'joint j repeats every 0.45 rad of position, 0.080' in said
    assert '--terms coulomb,viscous,cogging@j' in said


def test_effort_that_does_not_repeat_is_fitted_without():
    found = compared(0.0)
    assert found.repeats == {}
    (rotor,) = found.refit.armature.values()
    assert rotor.value == pytest.approx(ROTOR, rel=0.2)


def test_the_law_is_that_beside_cogging():
    """The weak form, which has no cogging, takes it for C and B."""
    law = analyse_log(*drive(0.08), FitSettings()).fit.joints['j'][REGRESSION].fit
    for name, value in (('coulomb', 0.05), ('viscous', 0.01)):
        low, high = law.parameters[name].interval
        assert low < value < high, name
    low, high = law.parameters['coulomb'].interval
    assert high - low < 0.2 * 0.05
