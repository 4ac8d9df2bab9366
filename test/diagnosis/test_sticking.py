# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint that sticks at each reversal, with nothing hidden, is no structure without a name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import coulomb_viscous, recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.simple_models import pendulum_model

MASS, LENGTH, INERTIA, COULOMB, VISCOUS = 1.2, 0.3, 0.02, 0.25, 0.08


def driven(noise: float, seconds: float = 60.0, step: float = 0.002, parts: int = 10):
    """Return time, position and effort of a pendulum whose motor holds its effort for a step."""
    rng = np.random.default_rng(5)
    total, weight, h = INERTIA + MASS * LENGTH**2, MASS * 9.80665 * LENGTH, step / parts
    t = step * np.arange(round(seconds / step))
    aim = 0.8 * np.sin(0.9 * t) + 0.4 * np.sin(2.3 * t + 1.0)
    speed = 0.72 * np.cos(0.9 * t) + 0.92 * np.cos(2.3 * t + 1.0)
    q = v = 0.0
    measured, effort = np.empty_like(t), np.empty_like(t)
    for k in range(len(t)):
        measured[k] = q + noise * rng.standard_normal()
        tau = 40.0 * (aim[k] - measured[k]) + 3.0 * (speed[k] - v) + weight * np.sin(aim[k])
        effort[k] = tau + 0.01 * rng.standard_normal()
        for _ in range(parts):
            # Steep enough to stick for some samples, and slow enough for the step.
            friction = COULOMB * np.tanh(v / 1e-3) + VISCOUS * v
            v += h * (tau - weight * np.sin(q) - friction) / total
            q += h * v
    return t, measured, effort


@pytest.mark.parametrize('noise', [1e-7, 5e-5])
def test_a_joint_that_sticks_at_reversals_hides_nothing(noise):
    t, q, tau = driven(noise)
    model = pendulum_model(MASS, LENGTH, INERTIA, 0.0, 'joint')
    joint = model.joints['joint']
    law = coulomb_viscous(COULOMB, VISCOUS)
    model = replace(model, joints={'joint': replace(joint, friction=law)})
    log = recording(('joint',), t, q[:, None], tau[:, None])
    found = diagnose([log], model)
    assert found.verdict == 'nothing_above_floor', found.sentence
