# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The runs of the paper's study, with a plant step that is coarser than the study's own."""

from __future__ import annotations

import pytest

from sosml_friction.model.robot import Robot
from sosml_friction.study.motion import MOTIONS
from sosml_friction.study.plant import StudyRun, simulate, study_robot

PLANT_STEP = 200e-6


@pytest.fixture(scope='session')
def study_arm() -> Robot:
    return study_robot()


@pytest.fixture(scope='session')
def study_runs(study_arm: Robot) -> dict[str, StudyRun]:
    """Return both motions in full length, by name."""
    return {
        name: simulate(study_arm, motion.reference, motion.duration, PLANT_STEP)
        for name, motion in MOTIONS.items()
    }
