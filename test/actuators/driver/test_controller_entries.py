# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver tells of its controllers is what it commands."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
from lockstep import (
    Lockstep,
    default_configuration,
    emulated_exoskeleton,
    nominal_robot,
)

from sosml_friction.actuators.driver.configuration import controller_entries
from sosml_friction.actuators.rmd_x.configuration import POSITION_MODE
from sosml_friction.bags.controllers import parse_controllers
from sosml_friction.motion.trajectory import Trajectory


def test_entries_are_in_units_of_the_joint_and_can_be_read_back():
    configuration, limits = default_configuration(), nominal_robot().limits
    entries = controller_entries(configuration, limits)
    assert parse_controllers(json.dumps(entries), 'text') == entries
    shoulder = entries['shoulder']
    # config/exoskeleton.yaml: 6.4 A and 500 A/s at 1.25 Nm/A.
    assert shoulder == {
        'kind': 'pd', 'kp': 250.0, 'kd': 12.0, 'limit': 8.0, 'rate_limit': 625.0, 'rate': 500.0,
        'velocity_window': 11,
    }  # fmt: skip
    assert entries['elbow']['kind'] == 'actuator'
    assert 'servo' in entries['elbow']['reason']


def test_a_loop_in_the_motor_is_not_known():
    configuration = default_configuration()
    moved = dataclasses.replace(configuration.joints[0], mode=POSITION_MODE)
    configuration = dataclasses.replace(configuration, joints=(moved, *configuration.joints[1:]))
    entry = controller_entries(configuration, nominal_robot().limits)['shoulder']
    assert entry['kind'] == 'actuator'
    assert 'position' in entry['reason']


def test_the_law_with_the_gains_of_the_entry_gives_the_efforts_of_the_driver():
    """Through driver, bytes and emulator, in motion; with other gains it does not."""
    configuration, robot = default_configuration(), nominal_robot()
    entry = controller_entries(configuration, robot.limits)['shoulder']
    rows = []
    with Lockstep(emulated_exoskeleton(seed=3)) as bench:
        bench.driver.configure()
        bench.run(0.06)
        bench.driver.enable()
        bench.run(0.1)
        here = bench.samples[-1].q
        times, way = np.array([0.0, 0.6, 1.2]), np.array([0.4, 0.2])
        positions = np.array([here, here + way, here])
        zeros = np.zeros_like(positions)
        bench.driver.follow(Trajectory(configuration.names, times, positions, zeros))
        for _ in range(600):
            bench.step()
            sample, reference = bench.samples[-1], bench.driver._motion.follower.last
            ahead = robot.inverse_dynamics(reference.q, reference.v, reference.a)
            wanted = (reference.q[0], reference.v[0], ahead[0])
            rows.append([sample.tau[0], sample.q[0], sample.v[0], *wanted])
    tau, q, v, q_r, v_r, ahead = np.array(rows).T

    def left(kp, kd):
        # A cycle's command is made of its reference and the sample before; the effort of a sample
        # is of the command one before, whose current flowed until then.
        wanted = ahead[1:-1] + kp * (q_r[1:-1] - q[:-2]) + kd * (v_r[1:-1] - v[:-2])
        return float(np.std(tau[2:] - wanted))

    own = left(entry['kp'], entry['kd'])
    # Current noise 0.03 A at 1.25 Nm/A is 0.04 Nm; the current loop lags on the ramps.
    assert own < 0.08
    assert left(0.8 * entry['kp'], entry['kd']) > 1.2 * own
    assert left(entry['kp'], 0.5 * entry['kd']) > 1.2 * own
