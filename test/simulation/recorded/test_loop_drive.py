# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Commands that are made while a simulation runs act for as long as they were held."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.recorded.loop_drive import LoopDrive

PERIOD = 2e-3


class Steps(LoopDrive):
    """Ask for 1 Nm from the beginning of sample 0 on and for 3 Nm from its quarter on."""

    def begin(self, k, q):
        super().begin(k, q)
        if k == 0:
            self.ask(0.0, np.ones(2))
            self.ask(0.25, np.full(2, 3.0))


@pytest.fixture
def drive(request, make_serial_arm):
    robot = Robot(make_serial_arm(['revolute'] * 2), ['j1', 'j2'], [0.1, 0.1])
    friction = JointFriction([None, None])
    model = ForwardModel(robot, friction, np.ones(2), delay=np.array(request.param) * PERIOD)
    result = Steps(model, PERIOD)
    result.begin(0, np.zeros((1, 2)))
    return result


def means(drive, ends):
    return [float(drive.torque(*part)[0][0, 0]) for part in itertools.pairwise(ends)]


@pytest.mark.parametrize('drive', [0.0], indirect=True)
def test_a_part_of_a_sample_has_the_impulse_of_its_commands(drive):
    assert means(drive, [0.0, 0.5, 1.0]) == pytest.approx([2.0, 3.0])
    begin, end = drive.torque(0.5, 1.0)
    assert begin.shape == (1, 2)
    np.testing.assert_array_equal(begin, end)


@pytest.mark.parametrize('drive', [-0.5], indirect=True)
def test_where_effort_is_reported_early_its_torque_is_late(drive):
    """By half a sample: the change at 0.25 acts at 0.75."""
    assert means(drive, [0.0, 0.5, 1.0]) == pytest.approx([1.0, 2.0])
    drive.begin(1, np.zeros((1, 2)))
    assert means(drive, [0.0, 1.0]) == pytest.approx([3.0])


@pytest.mark.parametrize('drive', [(-0.5, 0.0)], indirect=True)
def test_each_joint_is_late_by_its_own_time(drive):
    assert drive.torque(0.0, 0.5)[0][0] == pytest.approx([1.0, 2.0])
    assert drive.torque(0.5, 1.0)[0][0] == pytest.approx([2.0, 3.0])
