# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A cable that bends and slips is a hysteresis, and neither an inertia nor a delay."""

import pytest

from sosml_friction.diagnosis.diagnosis import diagnose
from validation.trial import Spec, build, nominal_model


def test_a_hose_that_bends_and_slips_is_named_beside_friction_that_is_known():
    """
    Four springs that slip one after the other, a seventh of the Coulomb friction, SNR 0.97.

    Its level is that of Dahl's state, which is another build-up: within a quarter.
    """
    trial = build(Spec('x', 'single', 1, 'hysteresis', 1, scale=0.7))
    (cause,) = diagnose([trial.log], nominal_model()).causes
    assert (cause.effect, cause.joint, cause.rivals) == ('hysteresis', 'elbow', ())
    assert cause.parameters['level'].value == pytest.approx(trial.size, rel=0.25)
    # Of its springs the mean one slips at 1.05 of 0.1 to 0.25 rad.
    assert 0.08 < cause.parameters['displacement'].value < 0.4
