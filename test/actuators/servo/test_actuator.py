# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a servo is sent, and what is made of what it says: frames, no bus."""

from __future__ import annotations

import math

import pytest
from quiet_emulator import DBC

from sosml_friction.actuators.measurement import Setpoint
from sosml_friction.actuators.servo.actuator import ServoActuator
from sosml_friction.actuators.servo.configuration import ServoConfiguration
from sosml_friction.actuators.servo.dbc import Mode, ServoFlag, ServoState
from sosml_friction.exceptions import CanProtocolError
from sosml_friction.model.robot import JointLimits

LIMITS = JointLimits(-0.5, 2.5, 3.0, 5.0)
# One count of the target [rad].
COUNT = 2e-4
NO_FLAG = ServoFlag(0)


def servo(q=0.3, direction=1, status=NO_FLAG):
    own = ServoActuator(ServoConfiguration('elbow', direction, 0.1, 2.0), LIMITS, 500.0)
    own.accept(DBC.encode_state(ServoState(direction * (q - 0.1), 0.5, 1.5, status, 0)), 7)
    return own


def target(own, position):
    (request,) = own.command(Setpoint(0.0, position, 0.0), 1)
    return DBC.decode_command(request.frame)


@pytest.mark.parametrize('direction', [1, -1])
def test_the_target_moves_no_faster_than_the_joint_may(direction):
    """3 rad/s at 500 Hz are 6 mrad, up and down, in the servo's own direction."""
    own = servo(direction=direction)
    steps = [direction * target(own, 2.0).target + 0.1 for _ in range(3)]
    assert steps == pytest.approx([0.306, 0.312, 0.318], abs=COUNT)
    steps = [direction * target(own, -2.0).target + 0.1 for _ in range(3)]
    assert steps == pytest.approx([0.312, 0.306, 0.300], abs=COUNT)


@pytest.mark.parametrize(('q', 'wanted', 'end'), [(2.499, 9.0, 2.5), (-0.499, -9.0, -0.5)])
def test_the_target_stays_within_the_joints_limits(q, wanted, end):
    own = servo(q)
    for _ in range(5):
        last = target(own, wanted)
    assert last.mode is Mode.POSITION
    assert last.target + 0.1 == pytest.approx(end, abs=COUNT)


def test_a_free_servo_begins_again_where_the_joint_is():
    own = servo()
    for _ in range(100):
        target(own, 2.0)
    assert DBC.decode_command(own.release(2)[0].frame).mode is Mode.OFF
    assert target(own, 2.0).target + 0.1 == pytest.approx(0.306, abs=COUNT)


@pytest.mark.parametrize('direction', [1, -1])
def test_what_is_measured_is_in_the_joints_direction(direction):
    measured = servo(0.3, direction).measurement
    assert measured.q == pytest.approx(0.3, abs=COUNT)
    assert measured.speed == pytest.approx(direction * 0.5, abs=0.01)
    assert measured.tau == pytest.approx(direction * 3.0, abs=0.01)
    assert measured.current == pytest.approx(1.5, abs=0.005)
    assert measured.stamp_ns == 7


def test_a_watchdog_that_tripped_counts_while_a_target_is_out():
    own = servo(status=ServoFlag.WATCHDOG)
    assert own.fault() == ''
    target(own, 0.3)
    assert 'watchdog' in own.fault()
    assert 'under_voltage' in servo(status=ServoFlag.UNDER_VOLTAGE).fault()


@pytest.mark.parametrize('position', [math.nan, math.inf])
def test_a_target_that_is_not_finite_is_never_sent(position):
    with pytest.raises(CanProtocolError, match='not finite'):
        target(servo(), position)
