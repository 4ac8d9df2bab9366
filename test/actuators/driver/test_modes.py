# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory by the host's loop, by the motor's speed loop and by its position loop."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.rmd_x import codec as rmd_x

MODES = {
    'torque': ({}, 0xA1),
    'speed': ({'mode': 'speed', 'position_gain': 10.0}, 0xA2),
    'position': ({'mode': 'position'}, 0xA4),
}


@pytest.mark.parametrize('mode', MODES)
def test_a_trajectory_is_followed_in_every_mode(make_lockstep, there_and_back, mode):
    """And measured alike; a fault ends in 0 A by 0xA1 whatever the mode was."""
    changes, command = MODES[mode]
    lockstep = make_lockstep(joint={'shoulder': changes})
    driver = lockstep.driver
    driver.configure()
    lockstep.run(0.1)
    driver.enable()
    since = len(lockstep.seen)
    driver.follow(there_and_back)
    error = []
    while driver.trajectory_running or not error:
        sample = lockstep.step()
        error.append(driver.report().joints[0].tracking_error)
        assert driver.state is DriverState.ENABLED, driver.report().reason
    assert np.abs(error).max() < 0.1
    assert np.isfinite(sample.tau).all()
    commands = {frame.data[0] for _, frame in lockstep.seen[since:] if frame.can_id == 0x141}
    assert commands == {command, 0x92, 0x9A, 0xB1}
    driver.fault('test')
    since = len(lockstep.seen)
    lockstep.run(0.05)
    assert len(lockstep.currents(since)) == 25
    assert not lockstep.currents(since).any()
    np.testing.assert_allclose(lockstep.emulator.effort, 0.0, atol=1e-6)


def test_the_speed_that_is_asked_for_never_exceeds_the_limit(make_lockstep, there_and_back):
    lockstep = make_lockstep(
        joint={'shoulder': {'mode': 'speed', 'position_gain': 500.0, 'tracking_limit': 5.0}}
    )
    lockstep.driver.configure()
    lockstep.run(0.1)
    lockstep.driver.enable()
    lockstep.driver.follow(there_and_back)
    lockstep.run(0.3)
    speeds = [
        rmd_x.decode_request(frame)[1].speed
        for _, frame in lockstep.seen
        if frame.can_id == 0x141 and frame.data[0] == 0xA2
    ]
    limit = lockstep.driver._actuators[0].limits.velocity
    assert len(speeds) > 10
    assert np.abs(speeds).max() <= limit + 1e-4


@pytest.mark.parametrize('counts', [0, 2**20])
def test_velocity_is_as_good_as_the_position_it_comes_from(make_lockstep, counts):
    """17 bits before a gear of 1:8 have steps 29 times finer than the 0.01 degree of 0x92."""
    options = EmulatorOptions(rmd_encoder_counts=2**20, rmd_encoder_noise=0.0)
    lockstep = make_lockstep(options=options, joint={'shoulder': {'counts_per_turn': counts}})
    lockstep.driver.configure()
    lockstep.run(0.2)
    # A slow creep across the steps.
    lockstep.samples.clear()
    for _ in range(200):
        lockstep.emulator.plant.v[0] = 0.05
        lockstep.step()
    v = np.array([sample.v[0] for sample in lockstep.samples[50:]])
    assert v.mean() == pytest.approx(0.05, abs=0.003)
    # A step's D / sqrt(12) by the slope of 11 positions 2 ms apart; gravity adds up to 1 mrad/s.
    lsb = 2 * np.pi / counts if counts else rmd_x.ANGLE_RESOLUTION
    noise = lsb / np.sqrt(12.0) * np.sqrt(12.0 / (11 * 120)) / 0.002
    assert v.std() < 1.5 * noise + 1e-3
    assert v.std() > 0.3 * noise
    steps = np.array([sample.q[0] for sample in lockstep.samples])
    counted = (steps + np.pi / 2) / lsb
    np.testing.assert_allclose(counted, np.round(counted), atol=1e-3)
