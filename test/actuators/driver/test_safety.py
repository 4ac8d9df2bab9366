# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ends in zero current on the wire besides the emulator's faults, and how it comes back."""

from __future__ import annotations

import errno
import math
import os
from dataclasses import replace

import can
import numpy as np
import pytest
from lockstep import nominal_robot
from lockstep_bus import LockstepBus
from quiet_emulator import moving

from sosml_friction.actuators.driver.driver import JointDriver
from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.exceptions import ActuatorError, ConfigurationError, TrajectoryError


def assert_zero_from_the_next_cycle_on(lockstep):
    lockstep.step()
    since = len(lockstep.seen)
    lockstep.run(0.1)
    assert len(lockstep.currents(since)) > 3
    assert not lockstep.currents(since).any()
    assert lockstep.servo_modes(since) == {0}
    assert lockstep.driver.state is DriverState.FAULT


# ---- the host


def test_callbacks_that_hang_end_the_torque(lockstep, there_and_back):
    """Nothing is demanded of a host that never spoke; of one that did, a word every second."""
    driver = lockstep.driver
    driver.heartbeat()
    moving(lockstep, there_and_back)
    driver.heartbeat()
    lockstep.run(0.9)
    assert driver.state is DriverState.ENABLED
    lockstep.run(0.15)
    assert driver.state is DriverState.FAULT
    assert 'one of its callbacks hangs' in driver.report().reason
    assert_zero_from_the_next_cycle_on(lockstep)
    driver.heartbeat()
    lockstep.run(1.0)
    driver.heartbeat()
    driver.enable()
    lockstep.run(0.1)
    assert driver.state is DriverState.ENABLED


def test_a_fault_of_the_program_is_latched_until_it_is_configured_anew(lockstep, there_and_back):
    driver = lockstep.driver
    moving(lockstep, there_and_back)
    driver.fault('samples cannot be published')
    assert_zero_from_the_next_cycle_on(lockstep)
    assert driver.report().reason == 'samples cannot be published'
    lockstep.run(1.5)
    with pytest.raises(ActuatorError, match='cannot be published'):
        driver.enable()
    driver.shut_down()
    driver.configure()
    lockstep.run(0.1)
    driver.enable()
    assert driver.state is DriverState.ENABLED


# ---- the motion


def test_a_joint_that_is_pushed_off_its_reference_is_let_go(make_lockstep):
    lockstep = make_lockstep(joint={'shoulder': {'tracking_limit': 0.05}})
    lockstep.driver.configure()
    lockstep.run(0.1)
    lockstep.driver.enable()
    lockstep.run(0.1)
    lockstep.emulator.plant.q[0] += 0.06
    lockstep.step()
    lockstep.step()
    report = lockstep.driver.report()
    assert report.state is DriverState.FAULT
    assert 'further than tracking_limit 0.05' in report.reason
    assert_zero_from_the_next_cycle_on(lockstep)


def test_a_joint_that_does_not_move_with_its_reference_is_let_go(lockstep, there_and_back):
    """A closed brake: long before the tracking limit, and before the torque has built up."""
    driver, plant = lockstep.driver, lockstep.emulator.plant
    driver.enable()
    driver.follow(there_and_back)
    held = plant.q.copy()
    while driver.state is DriverState.ENABLED and lockstep.clock.now_ns() < 2_000_000_000:
        lockstep.step()
        plant.q[:], plant.v[:] = held, 0.0
    reason = driver.report().reason
    assert 'it is blocked, its brake is closed or its encoder is stuck' in reason
    assert abs(driver.report().joints[0].q - held[0]) < 1e-3
    assert_zero_from_the_next_cycle_on(lockstep)


def test_beyond_its_limit_a_joint_gets_no_torque_outward(make_lockstep):
    """Pushed over the limit while it holds there: the current outward fades on the way."""
    lockstep = make_lockstep(joint={'shoulder': {'tracking_limit': 1.0}})
    upper = lockstep.driver._actuators[0].limits.upper
    lockstep.emulator.plant.q[0] = upper
    lockstep.driver.configure()
    # The arm falls: enable at once, as soon as the velocity is known.
    lockstep.run(0.03)
    lockstep.emulator.plant.q[0], lockstep.emulator.plant.v[0] = upper, 0.0
    lockstep.run(0.03)
    lockstep.driver.enable()
    most = []
    for beyond in np.arange(0.0, 0.09, 0.001):
        lockstep.emulator.plant.q[0], lockstep.emulator.plant.v[0] = upper + beyond, 0.0
        lockstep.step()
        most.append((1.0 - (beyond - 0.001) / 0.1) * 8.0 / 1.25)
    assert lockstep.driver.report().reason == ''
    currents = lockstep.currents()[-len(most) :]
    # The fade is of the position measured a cycle before, whose noise is 0.2 mrad, and rounded.
    assert (currents <= np.array(most) + 0.02).all()
    # It has pushed the arm up against gravity first, and in the end it presses it back.
    assert currents.max() > 1.0
    assert currents[-1] < 0.0


def test_speed_by_the_motor_that_does_not_fit_its_position_is_a_fault(lockstep, there_and_back):
    """A position that stands still while the motor says it moves: its encoder is stuck."""
    lockstep.driver.enable()
    lockstep.run(0.1)

    def lie(frame, replies):
        if frame.data[0] != 0xA1 or frame.can_id != 0x141:
            return replies
        lied = rmd_x.encode_reply(1, rmd_x.Motion(25, 0.1, 1.0, 0.0))
        return [(t, lied) for t, _ in replies]

    lockstep.filter = lie
    lockstep.run(0.06)
    assert 'its position says' in lockstep.driver.report().reason
    assert_zero_from_the_next_cycle_on(lockstep)


def test_a_measured_current_far_above_its_limit_is_a_fault(lockstep):
    lockstep.driver.enable()
    lockstep.run(0.1)

    def lie(frame, replies):
        if frame.data[0] != 0xA1 or frame.can_id != 0x141:
            return replies
        lied = rmd_x.encode_reply(1, rmd_x.Motion(25, -11.0, 0.0, 0.0))
        return [(t, lied) for t, _ in replies]

    lockstep.filter = lie
    lockstep.run(0.06)
    assert 'reports -11.00 A' in lockstep.driver.report().reason
    assert_zero_from_the_next_cycle_on(lockstep)


def test_a_trajectory_waits_for_the_brake(make_lockstep, there_and_back):
    lockstep = make_lockstep(joint={'shoulder': {'brake': True}})
    lockstep.driver.configure()
    lockstep.run(0.1)
    answers = []

    def late_brake(frame, replies):
        if frame.can_id == 0x141 and frame.data[0] == 0x77:
            answers.append((lockstep.clock.now_ns() + 120_000_000, frame))
            return [
                (answers[0][0], rmd_x.encode_reply(1, rmd_x.ReleaseBrake())),
            ]
        return replies

    lockstep.filter = late_brake
    lockstep.driver.enable()
    lockstep.run(0.05)
    with pytest.raises(TrajectoryError, match='brake of joint shoulder is opening'):
        lockstep.driver.follow(there_and_back)
    lockstep.run(0.1)
    lockstep.driver.follow(there_and_back)
    lockstep.run(0.2)
    assert lockstep.driver.report().reason == ''
    assert len(answers) == 1


def test_a_restart_while_driven_is_a_fault_and_the_joint_is_asked_anew(lockstep, there_and_back):
    moving(lockstep, there_and_back)
    since = len(lockstep.seen)

    def restarted(frame, replies):
        if frame.can_id == 0x141 and frame.data[0] == 0xB1:
            return [(t, rmd_x.encode_reply(1, rmd_x.Uptime(1))) for t, _ in replies]
        return replies

    # By now its uptime is above a second: it is asked once a second.
    lockstep.run(0.3)
    lockstep.filter = restarted
    lockstep.run(1.1)
    assert 'switched on anew' in lockstep.driver.report().reason
    asked = {frame.data[0] for _, frame in lockstep.seen[since:] if frame.can_id == 0x141}
    assert {0xB2, 0x92, 0x9A} <= asked
    assert_zero_from_the_next_cycle_on(lockstep)


# ---- the bus


class Lost:
    """A bus whose adapter is gone until :attr:`back`; notes what was sent before that."""

    def __init__(self, lockstep):
        self.lockstep, self.back, self.opened = lockstep, False, 0

    def lose(self, monkeypatch):
        def gone(*_, **__):
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))

        monkeypatch.setattr(self.lockstep.bus, 'send', gone)
        monkeypatch.setattr(self.lockstep.bus, 'recv', gone)
        self.lockstep.driver._bus.cycle._reopen = self.open

    def open(self):
        if not self.back:
            raise ActuatorError('no such device')
        self.opened += 1
        return LockstepBus(self.lockstep.emulator, self.lockstep.clock)


def test_a_lost_adapter_is_opened_again_and_no_old_command_follows(
    lockstep, there_and_back, monkeypatch
):
    moving(lockstep, there_and_back)
    lost = Lost(lockstep)
    lost.lose(monkeypatch)
    since = len(lockstep.seen)
    cycles = lockstep.driver.report().cycles
    lockstep.run(0.5)
    report = lockstep.driver.report()
    assert report.state is DriverState.FAULT
    assert 'No such device' in report.reason
    # Every cycle is counted, also those in which nothing could be asked.
    assert report.cycles - cycles == 250
    assert len(lockstep.seen) == since
    lost.back = True
    lockstep.run(1.5)
    assert lost.opened == 1
    first = [(frame.can_id, frame.data[0]) for _, frame in lockstep.seen[since : since + 2]]
    assert first == [(0x141, 0x9A), (0x170, 0)]
    assert not lockstep.currents(since).any()
    assert lockstep.driver.state is DriverState.FAULT
    lockstep.driver.enable()
    lockstep.run(0.1)
    assert lockstep.driver.state is DriverState.ENABLED
    lockstep.driver.bus.shutdown()


def test_a_lost_bus_is_tried_again_ten_times_a_second(lockstep, monkeypatch):
    tried = []

    def gone():
        tried.append(lockstep.clock.now_ns())
        raise ActuatorError('no such device')

    Lost(lockstep).lose(monkeypatch)
    monkeypatch.setattr(lockstep.driver._bus.cycle, '_reopen', gone)
    lockstep.run(1.01)
    assert 9 <= len(tried) <= 10
    assert np.diff(tried) == pytest.approx(1e8, abs=3e6)


def test_without_a_way_to_open_it_the_same_bus_is_tried_again(
    lockstep, there_and_back, monkeypatch
):
    moving(lockstep, there_and_back)
    with monkeypatch.context() as patch:

        def broken(*_, **__):
            raise can.CanOperationError('adapter gone')

        patch.setattr(lockstep.bus, 'send', broken)
        lockstep.run(0.2)
        assert 'adapter gone' in lockstep.driver.report().reason
    lockstep.run(1.5)
    lockstep.driver.enable()
    assert lockstep.driver.state is DriverState.ENABLED


def test_a_silent_bus_gets_no_second_command(lockstep, there_and_back):
    """With nobody to acknowledge, frames wait in the controller and burst out on power-up."""
    moving(lockstep, there_and_back)
    lockstep.filter = lambda frame, replies: []
    since = len(lockstep.seen)
    lockstep.run(0.2)
    assert lockstep.driver.state is DriverState.FAULT
    commanded = lockstep.currents(since)
    assert np.count_nonzero(commanded) == 1
    assert commanded[0] != 0.0


def test_answers_that_come_late_for_good_are_a_fault(lockstep, there_and_back):
    """Without numbers a reply that takes 15 of the 20 ms could be the one of the cycle before."""
    moving(lockstep, there_and_back)
    lockstep.filter = lambda frame, replies: [(t + 15_000_000, reply) for t, reply in replies]
    lockstep.run(0.12)
    assert 'no timely answer' in lockstep.driver.report().reason
    assert_zero_from_the_next_cycle_on(lockstep)


def test_a_motor_that_timed_out_while_driven_is_a_fault(make_lockstep, there_and_back):
    lockstep = make_lockstep(options=EmulatorOptions(comm_timeout=0.05))
    lockstep.driver.configure()
    lockstep.run(0.1)
    moving(lockstep, there_and_back)
    # The host stalls for 60 ms.
    lockstep.clock.sleep_until_ns(lockstep.clock.now_ns() + 60_000_000)
    lockstep.run(0.01)
    assert "the motor's own watchdog switched it off" in lockstep.driver.report().reason
    assert_zero_from_the_next_cycle_on(lockstep)


@pytest.mark.parametrize('late_ms', [7, 13])
def test_answers_later_than_the_wait_cannot_pass_for_the_next_ones(
    lockstep, there_and_back, late_ms
):
    """
    A reply to the cycle before looks timely; only the status, asked seldom, tells them apart.

    The shoulder alone, as the servo's bridge numbers its replies.
    """

    def late(frame, replies):
        own = frame.can_id == 0x141
        return [(t + late_ms * 1_000_000 * own, reply) for t, reply in replies]

    moving(lockstep, there_and_back)
    lockstep.filter = late
    lockstep.run(0.65)
    assert lockstep.driver.state is DriverState.FAULT
    lockstep.filter = lambda frame, replies: replies
    assert_zero_from_the_next_cycle_on(lockstep)


def test_a_host_that_slept_does_not_catch_up(lockstep, there_and_back):
    """The reference has gone on meanwhile: no current follows it."""
    moving(lockstep, there_and_back)
    lockstep.clock.sleep_until_ns(lockstep.clock.now_ns() + 100_000_000)
    since = len(lockstep.seen)
    lockstep.run(0.1)
    assert not lockstep.currents(since).any()
    assert lockstep.servo_modes(since) == {0}
    assert 'the cycle stood still for 1' in lockstep.driver.report().reason
    lockstep.run(1.0)
    lockstep.driver.enable()
    lockstep.run(0.1)
    assert lockstep.driver.report().reason == ''


def test_commands_of_another_program_are_a_fault(lockstep, there_and_back):
    driver, bus = lockstep.driver, lockstep.bus
    moving(lockstep, there_and_back)
    own = lockstep.seen[-2][1]
    bus._push(lockstep.clock.now_ns(), own)
    lockstep.run(0.01)
    # What it sent itself it may hear, as on udp_multicast.
    assert driver.state is DriverState.ENABLED
    bus._push(lockstep.clock.now_ns(), rmd_x.encode_request(1, rmd_x.SetCurrent(1.23)))
    lockstep.run(0.01)
    assert 'another program commands' in driver.report().reason
    assert_zero_from_the_next_cycle_on(lockstep)
    with pytest.raises(ActuatorError, match='another program'):
        driver.enable()
    lockstep.run(2.0)
    driver.enable()
    assert driver.report().bus.intruders == 1


def test_a_drive_begins_without_the_velocity_of_the_one_before(lockstep, there_and_back):
    """An old velocity would be braked from: motion that nobody asked for."""
    driver = lockstep.driver
    moving(lockstep, there_and_back)
    driver.shut_down()
    driver.configure()
    with pytest.raises(ActuatorError, match='has no velocity yet'):
        driver.enable()


@pytest.mark.parametrize(
    ('limits', 'words'),
    [
        ({'velocity': math.nan}, 'velocity limit nan'),
        ({'effort': math.inf}, 'effort limit inf'),
        ({'upper': math.nan}, 'to nan'),
        ({'lower': 9.0}, '9 to'),
    ],
)
def test_limits_that_limit_nothing_are_refused(make_lockstep, limits, words):
    """Every comparison with NaN is false: such a limit would never be exceeded."""
    lockstep = make_lockstep()
    robot = nominal_robot()
    robot.limits = (replace(robot.limits[0], **limits), *robot.limits[1:])
    with pytest.raises(ConfigurationError, match=words):
        JointDriver(lockstep.driver.configuration, robot, lockstep.bus, lockstep.clock)


def test_a_motor_that_is_heard_again_is_let_go_before_it_is_asked_anything(
    make_lockstep, there_and_back, monkeypatch
):
    """Without a watchdog it still has its last current, and the elbow keeps the start-up busy."""
    lockstep = make_lockstep(options=EmulatorOptions(comm_timeout=0.0))
    lockstep.driver.configure()
    lockstep.run(0.1)
    moving(lockstep, there_and_back)
    lost = Lost(lockstep)
    lost.lose(monkeypatch)
    lockstep.run(0.1)
    since = len(lockstep.seen)
    lost.back = True
    lockstep.filter = lambda frame, replies: [] if frame.can_id == 0x170 else replies
    before_ns = lockstep.clock.now_ns()
    lockstep.run(1.0)
    seen = [(t, frame.data[0]) for t, frame in lockstep.seen[since:] if frame.can_id == 0x141]
    assert [command for _, command in seen[:2]] == [0x9A, 0xA1]
    assert not lockstep.currents(since).any()
    assert seen[1][0] - before_ns < 150_000_000
    lockstep.driver.bus.shutdown()


@pytest.mark.parametrize('error', [OSError(errno.ENODEV, 'gone'), TypeError('port is closed')])
def test_at_the_end_a_lost_bus_is_opened_again_for_the_last_word(
    lockstep, there_and_back, monkeypatch, error
):
    """Also where python-can fails in a way of its own."""
    moving(lockstep, there_and_back)
    lost = Lost(lockstep)
    lost.lose(monkeypatch)
    lost.back = True

    def gone(*_, **__):
        raise error

    monkeypatch.setattr(lockstep.bus, 'send', gone)
    monkeypatch.setattr(lockstep.bus, 'recv', gone)
    since = len(lockstep.seen)
    lockstep.driver.shut_down()
    commands = [frame.data[0] for _, frame in lockstep.seen[since:] if frame.can_id == 0x141]
    assert commands[:2] == [0xA1, 0x80]
    assert not lockstep.currents(since).any()
    lockstep.driver.bus.shutdown()


def test_the_report_has_what_diagnostics_need(lockstep):
    joint = lockstep.driver.report().joints[0]
    assert joint.model
    assert 0.0 < joint.latency < 0.002
    assert math.isnan(joint.tracking_error)
    assert joint.uptime > 0.0
    lockstep.driver.enable()
    lockstep.run(0.01)
    assert abs(lockstep.driver.report().joints[0].tracking_error) < 0.01
