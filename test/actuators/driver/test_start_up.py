# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The start-up: pure steps, then an RMD-X's and a servo's on the emulated exoskeleton."""

from __future__ import annotations

import math

import pytest
from lockstep import nominal_robot

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.checks import make_actuators, run_start_ups
from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.driver.start_up import Check, Request, StartUp, Step
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.commands import Protocol
from sosml_friction.exceptions import ActuatorError

TURN = 2.0 * math.pi
ASK = Request(Frame(0x141, bytes(8)), 'key')


def step(name, problem='', **kwargs):
    return Step(
        name,
        lambda: [ASK],
        lambda: Check('j', name, 'found', problem),
        **kwargs,
    )


# ---- the walk


def test_steps_are_walked_in_order_and_each_is_checked_once():
    walk = StartUp('j', [step('a'), step('b')], 'silent')
    names = []
    while not walk.done:
        names.append(walk._steps[0].name)
        walk.take(set(), walk.requests())
    assert names == ['a', 'b']
    assert [check.step for check in walk.checks] == ['a', 'b']
    assert walk.problem == ''


def test_a_problem_ends_the_walk():
    walk = StartUp('j', [step('a', 'broken'), step('b')], 'silent')
    walk.take(set(), walk.requests())
    assert walk.done
    assert walk.problem == 'broken'
    assert walk.requests() == []


def test_an_answer_that_does_not_come_is_asked_for_three_times():
    walk = StartUp('j', [step('a')], 'silent')
    for _ in range(3):
        assert not walk.done
        walk.take({'key'}, walk.requests())
    assert walk.problem == 'silent'


def test_only_the_first_attempt_waits_for_the_pause():
    walk = StartUp('j', [step('a', pause_ns=5)], 'silent')
    assert walk.pause_ns == 5
    walk.take({'key'}, walk.requests())
    assert walk.pause_ns == 0


# ---- on the emulated exoskeleton


def start(lockstep, *, read_only=True):
    """Run the start-up as ``sosml can check`` does, and return its checks by joint and step."""
    driver = lockstep.driver
    cycle, clock = driver._bus.cycle, lockstep.clock
    actuators = make_actuators(driver.configuration, nominal_robot().limits)
    cycle._actuators = {own.reply_id: own for own in actuators}
    checks = run_start_ups(cycle, clock, actuators, read_only=read_only)
    return {(check.joint, check.step): check for check in checks}


READS = {(0x141, command) for command in (0xB2, 0xB5, 0x9A, 0xB1, 0x92)} | {(0x170, 0)}


def test_a_healthy_arm_passes_every_step_and_nothing_is_commanded(make_lockstep):
    lockstep = make_lockstep()
    checks = start(lockstep)
    assert [*checks] == [
        ('shoulder', 'version'),
        ('shoulder', 'model'),
        ('shoulder', 'status'),
        ('shoulder', 'position'),
        ('shoulder', 'watchdog'),
        ('elbow', 'status'),
        ('elbow', 'position'),
    ]
    assert not any(check.problem or check.warning for check in checks.values())
    assert 'firmware 20220206' in checks['shoulder', 'version'].result
    assert {(frame.can_id, frame.data[0]) for _, frame in lockstep.seen} == READS


@pytest.mark.parametrize(
    ('timeout', 'warns'), [(0.02, False), (0.05, False), (1.0, False), (0.0, True), (3.0, True)]
)
def test_a_motor_whose_watchdog_is_off_is_warned_of_without_writing_anything(
    make_lockstep, timeout, warns
):
    lockstep = make_lockstep(options=EmulatorOptions(comm_timeout=timeout))
    check = start(lockstep)['shoulder', 'watchdog']
    assert not check.problem
    assert bool(check.warning) is warns
    if warns:
        assert 'the motor keeps its last current' in check.warning
        assert 'motor_watchdog_ms' in check.warning
    assert {(frame.can_id, frame.data[0]) for _, frame in lockstep.seen} == READS


def writes(lockstep):
    return [frame.data for _, frame in lockstep.seen if frame.data[0] == 0xB3]


def test_the_motors_watchdog_is_written_only_when_asked_for_and_only_when_needed(make_lockstep):
    """It goes to the motor's ROM: one that trips in time already is left alone."""
    asked = {'shoulder': {'motor_watchdog_ms': 40}}
    off = EmulatorOptions(comm_timeout=0.0)
    lockstep = make_lockstep(options=off)
    assert start(lockstep, read_only=False)['shoulder', 'watchdog'].warning
    assert writes(lockstep) == []

    lockstep = make_lockstep(options=off, joint=asked)
    assert start(lockstep)['shoulder', 'watchdog'].warning
    assert writes(lockstep) == []
    check = start(lockstep, read_only=False)['shoulder', 'watchdog']
    assert (check.problem, check.warning) == ('', '')
    assert writes(lockstep) == [bytes.fromhex('B3 00 00 00 28 00 00 00')]
    start(lockstep, read_only=False)
    assert len(writes(lockstep)) == 1

    slow = make_lockstep(options=EmulatorOptions(comm_timeout=1.0), joint=asked)
    start(slow, read_only=False)
    assert len(writes(slow)) == 1


def test_a_motor_that_takes_the_time_but_does_not_trip_is_refused(make_lockstep):
    lockstep = make_lockstep(
        options=EmulatorOptions(comm_timeout=0.0), joint={'shoulder': {'motor_watchdog_ms': 40}}
    )
    echo = lockstep.filter

    def forget(frame, replies):
        if frame.can_id == 0x141 and frame.data[0] == 0xB3:
            lockstep.emulator.actuator('shoulder')._timeout_ns = 0
        return echo(frame, replies)

    lockstep.filter = forget
    check = start(lockstep, read_only=False)['shoulder', 'watchdog']
    assert 'motor_watchdog_ms had no effect' in check.problem


@pytest.mark.parametrize('k', [-2, -1, 1, 3])
def test_whole_turns_the_encoder_lost_are_put_right(make_lockstep, k):
    """A dual-encoder motor comes back by whole turns of the output: the shipped configuration."""
    lockstep = make_lockstep()
    lockstep.emulator.plant.q[0] += k * TURN
    lockstep.driver.configure()
    (check,) = [c for c in lockstep.driver.checks if (c.joint, c.step) == ('shoulder', 'position')]
    assert f'had lost {k:+d} turns' in check.warning
    lockstep.run(0.1)
    assert lockstep.samples[-1].q[0] == pytest.approx(-math.pi / 2, abs=1e-3)
    lockstep.driver.enable()
    lockstep.run(0.3)
    assert lockstep.driver.report().reason == ''
    assert lockstep.emulator.q[0] == pytest.approx(-math.pi / 2 + k * TURN, abs=2e-3)


def test_motor_turns_are_put_right_only_where_one_number_of_them_fits(make_lockstep):
    """At 1:8 a turn of the motor is 45 degrees, and the shoulder's band holds several."""
    motor = {'shoulder': {'lost_turns': 'motor', 'gear_ratio': 8.0}}
    lockstep = make_lockstep(joint=motor)
    lockstep.emulator.plant.q[0] += 3.0
    check = start(lockstep)['shoulder', 'position']
    assert 'numbers of turns of 0.7854 would bring it inside' in check.problem
    # At 1:1.8 it is 200 degrees, wider than the band.
    lockstep = make_lockstep(joint={'shoulder': {'lost_turns': 'motor', 'gear_ratio': 1.8}})
    lockstep.emulator.plant.q[0] += TURN / 1.8
    check = start(lockstep)['shoulder', 'position']
    assert (check.problem, '+1 turns' in check.warning) == ('', True)


def test_an_angle_no_whole_turn_explains_is_refused_with_by_how_much(make_lockstep):
    lockstep = make_lockstep()
    lockstep.emulator.plant.q[0] = 0.7854 + 0.6
    with pytest.raises(ActuatorError, match=r'joint shoulder is at 1\.3854, 0\.\d+ outside') as no:
        lockstep.driver.configure()
    assert 'no whole number of turns' in str(no.value)
    assert lockstep.driver.state is DriverState.UNCONFIGURED


def test_counts_per_turn_that_do_not_fit_the_angle_are_refused(make_lockstep):
    """A velocity wrong by a factor would be worse than a coarse one."""
    for counts, fits in ((2**20, True), (2**17, False)):
        lockstep = make_lockstep(
            options=EmulatorOptions(rmd_encoder_counts=2**20),
            joint={'shoulder': {'counts_per_turn': counts}},
        )
        lockstep.emulator.plant.q[0] += 0.5
        problem = start(lockstep)['shoulder', 'position'].problem
        assert ('correct shoulder.counts_per_turn' in problem) is not fits
        assert bool(problem) is not fits


def test_without_being_told_no_turn_is_corrected(make_lockstep):
    lockstep = make_lockstep(joint={'shoulder': {'lost_turns': 'refuse'}})
    lockstep.emulator.plant.q[0] += TURN
    with pytest.raises(ActuatorError, match='outside its limits'):
        lockstep.driver.configure()


def test_a_lost_first_answer_is_asked_for_again(make_lockstep):
    lockstep = make_lockstep()
    lost = set()

    def lose_first(frame, replies):
        if frame.data[0] in lost:
            return replies
        lost.add(frame.data[0])
        return []

    lockstep.filter = lose_first
    checks = start(lockstep)
    assert len(lost) == 6
    assert not any(check.problem for check in checks.values())


def test_a_version_that_is_no_date_is_refused(make_lockstep):
    """The layouts depend on it."""
    lockstep = make_lockstep()

    def other(frame, replies):
        if frame.data[0] == 0xB2:
            return [(t, rmd_x.encode_reply(1, rmd_x.Version(7))) for t, _ in replies]
        return replies

    lockstep.filter = other
    assert 'is no date' in start(lockstep)['shoulder', 'version'].problem


def test_the_model_of_a_v4_4_motor_comes_in_blocks(make_lockstep):
    lockstep = make_lockstep()
    text = 'X6-P20-60-E'

    def v4_4(frame, replies):
        if frame.data[0] == 0xB2:
            reply = rmd_x.Version(2026042402)
        elif frame.data[0] == 0xB5:
            block = frame.data[2]
            assert frame.data[1] == 1
            reply = rmd_x.ModelBlock(block, text[5 * (block - 1) : 5 * block])
        else:
            return replies
        t = replies[0][0] if replies else lockstep.clock.now_ns() + 300_000
        return [(t, rmd_x.encode_reply(1, reply, Protocol.V4_4))]

    lockstep.filter = v4_4
    checks = start(lockstep)
    assert checks['shoulder', 'model'].result == text
    assert 'V4.4' in checks['shoulder', 'version'].result


def test_a_motor_that_does_not_tell_its_model_is_warned_of_and_taken(make_lockstep):
    lockstep = make_lockstep()
    lockstep.filter = lambda frame, replies: [] if frame.data[0] == 0xB5 else replies
    check = start(lockstep)['shoulder', 'model']
    assert (check.problem, 'does not tell its model' in check.warning) == ('', True)


def test_an_elbow_without_current_is_told_at_the_start(make_lockstep):
    lockstep = make_lockstep(options=EmulatorOptions(servo_current_available=False))
    check = start(lockstep)['elbow', 'status']
    assert 'friction of this joint, is not available' in check.warning
