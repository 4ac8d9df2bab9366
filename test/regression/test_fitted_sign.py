# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Over what friction changes its sign is found where the model does not say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.simple_models import free_model
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

STEP, INERTIA, COULOMB, VISCOUS, NOISE = 0.004, 0.3, 1.0, 2.0, 0.02
MODEL = free_model(INERTIA, 'joint')


def motion(drift=0.0):
    """Return time, position and velocity of a joint that turns around slowly, or only drifts."""
    t = STEP * np.arange(15000)
    q = 0.4 * np.sin(0.4 * t) + 0.2 * np.sin(1.1 * t + 1.0) + 0.1 * np.sin(2.1 * t + 2.0)
    v = 0.16 * np.cos(0.4 * t) + 0.22 * np.cos(1.1 * t + 1.0) + 0.21 * np.cos(2.1 * t + 2.0)
    return t, q + drift * t, v + drift


def log_of(sign, drift=0.0):
    """Return a recording in which friction has this sign (N,)."""
    t, q, v = motion(drift)
    rng = np.random.default_rng(3)
    tau = INERTIA * np.gradient(v, STEP) + COULOMB * sign + VISCOUS * v
    tau = tau + NOISE * rng.standard_normal(len(t))
    return recording(('joint',), t, q + 2e-6 * rng.standard_normal(len(t)), tau)


def fitted_width(sign, model=MODEL, drift=0.0):
    robot, log = model.make_robot(), log_of(sign, drift)
    return float(prepare([log], model, robot, DiagnosisSettings())[0].scales.width[0])


@pytest.mark.parametrize('width', [0.004, 0.01, 0.03])
def test_a_sign_that_is_smooth_in_velocity_is_found(width):
    """Within a step of what is tried, 1.8."""
    assert 1.0 / 1.8 < fitted_width(smooth_sign(motion()[2], width)) / width < 1.8


def test_a_jump_is_as_narrow_as_is_tried():
    """The least width, a thousandth of the top speed, or the next, with its finer steps."""
    v = motion()[2]
    assert fitted_width(np.sign(v)) < 0.0027 * np.abs(v).max()


def test_a_sign_that_changes_over_a_displacement_is_no_smooth_one():
    assert fitted_width(dahl_path(motion()[1], 4e-4)) == 0.0


def test_a_width_that_the_model_states_stays():
    sign = smooth_sign(motion()[2], 0.01)
    joints = {'joint': replace(MODEL.joints['joint'], smoothing_velocity=0.02)}
    assert fitted_width(sign, replace(MODEL, joints=joints)) == 0.02


def test_a_smooth_sign_is_no_cause():
    found = diagnose([log_of(smooth_sign(motion()[2], 0.01))], MODEL)
    assert (found.verdict, found.causes) == ('nothing_above_floor', ())


def test_of_a_joint_that_never_turns_around_friction_that_fades_with_speed_is_no_smooth_sign():
    """A tanh over much velocity beside a constant has the shape of a Stribeck term."""
    fading = 1.0 + 0.5 * np.exp(-motion(1.0)[2] / 0.7)
    assert fitted_width(fading, drift=1.0) == 0.0
