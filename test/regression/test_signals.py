# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the nominal model expects of a motion, of its steady acceleration and of the rest."""

from __future__ import annotations

import numpy as np
import pytest

import sosml_friction as sf
from sosml_friction.model.finite_differences import first_derivative
from sosml_friction.regression.band import Band
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

STEP = 4e-3
BAND = 20.0


@pytest.mark.parametrize('follows', [False, True], ids=['every joint', 'one that follows'])
def test_the_bodies_of_the_residual_have_the_acceleration_as_it_is_measured(
    make_serial_arm, follows
):
    """Inverse dynamics of q'' as measured, of the bodies that follow a joint too."""
    urdf, names = make_serial_arm(['revolute'] * 3), ['j1', 'j2', 'j3']
    if follows:
        mimic = '<mimic joint="j1" multiplier="-2" offset="0.4"/><limit lower="-3"'
        urdf, names = urdf.replace('<limit lower="-3"', mimic), names[:2]
    model = sf.Model.from_urdf(urdf, dict.fromkeys(names, 0.01))
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 30.0, STEP)
    phase = rng.uniform(0.0, 6.0, len(names))
    q = 0.4 * np.sin(2.0 * np.pi * 0.3 * t[:, None] + phase)
    q += 5e-5 * rng.standard_normal(q.shape)
    t_ns = np.round(1e9 * t).astype(np.int64)
    log = sf.JointLog(tuple(names), t_ns, q, np.full_like(q, np.nan), rng.normal(size=q.shape))
    robot = model.content.make_robot()
    (s,) = prepare([log], model.content, robot, DiagnosisSettings(band=BAND))
    smooth = Band(BAND, STEP).smooth(q)
    v = first_derivative(smooth, STEP)
    a = first_derivative(v, STEP)
    assert bool(robot.followers) == follows
    assert np.std(s.shaken) > 0.0
    for k in range(100, len(q) - 100, 400):
        needed = robot.inverse_dynamics(smooth[k], v[k], a[k])
        expected = (s.tau - s.unexplained - s.friction)[k]
        assert expected == pytest.approx(needed, abs=1e-9)
