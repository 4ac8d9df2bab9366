# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A loop that feeds the noise of position back into effort is no structure without a name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_runs import in_full
from known_robots import coulomb_viscous, recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.model_folder import EffectTerm
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model

MASS, LENGTH, INERTIA, COULOMB, VISCOUS = 1.2, 0.3, 0.06, 1.2, 0.5
SPRING, REST = 14.0, 0.2
TOTAL, WEIGHT = INERTIA + MASS * LENGTH**2, MASS * 9.80665 * LENGTH
#: A step of the encoder [rad], and over what elements of friction build up.
STEP, BUILD_UP = 2.0 * np.pi / 2**16, 1e-4 * np.linspace(0.3, 1.7, 5)


def ladder(rng: np.random.Generator, count: int, step: float):
    """Return position and velocity to and fro, at speeds of 0.06 to 2 rad/s in any order."""
    strokes = []
    for speed in 2.0 * rng.permutation(np.geomspace(0.03, 1.0, 7)):
        stroke = np.full(round(min(1.2 / speed, 3.0) / step), speed)
        strokes += [stroke, -stroke]
    v = np.resize(np.concatenate(strokes), count)
    window = np.hanning(round(0.12 / step) + 2)[1:-1]
    v = np.convolve(v, window / window.sum(), 'same')
    return np.cumsum(v) * step - 0.5, v


def driven(seed: int, seconds: float = 60.0, step: float = 1e-3, parts: int = 4, rows: int = 10):
    """Return position and effort every ``rows`` cycles of a stiff loop on a coarse encoder."""
    rng = np.random.default_rng(seed)
    count, h = round(seconds / step), step / parts
    aim, speed = ladder(rng, count, step)
    push = np.gradient(speed, step)
    q, v, rate, z = aim[0], 0.0, 0.0, np.zeros(len(BUILD_UP))
    measured, effort = np.empty(count), np.empty(count)
    for k in range(count):
        measured[k] = STEP * round(q / STEP + 0.5 * rng.standard_normal())
        if k:
            rate += 0.3 * ((measured[k] - measured[k - 1]) / step - rate)
        tau = TOTAL * (push[k] + 600.0 * (aim[k] - measured[k]) + 40.0 * (speed[k] - rate))
        tau += WEIGHT * np.sin(q)
        effort[k] = tau + 0.06 * rng.standard_normal()
        for _ in range(parts):
            z = np.clip(z + h * v, -BUILD_UP, BUILD_UP)
            friction = COULOMB * float(np.mean(z / BUILD_UP)) + VISCOUS * v
            v += h * (tau - WEIGHT * np.sin(q) - friction - SPRING * (q - REST)) / TOTAL
            q += h * v
    return step * np.arange(0, count, rows), measured[::rows], effort[::rows]


@pytest.mark.parametrize('seed', [0, in_full(11)])
def test_effort_that_follows_the_noise_of_position_hides_nothing(seed):
    """It was a curve over acceleration, whose knots lay within what noise makes of it."""
    t, q, tau = driven(seed)
    model = pendulum_model(MASS, LENGTH, INERTIA, 0.0, 'joint')
    sizes = {
        'stiffness': Parameter(SPRING, 'Nm/rad'),
        'offset': Parameter(-SPRING * REST, 'Nm'),
    }
    law = coulomb_viscous(COULOMB, VISCOUS)
    model = replace(
        model,
        joints={'joint': replace(model.joints['joint'], friction=law)},
        effects=(EffectTerm('spring', 'joint', sizes),),
    )
    log = recording(('joint',), t, q, tau)
    found = diagnose([log], model)
    assert found.verdict == 'nothing_above_floor', found.sentence
