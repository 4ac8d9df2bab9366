# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Joints that stick are no unknown structure at a low rate, and rates may differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_runs import in_full
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.mujoco.reading import read_mjcf
from sosml_friction.regression.settings import DiagnosisSettings
from validation.motion import reference

mujoco_plant = pytest.importorskip('validation.mujoco_plant')

#: Drawn numbers: of a recording that showed it, and of one drawn afterwards.
SEEDS = ([41, 5], in_full([43, 0]))


@pytest.mark.parametrize('seed', SEEDS)
def test_an_arm_that_sticks_where_it_turns_around_is_explained_at_62_hz(seed, tmp_path):
    """It stands for 0.03 to 0.15 s, which the band of 6 Hz shows neither as rest nor as motion."""
    rng = np.random.default_rng(seed)
    arm = mujoco_plant.make_arm(rng, 0.015)
    log = mujoco_plant.simulate(arm, reference('rich'), rng)
    (tmp_path / 'arm.xml').write_text(mujoco_plant.Arm().xml())
    model = read_mjcf(tmp_path / 'arm.xml')
    found = diagnose([log.rows(np.arange(0, len(log), 8))], model, settings=DiagnosisSettings())
    assert found.verdict == 'nothing_above_floor', found.sentence


def test_recordings_of_different_rates_name_one_cause():
    """The slow one first: its velocities were off by the ratio of the rates, and so C + B v."""
    logs = [slider_recording(seed=seed) for seed in (1, 2)]
    logs = [replace(log, tau=log.tau + 6.0 * np.sin(150.0 * log.q)) for log in logs]
    logs[0] = logs[0].rows(np.arange(0, len(logs[0]), 2))
    found = diagnose(logs, slider_model(), settings=DiagnosisSettings())
    assert [(cause.effect, cause.joint) for cause in found.causes] == [('cogging', 'slider')]
    sine = found.causes[0].parameters['sine']
    assert abs(sine.value - 6.0) < 3.0 * sine.std_error
