# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Several recordings of one joint whose friction bends with speed, fitted together."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import only_full
from known_robots import recording, smooth_sign

import sosml_friction as sf
from sosml_friction.model.simple_models import free_model

COULOMB, VISCOUS, DRAG, INERTIA = 1.2, 0.1, 0.4, 0.35


def ladder(seed, coulomb=COULOMB):
    """Return 40 s of a shaft at nine speeds there and back, with drag P v |v|."""
    rng = np.random.default_rng(seed)
    step, strokes = 2e-3, []
    for speed in np.geomspace(0.05, 2.0, 9) * rng.uniform(0.9, 1.1):
        t = step * np.arange(1100)
        top = speed * np.minimum(np.minimum(8.0 * t, 8.0 * (t[-1] - t)), 1.0)
        strokes += [top, -top]
    v = np.concatenate(strokes)
    t, q = step * np.arange(len(v)), step * np.cumsum(v)
    tau = INERTIA * np.gradient(v, step) + smooth_sign(q, v) * coulomb + VISCOUS * v
    tau += DRAG * v * np.abs(v) + 0.02 * rng.standard_normal(len(t))
    return recording(('joint',), t, q + 1e-5 * rng.standard_normal(len(t)), tau)


def fitted(logs):
    model = sf.Model(free_model(INERTIA))
    return sf.fit(logs, model, effort_hold='start')


@only_full
def test_recordings_of_one_drag_are_of_one_law():
    found = fitted([ladder(3), ladder(4)]).parameters['joint']
    for name, truth in (('coulomb', COULOMB), ('viscous', VISCOUS), ('nonlinear_viscous', DRAG)):
        low, high = found[name].interval
        assert low < truth < high, name
    assert found['power'].value == pytest.approx(2.0, abs=0.1)


def test_another_coulomb_friction_beside_a_drag_is_said_to_be_that():
    found = fitted([ladder(3), ladder(4, 1.1 * COULOMB)])
    low, high = found.parameters['joint']['viscous'].interval
    assert low < VISCOUS < high
    low, high = found.parameters['joint']['coulomb'].interval
    assert low < COULOMB < 1.1 * COULOMB < high
