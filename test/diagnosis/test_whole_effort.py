# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An effort that is a multiple of all that the model needs is told beside the causes."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import coulomb_viscous, recording, sines

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.regression.settings import DiagnosisSettings

MASS, LENGTH, ARMATURE, COULOMB, VISCOUS = 0.25, 0.16, 0.02, 0.4, 0.2


def told(scale, friction=1.0, trust=None, rotor=ARMATURE):
    """Return what is told of an effort ``scale`` times as large, by a model of this friction."""
    t = 0.01 * np.arange(3000)
    q, v, a = sines(t, ((0.9, 1.3, 0.0), (0.5, 3.1, 1.0), (0.1, 9.3, 2.0)))
    tau = rotor * a + (rotor / ARMATURE) * MASS * (LENGTH**2 * a + 9.81 * LENGTH * np.sin(q))
    tau = scale * (tau + COULOMB * np.tanh(v / 4e-3) + VISCOUS * v)
    log = recording(('joint',), t, q, tau + 0.02 * np.random.default_rng(1).standard_normal(3000))
    model = pendulum_model(rotor / ARMATURE * MASS, LENGTH, 0.0, rotor)
    law = coulomb_viscous(friction * COULOMB, friction * VISCOUS)
    own = replace(model.joints['joint'], friction=law)
    settings = DiagnosisSettings(trust=trust or {})
    found = diagnose([log], replace(model, joints={'joint': own}), settings=settings)
    return [(c.severity, c.values['scale']) for c in found.checks if c.kind == 'effort_scale']


@pytest.mark.parametrize('scale', [0.4, 1.8])
def test_another_scale_of_all_that_the_model_needs_is_bad_and_told_with_its_size(scale):
    assert told(scale) == [('bad', pytest.approx(scale, rel=0.02))]


def test_a_scale_that_friction_alone_may_have_is_a_warning():
    """A motor whose rotor needs little: friction that is twice as large explains as much."""
    assert told(1.0, friction=0.5, rotor=1e-3) == [('warning', pytest.approx(2.0, rel=0.1))]


def test_what_a_cause_may_be_and_a_friction_that_is_a_guess_are_not():
    assert told(1.4) == []
    assert told(1.0, friction=0.2, trust={'friction': np.inf}) == []
