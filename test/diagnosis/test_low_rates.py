# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Joints that stick where they turn around are no unknown structure at a low rate either."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import only_full

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.mujoco.reading import read_mjcf
from sosml_friction.regression.settings import DiagnosisSettings
from validation.motion import reference

mujoco_plant = pytest.importorskip('validation.mujoco_plant')

#: Drawn numbers: of a recording that showed it, and of one drawn afterwards.
SEEDS = ([41, 5], pytest.param([43, 0], marks=only_full))


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
