# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The columns of a torque constant that ripples."""

from __future__ import annotations

import numpy as np
from known_robots import arm_model, arm_motion, recording

from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.regression.curves.torque_ripple import TorqueRipple
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare


def test_the_columns_are_those_of_cogging_times_the_torque():
    model = arm_model()
    t = np.arange(0.0, 20.0, 4e-3)
    q, _, _ = arm_motion(t)
    log = recording(('shoulder', 'elbow'), t, q, 0.0 * q)
    signals = prepare([log], model, model.make_robot(), DiagnosisSettings(band=15.0))[0]
    curve, inner = TorqueRipple(), {'frequency': 9.0}
    assert list(curve.grid(signals, 1)) == list(Cogging().grid(signals, 1))
    torque = signals.torque[:, 1, None]
    found = curve.columns(signals, 1, inner)
    assert not found[:, 0].any()
    assert np.ptp(torque) > 1.0
    np.testing.assert_allclose(found[:, 1], torque * Cogging().columns(signals, 1, inner)[:, 1])


def test_a_torque_constant_changes_by_no_more_than_half():
    half, more = (Fitted(None, 0, {}, np.array([0.3, size]), np.zeros(2)) for size in (0.4, 0.41))
    assert not TorqueRipple().implausible(half)
    assert TorqueRipple().implausible(more)
