# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an RMD-X is sent in each mode, and what is made of what it says: frames, no bus."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.measurement import Setpoint
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.actuator import RmdXActuator
from sosml_friction.actuators.rmd_x.configuration import RmdXConfiguration
from sosml_friction.exceptions import CanProtocolError
from sosml_friction.model.robot import JointLimits

LIMITS = JointLimits(-1.7, 0.7, 3.0, 8.0)
JOINT = RmdXConfiguration(
    'shoulder', -1, 0.3, 1.25, can_id=1, current_limit=6.0, current_rate_limit=500.0,
    kp=250.0, kd=12.0,
)  # fmt: skip
DEGREE = math.radians(1.0)


def actuator(**changes):
    return RmdXActuator(replace(JOINT, **changes), LIMITS, 500.0, stop_deceleration=5.0)


def told(own, *replies):
    """Give replies to an actuator as if they had come 1 ms after the start."""
    for reply in replies:
        own.accept(rmd_x.encode_reply(1, reply), 1_000_000)
    return own


def sent(requests):
    return [rmd_x.decode_request(request.frame)[1] for request in requests]


def at(own, q):
    """Let the joint be at ``q``."""
    return told(own, rmd_x.Angle(-(q - 0.3)))


def test_a_cycle_is_current_and_angle_and_now_and_then_status_and_uptime():
    own = at(actuator(), 0.0)
    kinds = [
        [type(message).__name__ for message in sent(own.command(Setpoint(0.0, 0.0, 0.0), t))]
        for t in (0, 2_000_000, 100_000_000)
    ]
    assert kinds == [
        ['SetCurrent', 'ReadAngle', 'ReadStatus', 'ReadUptime'],
        ['SetCurrent', 'ReadAngle'],
        ['SetCurrent', 'ReadAngle', 'ReadStatus'],
    ]


def test_current_is_limited_in_rate_and_size_and_turned_round():
    own = at(actuator(), 0.0)
    currents = [sent(own.command(Setpoint(100.0, 0.0, 0.0), 1))[0].current for _ in range(10)]
    assert currents == pytest.approx([-1.0, -2.0, -3.0, -4.0, -5.0] + [-6.0] * 5)
    assert sent(own.release(2))[0].current == 0.0


def test_speed_mode_feeds_the_reference_forward_and_limits_what_it_asks_for():
    own = at(actuator(mode='speed', position_gain=10.0), 0.0)

    def speed(position, velocity):
        return sent(own.command(Setpoint(0.0, position, velocity), 1))[0].speed

    # The angle is rounded to 0.01 degree, 10 times half of which is 0.9 mrad/s.
    assert speed(0.05, 0.2) == pytest.approx(-(0.2 + 10.0 * 0.05), abs=1e-3)
    # What stops at 5 rad/s^2 within the 0.7 rad left: 2.65 rad/s; the other way the limit, 3.
    assert speed(5.0, 0.0) == pytest.approx(-math.sqrt(2 * 5 * 0.7), abs=1e-3)
    assert speed(-5.0, 0.0) == pytest.approx(3.0, abs=1e-4)
    at(own, 0.75)
    assert speed(5.0, 1.0) == 0.0
    with pytest.raises(CanProtocolError, match='not finite'):
        speed(math.nan, 0.0)


def test_position_mode_stays_within_the_limits_and_never_says_no_limit():
    own = at(actuator(mode='position'), 0.0)

    def position(q):
        return sent(own.command(Setpoint(0.0, q, 0.0), 1))[0]

    assert position(0.5).angle == pytest.approx(-(0.5 - 0.3), abs=1e-4)
    assert position(0.5).max_speed == pytest.approx(3.0, abs=DEGREE)
    assert position(9.0).angle == pytest.approx(-(0.7 - 0.3), abs=1e-4)
    assert position(-9.0).angle == pytest.approx(2.0, abs=1e-4)
    with pytest.raises(CanProtocolError, match='not finite'):
        position(math.inf)


@pytest.mark.parametrize('mode', ['torque', 'speed', 'position'])
def test_a_free_joint_gets_zero_current_in_every_mode(mode):
    own = at(actuator(mode=mode, position_gain=1.0), 0.0)
    own.command(Setpoint(1.0, 0.1, 0.1), 0)
    assert sent(own.release(1))[0] == rmd_x.SetCurrent(0.0)
    assert sent(own.shut_down()) == [rmd_x.SetCurrent(0.0), rmd_x.Shutdown()]


def test_at_the_end_the_motor_may_hold_instead():
    assert sent(actuator(at_end='stop').shut_down()) == [rmd_x.SetCurrent(0.0), rmd_x.Stop()]


def test_observing_commands_nothing():
    own = at(actuator(), 0.0)
    assert sent(own.observe(1))[:2] == [rmd_x.ReadMotion(), rmd_x.ReadAngle()]


def test_position_by_encoder_counts_is_finer_than_by_angle():
    """17 bits by 8: 6 microrad a count where 0x92 has 175."""
    own = actuator(counts_per_turn=2**17 * 8)
    assert sent(own.release(1))[1] == rmd_x.ReadEncoder()
    told(own, rmd_x.Encoder(2**17 * 2))
    assert own.measurement.q == pytest.approx(0.3 - math.pi / 2)
    before = own.measurement.q
    told(own, rmd_x.Encoder(2**17 * 2 + 1))
    assert before - own.measurement.q == pytest.approx(2 * math.pi / 2**20)
    assert own.measurement.position_raw == 2**17 * 2 + 1


def test_effort_is_the_reported_current_not_the_command():
    own = at(actuator(), 0.0)
    own.command(Setpoint(5.0, 0.0, 0.0), 0)
    assert math.isnan(own.measurement.tau)
    told(own, rmd_x.Motion(30, -2.0, 10 * DEGREE, 0.0))
    assert own.measurement.tau == pytest.approx(2.5)
    assert own.measurement.speed == pytest.approx(-10 * DEGREE)


# ---- brake


def test_the_brake_is_opened_by_the_first_command_and_waited_for():
    own = at(actuator(brake=True), 0.0)
    assert rmd_x.ReleaseBrake() not in sent(own.release(0))
    first = own.command(Setpoint(1.0, 0.0, 0.0), 1)
    assert sent(first)[0] == rmd_x.ReleaseBrake()
    assert first[0].patience_ns == 1_000_000_000
    assert 'brake of joint shoulder is opening' in own.waiting()
    assert rmd_x.ReleaseBrake() not in sent(own.command(Setpoint(1.0, 0.0, 0.0), 2))
    told(own, rmd_x.ReleaseBrake())
    assert own.waiting() == ''
    assert sent(own.shut_down())[-1] == rmd_x.LockBrake()


def test_a_brake_that_does_not_answer_is_a_fault_until_the_next_attempt():
    own = at(actuator(brake=True), 0.0)
    request = own.command(Setpoint(1.0, 0.0, 0.0), 1)[0]
    own.overdue(request.key)
    assert 'the brake did not answer' in own.fault()
    own.release(2)
    assert own.fault() == ''


def test_a_joint_without_a_brake_is_never_told_to_open_one():
    own = at(actuator(), 0.0)
    assert rmd_x.ReleaseBrake() not in sent(own.command(Setpoint(1.0, 0.0, 0.0), 1))
    assert rmd_x.LockBrake() not in sent(own.shut_down())


# ---- what the motor says by itself


def test_the_motors_watchdog_is_heard_in_both_forms():
    own = actuator()
    assert own.unsolicited(rmd_x.encode_reply(1, rmd_x.TimeoutExpired()))
    assert own.timeouts == 1
    request = own.command(Setpoint(1.0, 0.0, 0.0), 1)[0]
    assert own.is_echo(request, Frame(0x241, request.frame.data))
    assert own.timeouts == 2
    assert not own.is_echo(request, rmd_x.encode_reply(1, rmd_x.Motion(25, -0.8, 0.0, 0.0)))


@pytest.mark.parametrize('name', ['ReadAngle', 'ReadEncoder', 'ReadUptime', 'Shutdown', 'Stop'])
def test_an_answer_that_may_look_like_its_question_is_no_echo(name):
    own = actuator()
    request = own.request(getattr(rmd_x, name)())
    assert not own.is_echo(request, Frame(0x241, request.frame.data))


def test_a_restart_is_told_by_the_uptime_and_a_late_answer_is_not_one():
    own = actuator()
    for t_ms, uptime_ms in ((0, 10_000), (1000, 11_000), (2020, 12_000), (3000, 13_000)):
        own.accept(rmd_x.encode_reply(1, rmd_x.Uptime(uptime_ms)), t_ms * 1_000_000)
    assert own.restarts == 0
    own.accept(rmd_x.encode_reply(1, rmd_x.Uptime(700)), 4_000_000_000)
    assert own.restarts == 1


def test_a_position_is_commanded_in_the_motors_own_turns_where_counts_have_lost_one():
    """0x92 says one turn more than 0x60: to stay where it is, 0xA4 must say so too."""
    own = actuator(mode='position', counts_per_turn=2**20)
    told(own, rmd_x.Angle(2 * math.pi + 0.5), rmd_x.Encoder(round(2**20 * 0.5 / (2 * math.pi))))
    assert own.check_position().problem == ''
    here = Setpoint(0.0, own.measurement.q, 0.0)
    assert sent(own.command(here, 1))[0].angle == pytest.approx(2 * math.pi + 0.5, abs=2e-4)


def test_at_zero_any_scale_of_counts_fits_but_not_where_the_joint_goes():
    own = actuator(counts_per_turn=2**20)
    told(own, rmd_x.Angle(0.0), rmd_x.Encoder(0))
    assert own.check_position().problem == ''
    told(own, rmd_x.Encoder(2**18), rmd_x.Motion(25, 0.0, 0.0, math.pi / 2))
    assert own.doubt() == ''
    # The true scale is half of it: the joint is twice as far as the counts say.
    told(own, rmd_x.Motion(25, 0.0, 0.0, math.pi))
    assert 'shoulder.counts_per_turn' in own.doubt()


def test_a_status_that_never_comes_is_a_fault():
    """Its other answers may come: without 0x9A its error bits are not known."""
    own = at(actuator(), 0.0)
    for t in range(0, 501_000_000, 2_000_000):
        assert own.fault() == ''
        own.command(Setpoint(0.0, 0.0, 0.0), t)
    assert 'has not told its status (0x9A) in time 5 times' in own.fault()
    told(own, rmd_x.Status(25, True, 48.0, rmd_x.ErrorFlag(0)))
    assert own.fault() == ''


def test_the_echo_of_a_motor_that_timed_out_is_not_taken_for_zero_degrees():
    """Only the first question is echoed, and the echo of 0x92 would be an answer."""
    position = next(s for s in actuator().start_up(read_only=True) if s.name == 'position')
    first = position.requests()[0]
    assert isinstance(sent([first])[0], rmd_x.ReadStatus)
    assert actuator().is_echo(first, Frame(0x241, first.frame.data))


# ---- limits from both sides


@pytest.mark.parametrize('sign', [1.0, -1.0])
@pytest.mark.parametrize(('differ', 'doubted'), [(0.075, False), (0.085, True)])
def test_counts_and_angle_may_differ_by_0_08_rad_before_they_are_doubted(sign, differ, doubted):
    """The coarse angle is exact here: it is put into whole degrees on the wire."""
    own = actuator(counts_per_turn=2**20)
    counts = round(2**20 * (45 * DEGREE + sign * differ) / (2 * math.pi))
    told(own, rmd_x.Encoder(counts), rmd_x.Motion(25, 0.0, 0.0, 45 * DEGREE))
    assert bool(own.doubt()) == doubted


@pytest.mark.parametrize('sign', [1.0, -1.0])
@pytest.mark.parametrize(('differ', 'refused'), [(0.019, False), (0.021, True)])
def test_at_the_start_counts_and_angle_may_differ_by_0_02_rad(sign, differ, refused):
    own = actuator(counts_per_turn=2**20)
    counts = round(2**20 * (0.5 + sign * differ) / (2 * math.pi))
    told(own, rmd_x.Angle(0.5), rmd_x.Encoder(counts))
    assert ('counts_per_turn' in own.check_position().problem) == refused


@pytest.mark.parametrize(('back_ms', 'restarts'), [(490, 0), (510, 1)])
def test_an_uptime_that_is_half_a_second_behind_is_a_restart(back_ms, restarts):
    own = actuator()
    own.accept(rmd_x.encode_reply(1, rmd_x.Uptime(10_000)), 0)
    own.accept(rmd_x.encode_reply(1, rmd_x.Uptime(11_000 - back_ms)), 1_000_000_000)
    assert own.restarts == restarts


@pytest.mark.parametrize('direction', [1, -1])
@pytest.mark.parametrize(('constant', 'most'), [(1.0, 6.0), (2.0, 4.0)])
def test_the_lower_of_current_limit_and_effort_limit_bounds_the_current(direction, constant, most):
    """6 A, and the URDF's 8 Nm at 2 Nm/A are 4 A; the effort's sign is the joint's."""
    own = at(actuator(torque_constant=constant, direction=direction), 0.0)
    for effort in (100.0, -100.0):
        for _ in range(30):
            current = sent(own.command(Setpoint(effort, 0.0, 0.0), 1))[0].current
        assert current == pytest.approx(math.copysign(most, direction * effort))


@pytest.mark.parametrize('direction', [1, -1])
def test_what_is_measured_is_in_the_joints_direction(direction):
    own = told(
        actuator(direction=direction), rmd_x.Motion(30, 2.0, 10 * DEGREE, 0.0), rmd_x.Angle(0.5)
    )
    measured = own.measurement
    assert measured.q == pytest.approx(direction * 0.5 + 0.3, abs=1e-4)
    assert measured.tau == pytest.approx(direction * 2.5)
    assert measured.speed == pytest.approx(direction * 10 * DEGREE)
    # As the motor itself says it.
    assert measured.current == pytest.approx(2.0)


def test_in_speed_mode_the_lower_limit_is_stopped_before_as_well():
    """From 0 with 1.7 rad left downward sqrt(2 5 1.7) = 4.1 rad/s would do: the limit is 3."""
    own = at(actuator(mode='speed', position_gain=10.0), -1.5)
    speed = sent(own.command(Setpoint(0.0, -5.0, 0.0), 1))[0].speed
    assert speed == pytest.approx(math.sqrt(2 * 5 * 0.2), abs=2e-3)
    own = at(actuator(mode='speed', position_gain=10.0), -1.75)
    assert sent(own.command(Setpoint(0.0, -5.0, 0.0), 1))[0].speed == 0.0
