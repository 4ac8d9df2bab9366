# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A wrong report of all effort where the model knows the bodies' part alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.dahl import dahl_path
from sosml_friction.regression.settings import DiagnosisSettings

#: Effort at which the report exceeds the force by ``EXCESS`` [N].
REFERENCE, EXCESS = 45.0, 3.0


def saturated(seed: int):
    """Return the slider's recording, its force reported with a motor that saturates."""
    log = slider_recording(seed=seed, sign=lambda q, v: dahl_path(q, 4e-5))
    return replace(log, tau=log.tau + EXCESS * (log.tau / REFERENCE) ** 3)


def without_friction():
    """Return the axis with a friction that nobody stated."""
    model = slider_model()
    return replace(model, joints={'slider': replace(model.joints['slider'], friction=None)})


@pytest.mark.parametrize('seed', [0, 1])
@pytest.mark.parametrize('known', ['nothing', 'a guess'])
def test_a_motor_that_saturates_is_told_from_all_effort(seed, known):
    """Where friction was no part of it, friction by load stood for it."""
    model, trust = without_friction(), {}
    if known == 'a guess':
        model, trust = slider_model(5.0, 600.0), {'friction': np.inf}
    settings = DiagnosisSettings(nulls=2, trust=trust)
    found = diagnose([saturated(seed)], model, settings=settings, without=('thermal_drift',))
    (cause,) = found.causes
    assert (cause.effect, cause.rivals) == ('effort_saturation', ())
    excess, reference = cause.parameters['excess'], cause.parameters['reference'].value
    true = EXCESS * (reference / REFERENCE) ** 3
    assert excess.value == pytest.approx(true, abs=3.0 * excess.std_error)
