# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What hangs on two quantities at once, or goes up and down in time, is no all-clear."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import (
    SLIDER_MASS,
    SLIDER_STEP,
    arm_model,
    arm_motion,
    recording,
    rigid_effort,
    sines,
    slider_model,
    smooth_sign,
)
from scipy.signal import lfilter

from sosml_friction.diagnosis.diagnosis import diagnose

TWO = 'position and the position of the next joint at once'
WANDERS = 'friction by time, back and forth'


def beyond(found):
    """Return what is more than noise, as (axis, joint)."""
    return {(x.axis, x.joint) for x in found.selection.remainder.beyond_chance}


@pytest.mark.parametrize('size', [0.0, 0.1])
def test_effort_of_two_positions_at_once_is_a_structure(size):
    """Size times the product of both, each of variance 1, beside 0.05 Nm of noise."""
    model, rng = arm_model(), np.random.default_rng(2)
    t = np.arange(0.0, 60.0, 4e-3)
    q, v, a = arm_motion(t)
    tau = rigid_effort(model, q, v, a) + 0.5 * np.tanh(v / 2e-3) + 0.2 * v
    tau += rng.normal(0.0, 0.05, tau.shape)
    z = (q - q.mean(axis=0)) / q.std(axis=0)
    tau[:, 1] += size * z.prod(axis=1)
    found = diagnose([recording(('shoulder', 'elbow'), t, q, tau)], model)
    assert ((TWO, 1) in beyond(found)) == bool(size)
    assert found.verdict == ('unknown_structure' if size else 'nothing_above_floor')


@pytest.mark.parametrize('size', [0.0, 2.0])
def test_friction_that_wanders_is_a_structure(size):
    """
    With a memory of 2 s, by a tenth of its 20 N, beside 1 N of noise.

    The joint turns around more often than that, as else it is the same as slow noise of effort.
    """
    t, rng = np.arange(0.0, 60.0, SLIDER_STEP), np.random.default_rng(4)
    q, v, a = sines(t, ((0.03, 4.0), (0.012, 9.1)))
    pole = np.exp(-SLIDER_STEP / 2.0)
    level = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], rng.standard_normal(len(t)))
    tau = SLIDER_MASS * a + 200.0 * v + (20.0 + size * level) * smooth_sign(q, v)
    found = diagnose(
        [recording(('slider',), t, q, tau + rng.normal(0.0, 1.0, len(t)))], slider_model()
    )
    assert ((WANDERS, 0) in beyond(found)) == bool(size)
    assert found.verdict == ('unknown_structure' if size else 'nothing_above_floor')
    assert ('friction of slider depends on time' in found.sentence) == bool(size)


def test_a_joint_that_stands_has_no_two_quantities():
    t = np.arange(0.0, 30.0, SLIDER_STEP)
    tau = np.random.default_rng(1).normal(0.0, 1.0, len(t))
    found = diagnose([recording(('slider',), t, 0.3 + 0.0 * t, tau)], slider_model())
    assert found.verdict in ('nothing_above_floor', 'bad_data')


@pytest.mark.parametrize('size', [0.0, 6.0])
def test_friction_that_steps_once_is_no_noise(size):
    """By 6 of 20 N at two thirds of 30 s: a model of noise that has it would whiten it away."""
    t, rng = np.arange(0.0, 30.0, SLIDER_STEP), np.random.default_rng(6)
    q, v, a = sines(t, ((0.08, 0.9), (0.02, 2.1)))
    level = 20.0 + np.where(t > 20.0, size, 0.0)
    tau = SLIDER_MASS * a + 200.0 * v + level * smooth_sign(q, v)
    tau += rng.normal(0.0, 1.0, len(t))
    found = diagnose([recording(('slider',), t, q, tau)], slider_model(20.0, 200.0))
    assert found.verdict == ('unknown_structure' if size else 'nothing_above_floor')
    assert (('friction by time', 0) in beyond(found)) == bool(size)
