# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A cause whose own axis holds more than it explains is not the whole."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.settings import DiagnosisSettings
from sosml_friction.simulation.dahl import dahl_path


def diagnosed(extra):
    """Return the diagnosis of a slider with friction 20 s + 200 v + extra(v) [N]."""
    log = slider_recording(extra, seed=1, sign=lambda q, _: dahl_path(q, 4e-5))
    return diagnose([log], slider_model(), settings=DiagnosisSettings(nulls=8))


@pytest.mark.parametrize(
    ('extra', 'verdict'),
    [
        (lambda v: 60.0 * v, 'named'),
        # Quadratic drag is in no catalogue; a viscous friction of its mean slope fits most of it.
        (lambda v: 250.0 * v * np.abs(v), 'unknown_structure'),
    ],
)
def test_viscous_friction_is_named_and_quadratic_drag_is_not_called_viscous(extra, verdict):
    found = diagnosed(extra)
    assert found.verdict == verdict
    assert found.causes[0].effect == 'viscous'
    (axis,) = found.structure['axes']
    assert axis['unknown'] == (verdict == 'unknown_structure')
    assert ('depends on speed in another way' in found.sentence) == axis['unknown']


def test_a_constant_offset_while_moving_is_a_bias_or_an_asymmetry_and_said_to_be_either():
    """Without rest only reversals tell them apart, and how friction turns around is not known."""
    found = diagnosed(lambda v: 8.0 + 0.0 * v)
    first = found.causes[0]
    assert {first.effect, *first.rivals} == {'effort_bias', 'asymmetric_friction'}
    assert found.verdict == 'ambiguous'
