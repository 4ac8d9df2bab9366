# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The emulated exoskeleton without noise, and a driver on it that is under way."""

from __future__ import annotations

from typing import Any

import numpy as np

from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.servo.dbc import ServoDbc
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.share import share_directory

MS = 1_000_000
QUIET = EmulatorOptions(
    rmd_current_noise=0.0,
    rmd_encoder_noise=0.0,
    servo_current_noise=0.0,
    servo_encoder_noise=0.0,
    latency_jitter=0.0,
)
DBC = ServoDbc(share_directory() / 'config' / 'elbow_servo.dbc')


def moving(lockstep: Any, trajectory: Trajectory) -> None:
    """Let the driver follow a trajectory for half a second; the shoulder has current then."""
    lockstep.driver.enable()
    lockstep.driver.follow(trajectory)
    lockstep.run(0.5)
    assert lockstep.driver.state is DriverState.ENABLED
    assert np.abs(lockstep.currents()[-50:]).min() > 0.1
