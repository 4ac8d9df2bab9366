# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The arm of seven joints is what it says: bodies by MuJoCo, friction, and one effect."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('mujoco')

import sosml_friction as sf
from validation.seven_plant import (
    CATALOGUE,
    COULOMB,
    EFFORT,
    MOTIONS,
    NAMES,
    NOISE,
    OF_ROBOT,
    OUTSIDE,
    ROTOR,
    VISCOUS,
    Arm,
    recording,
)

LONG_S = 4.0


def test_its_bodies_need_what_pinocchio_says():
    """Two programs, one URDF: to rounding."""
    arm, rng = Arm.nominal(), np.random.default_rng(0)
    model = sf.Model.from_urdf(arm.urdf(), dict(zip(NAMES, ROTOR.tolist(), strict=True)))
    robot = model.content.make_robot()
    q, v, a = rng.uniform(-1.0, 1.0, (3, 5, 7))
    expected = [robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)]
    np.testing.assert_allclose(arm.effort(q, v, a), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize('motion', MOTIONS)
def test_its_effort_is_that_of_bodies_and_friction_but_for_noise_and_one_percent(motion):
    log, *_ = recording(np.random.default_rng(1), motion, LONG_S)
    t, arm = log.time, Arm.nominal()
    v = np.gradient(log.q, t, axis=0)
    a = np.gradient(v, t, axis=0)
    moving = (np.abs(v) > 0.03).all(axis=1) & (np.abs(a) < 20.0).all(axis=1)
    expected = arm.effort(log.q, v, a) + COULOMB * np.sign(v) + VISCOUS * v
    left = np.abs(log.tau - expected)[moving]
    # 3 % of all that acts, five of noise, and the noise of a position that is derived twice.
    most = 0.03 * np.abs(expected[moving]) + 5.0 * NOISE * EFFORT
    assert moving.sum() > 100
    assert np.mean(left < most + 0.05 * EFFORT) > 0.99


@pytest.mark.parametrize('effect', [*CATALOGUE, *OUTSIDE])
def test_an_effect_changes_the_effort_of_its_joint(effect):
    plain, *_ = recording(np.random.default_rng(2), 'sines', LONG_S)
    log, joint, size = recording(np.random.default_rng(2), 'sines', LONG_S, effect)
    low, high = {**CATALOGUE, **OUTSIDE}[effect]
    assert low <= size <= high
    changed = np.abs(log.tau - plain.tau)
    assert changed[:, joint].max() > 0.0
    assert effect in OF_ROBOT or np.delete(changed, joint, axis=1).max() == 0.0
