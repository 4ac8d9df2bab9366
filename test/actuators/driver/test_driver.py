# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's core in lockstep with the emulated exoskeleton, judged by what the emulator saw."""

from __future__ import annotations

import math

import can
import numpy as np
import pytest
from lockstep_run import run_lockstep
from quiet_emulator import moving

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.servo.dbc import ServoFlag
from sosml_friction.actuators.servo.emulated import EmulatedServo
from sosml_friction.exceptions import ActuatorError, ConfigurationError, TrajectoryError
from sosml_friction.motion.trajectory import Trajectory

HANGING = np.array([-np.pi / 2, 0.0])


def drop(can_id):
    return lambda frame, replies: [] if frame.can_id == can_id else replies


# ---- before enable


def test_configure_only_asks(make_lockstep):
    """Version, model, status, uptime, angle of the motor, off to the servo: nothing else."""
    lockstep = make_lockstep()
    lockstep.driver.configure()
    sent = {(frame.can_id, frame.data[0]) for _, frame in lockstep.seen}
    motor = {(0x141, command) for command in (0xB2, 0xB5, 0x9A, 0xB1, 0x92)}
    assert sent == motor | {(0x170, 0)}
    assert lockstep.driver.state is DriverState.DISABLED


def test_nothing_moves_before_enable(make_lockstep):
    lockstep = make_lockstep()
    lockstep.driver.configure()
    lockstep.run(1.0)
    assert len(lockstep.currents()) == 500
    assert not lockstep.currents().any()
    assert lockstep.servo_modes() == {0}
    np.testing.assert_allclose(lockstep.emulator.q, HANGING, atol=1e-9)
    assert not lockstep.emulator.effort.any()


def test_a_trajectory_before_enable_is_refused_and_moves_nothing(lockstep, there_and_back):
    with pytest.raises(TrajectoryError, match='enable it before'):
        lockstep.driver.follow(there_and_back)
    lockstep.run(0.5)
    assert not lockstep.currents().any()


def test_what_is_measured_before_enable_is_published(lockstep):
    sample = lockstep.samples[-1]
    np.testing.assert_allclose(sample.q, HANGING, atol=2e-4)
    assert abs(sample.tau[0]) < 0.2
    assert np.isfinite(sample.v).all()


# ---- enabled


def test_enabling_holds_where_the_joints_are(lockstep):
    lockstep.driver.enable()
    lockstep.run(1.0)
    assert lockstep.driver.state is DriverState.ENABLED
    np.testing.assert_allclose(lockstep.emulator.q, HANGING, atol=1e-3)
    assert lockstep.servo_modes(len(lockstep.seen) - 30) == {1}


def test_a_trajectory_is_followed_and_its_end_is_held(lockstep, there_and_back):
    driver = lockstep.driver
    driver.enable()
    half = Trajectory(
        there_and_back.names,
        there_and_back.t[:2],
        there_and_back.q[:2],
        there_and_back.v[:2],
    )
    driver.follow(half)
    lockstep.run_while(lambda: driver.trajectory_running, 2.0)
    lockstep.run(0.5)
    # Friction over kp is 16 mrad at the shoulder, gravity over the servo's gain 10 at the elbow.
    np.testing.assert_allclose(lockstep.emulator.q, half.q[-1], atol=0.03)
    assert np.abs(lockstep.emulator.v).max() < 0.02


def test_stop_drops_the_trajectory_and_holds(lockstep, there_and_back):
    driver = lockstep.driver
    driver.enable()
    driver.follow(there_and_back)
    lockstep.run(0.5)
    here, v = lockstep.samples[-1].q, lockstep.samples[-1].v
    driver.stop()
    assert not driver.trajectory_running
    lockstep.run(1.0)
    # The faster joint stops in v / 5 seconds, and the other with it, at half speed on average.
    np.testing.assert_allclose(
        lockstep.emulator.q, here + 0.5 * v * np.abs(v).max() / 5.0, atol=0.04
    )
    assert np.abs(lockstep.emulator.v).max() < 0.02
    assert driver.state is DriverState.ENABLED


@pytest.mark.parametrize('speed', [1.0, -1.0])
def test_a_push_dies_out_with_the_shipped_gains(lockstep, speed):
    """Current and its rate saturate under a blow of 1 rad/s: the loop must not swing for it."""
    lockstep.driver.enable()
    lockstep.run(0.2)
    lockstep.emulator.plant.v[0] += speed
    lockstep.run(0.5)
    assert lockstep.driver.state is DriverState.ENABLED
    assert np.abs(lockstep.emulator.v).max() < 0.02
    np.testing.assert_allclose(lockstep.emulator.q, HANGING, atol=0.02)


def test_a_moving_joint_is_caught_with_bounded_deceleration(lockstep):
    lockstep.emulator.plant.v[0] = 1.0
    lockstep.run(0.05)
    lockstep.driver.enable()
    lockstep.run(1.0)
    assert lockstep.driver.state is DriverState.ENABLED
    assert np.abs(lockstep.emulator.v).max() < 0.02


def test_disable_lets_go_at_once(lockstep, there_and_back):
    driver = lockstep.driver
    driver.enable()
    driver.follow(there_and_back)
    lockstep.run(0.7)
    assert np.abs(lockstep.currents()).max() > 1.0
    since = len(lockstep.seen)
    driver.disable()
    lockstep.run(0.2)
    assert not lockstep.currents(since).any()
    assert lockstep.servo_modes(since) == {0}
    np.testing.assert_allclose(lockstep.emulator.effort, 0.0, atol=1e-9)


def test_no_current_above_its_limit_or_rate_is_ever_sent(make_lockstep, there_and_back):
    lockstep = make_lockstep(
        joint={
            'shoulder': {'current_limit': 1.5, 'current_rate_limit': 20.0, 'tracking_limit': 9.0}
        }
    )
    lockstep.driver.configure()
    lockstep.run(0.1)
    lockstep.driver.enable()
    lockstep.driver.follow(there_and_back)
    lockstep.run(1.0)
    currents = lockstep.currents()
    assert np.abs(currents).max() == pytest.approx(1.5)
    # 20 A/s at 500 Hz are 0.04 A a cycle; each end is rounded to 0.01 A.
    assert np.abs(np.diff(currents)).max() <= 0.04 + 0.0101


def test_the_urdfs_effort_limit_bounds_the_current_too(make_lockstep):
    lockstep = make_lockstep(
        joint={'shoulder': {'current_limit': 100.0, 'current_rate_limit': 1e6, 'kp': 1e5}}
    )
    lockstep.driver.configure()
    lockstep.run(0.1)
    lockstep.driver.enable()
    lockstep.run(0.02)
    lockstep.emulator.plant.q[0] += 0.05
    lockstep.run(0.01)
    assert np.abs(lockstep.currents()).max() == pytest.approx(8.0 / 1.25)


def test_the_servos_target_moves_no_faster_than_the_joint_may(make_lockstep):
    lockstep = make_lockstep(joint={'elbow': {'tracking_limit': 10.0}})
    driver = lockstep.driver
    driver.configure()
    lockstep.run(0.1)
    driver.enable()
    driver._motion.follower.hold(np.array([-np.pi / 2, 2.4]))
    lockstep.run(0.05)
    targets = np.array(
        [
            int.from_bytes(frame.data[2:4], 'little', signed=True) * 0.0002
            for _, frame in lockstep.seen
            if frame.can_id == 0x170 and frame.data[0] == 1
        ]
    )
    assert np.diff(targets).max() <= 3.0 / 500.0 + 2.1e-4
    assert targets[-1] > 0.1


@pytest.mark.parametrize(
    ('direction', 'zero_offset'), [(1, -np.pi / 2), (-1, -np.pi / 2), (-1, 0.3)]
)
def test_direction_and_zero_offset_are_invisible_at_the_joint(
    make_lockstep, there_and_back, direction, zero_offset
):
    """Turning an actuator round and shifting its zero changes frames, not the motion."""
    options = EmulatorOptions(
        rmd_current_noise=0.0, rmd_encoder_noise=0.0, servo_encoder_noise=0.0, latency_jitter=0.0
    )
    mounting = {'direction': direction, 'zero_offset': zero_offset}
    lockstep = make_lockstep(options=options, joint={'shoulder': mounting, 'elbow': mounting})
    lockstep.driver.configure()
    lockstep.run(0.1)
    lockstep.driver.enable()
    lockstep.driver.follow(there_and_back)
    lockstep.run(1.0)
    sample = lockstep.samples[-1]
    np.testing.assert_allclose(lockstep.emulator.q, HANGING + np.array([0.5, 0.8]), atol=0.03)
    np.testing.assert_allclose(sample.q, lockstep.emulator.q, atol=2e-3)
    # Holding against gravity takes positive effort at both joints, whichever way motors turn.
    assert (sample.tau > 0.5).all()
    np.testing.assert_allclose(sample.tau, lockstep.emulator.effort, atol=0.1)


# ---- what is measured


def test_published_values_are_multiples_of_the_wires_resolution(lockstep, there_and_back):
    lockstep.driver.enable()
    lockstep.driver.follow(there_and_back)
    lockstep.run(0.5)
    log = lockstep.log()
    counts = np.degrees(log.q[:, 0]) / 0.01
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    counts = log.q[:, 1] / 0.0002
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    counts = log.tau[:, 0] / (1.25 * 0.01)
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    counts = log.tau[:, 1] / 0.001
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert len(np.unique(log.q[:, 0])) > 100


def test_one_sample_per_cycle_stamped_when_it_was_asked_for(lockstep):
    lockstep.samples.clear()
    lockstep.run(1.0)
    log = lockstep.log()
    assert len(log) == 500
    steps = np.diff(log.t_ns)
    assert steps.mean() == pytest.approx(2e6, rel=1e-3)
    for sample in lockstep.samples:
        assert sample.stamp_ns == max(sample.joint_ns)


def test_the_skew_is_the_time_between_the_questions_to_the_joints(lockstep, monkeypatch):
    """Each question is 0.3 ms after the one before: the angle of the shoulder, then the elbow."""
    send, clock = lockstep.bus.send, lockstep.clock

    def slowly(*args, **kwargs):
        clock.sleep_until_ns(clock.now_ns() + 300_000)
        send(*args, **kwargs)

    monkeypatch.setattr(lockstep.bus, 'send', slowly)
    lockstep.run(0.01)
    shoulder, elbow = lockstep.samples[-1].joint_ns
    assert lockstep.samples[-1].skew_ns == elbow - shoulder == 300_000


def test_velocity_lags_by_ten_milliseconds_and_no_more(lockstep, there_and_back):
    """The slope of 11 positions at 500 Hz is the velocity of 10 ms ago."""
    truth = []
    lockstep.driver.enable()
    lockstep.driver.follow(there_and_back)
    while lockstep.driver.trajectory_running or not truth:
        sample = lockstep.step()
        truth.append((sample.stamp_ns, lockstep.emulator.v[0], sample.v[0]))
    t, v_true, v = np.array(truth).T
    t *= 1e-9

    def error(lag):
        return np.std(v - np.interp(t - lag, t, v_true))

    lags = np.arange(0.0, 0.02, 0.0005)
    best = lags[np.argmin([error(lag) for lag in lags])]
    assert best == pytest.approx(0.010, abs=0.001)
    assert error(0.010) < 0.01


def test_a_servo_without_current_sensor_has_no_effort(make_lockstep):
    lockstep = make_lockstep(options=EmulatorOptions(servo_current_available=False))
    lockstep.driver.configure()
    lockstep.run(0.1)
    lockstep.driver.enable()
    lockstep.run(0.1)
    sample = lockstep.samples[-1]
    assert math.isnan(sample.tau[1])
    assert np.isfinite(sample.q).all()
    assert math.isfinite(sample.tau[0])


def test_the_status_is_asked_ten_times_a_second(lockstep):
    since = len(lockstep.seen)
    lockstep.run(1.0)
    asked = sum(frame.data[0] == 0x9A for _, frame in lockstep.seen[since:])
    assert asked == 10
    report = lockstep.driver.report()
    assert report.joints[0].voltage == 48.0
    assert report.joints[0].firmware == '20220206'
    assert math.isnan(report.joints[1].temperature)


# ---- faults


def silent_motor(lockstep):
    lockstep.filter = drop(0x141)
    return 'joint shoulder: no answer from 0x241'


def silent_servo(lockstep):
    lockstep.filter = drop(0x170)
    return 'joint elbow: no answer from 0x171'


def error_flags(lockstep):
    lockstep.emulator.actuator('shoulder').errors = (
        rmd_x.ErrorFlag.STALL | rmd_x.ErrorFlag.OVER_CURRENT
    )
    return 'the motor reports stall, over_current'


def too_hot(lockstep):
    lockstep.emulator.actuator('shoulder').temperature = 76.0
    return '76 degC is above 75'


def servo_flag(lockstep):
    lockstep.emulator.actuator('elbow').status = ServoFlag.UNDER_VOLTAGE
    return 'the servo bridge reports under_voltage'


def out_of_limits(lockstep):
    lockstep.emulator.plant.q[0] = 0.85
    return 'joint shoulder is at 0.8'


def over_speed(lockstep):
    lockstep.emulator.plant.v[0] = 30.0
    return 'above 1.2 times its limit 3'


def nan_reference(lockstep):
    lockstep.driver._motion.follower.hold(np.array([math.nan, 0.0]))
    return 'not finite'


FAULTS = [
    silent_motor,
    silent_servo,
    error_flags,
    too_hot,
    servo_flag,
    out_of_limits,
    over_speed,
    nan_reference,
]


@pytest.mark.parametrize('inject', FAULTS)
def test_a_fault_while_moving_ends_in_zero_current_on_all_joints(lockstep, there_and_back, inject):
    """Within 110 ms, latched with its reason: the slowest is seen by the status every 100 ms."""
    moving(lockstep, there_and_back)
    sentence = inject(lockstep)
    lockstep.run(0.11)
    report = lockstep.driver.report()
    assert report.state is DriverState.FAULT
    assert sentence in report.reason
    since = len(lockstep.seen)
    lockstep.run(0.1)
    assert not lockstep.currents(since).any()
    assert lockstep.servo_modes(since) == {0}
    np.testing.assert_allclose(lockstep.emulator.effort, 0.0, atol=1e-6)
    assert lockstep.driver.state is DriverState.FAULT


def test_a_fault_is_cleared_by_enable_when_its_cause_is_gone(lockstep, there_and_back):
    moving(lockstep, there_and_back)
    silent_motor(lockstep)
    lockstep.run(0.11)
    with pytest.raises(ActuatorError, match='no answer from 0x241'):
        lockstep.driver.enable()
    lockstep.filter = lambda frame, replies: replies
    lockstep.run(0.1)
    assert lockstep.driver.state is DriverState.FAULT
    # The arm swings back without torque: enable when it hangs.
    lockstep.run(1.0)
    lockstep.driver.enable()
    lockstep.run(0.1)
    assert lockstep.driver.state is DriverState.ENABLED
    assert lockstep.driver.report().reason == ''


def test_a_few_missed_replies_are_counted_and_bridged(lockstep):
    lockstep.driver.enable()
    lockstep.run(0.1)
    before = len(lockstep.samples)
    lockstep.filter = drop(0x141)
    lockstep.run(0.02)
    lockstep.filter = lambda frame, replies: replies
    lockstep.run(0.1)
    report = lockstep.driver.report()
    assert report.state is DriverState.ENABLED
    # Each of the cycles without an answer waited 6 ms for it.
    assert report.incomplete_cycles == report.joints[0].missed == 4
    # The four waited for 24 ms; the 100 ms after them are whole.
    assert len(lockstep.samples) - before == 50


def test_stale_foreign_and_undecodable_frames_are_counted_and_never_taken(lockstep):
    """An angle nobody asked for now, a strange identifier, and a reply with too few bytes."""
    true = lockstep.samples[-1].q[0]
    lie = rmd_x.encode_reply(1, rmd_x.Angle(1.0))

    def noise(frame, replies):
        if frame.data[0] != 0xA1:
            return replies
        t = replies[0][0]
        return [
            (t - 2, Frame(0x123, b'\x01')),
            (t - 1, Frame(0x241, b'\x92\x00')),
            *replies,
            (t + 900_000, lie),
        ]

    missed = lockstep.driver.report().bus.missed
    lockstep.filter = noise
    lockstep.run(0.1)
    counters = lockstep.driver.report().bus
    assert counters.foreign == 50
    assert counters.undecodable == 50
    assert counters.stale >= 49
    assert counters.missed == missed
    assert abs(lockstep.samples[-1].q[0] - true) < 1e-3


def test_a_bus_that_fails_is_a_fault_with_its_reason(lockstep, there_and_back, monkeypatch):
    moving(lockstep, there_and_back)

    def broken(*_, **__):
        raise can.CanOperationError('adapter gone')

    monkeypatch.setattr(lockstep.bus, 'send', broken)
    assert lockstep.step() is None
    assert lockstep.driver.state is DriverState.FAULT
    assert 'adapter gone' in lockstep.driver.report().reason
    with pytest.raises(ActuatorError, match='adapter gone'):
        lockstep.driver.enable()


def test_the_motors_own_watchdog_stops_it_when_the_host_is_gone(lockstep, there_and_back):
    moving(lockstep, there_and_back)
    lockstep.emulator.advance(lockstep.clock.now_ns() + 100_000_000)
    np.testing.assert_allclose(lockstep.emulator.effort, 0.0, atol=1e-6)
    assert [actuator.watchdog_trips for actuator in lockstep.emulator.actuators] == [1, 1]


# ---- the end


def test_a_moving_driver_that_is_shut_down_sends_zero_current_then_shutdown(
    lockstep, there_and_back
):
    moving(lockstep, there_and_back)
    lockstep.seen.clear()
    lockstep.driver.shut_down()
    last = [(frame.can_id, frame.data[0]) for _, frame in lockstep.seen]
    assert last == [(0x141, 0xA1), (0x141, 0x80), (0x170, 0)]
    assert not lockstep.currents().any()
    assert lockstep.emulator.actuator('shoulder').shutdowns == 1


def test_shutting_down_tries_again_when_an_answer_is_lost(lockstep):
    lost = []

    def lose_first(frame, replies):
        if frame.data[0] == 0x80 and not lost:
            lost.append(frame)
            return []
        return replies

    lockstep.filter = lose_first
    lockstep.driver.shut_down()
    assert lockstep.emulator.actuator('shoulder').shutdowns == 2


def test_a_driver_that_never_cycled_sends_nothing_at_the_end(make_lockstep):
    lockstep = make_lockstep()
    lockstep.driver.configure()
    since = len(lockstep.seen)
    lockstep.driver.shut_down()
    assert len(lockstep.seen) == since


# ---- refusals at the start


def test_a_silent_actuator_is_refused(make_lockstep):
    lockstep = make_lockstep()
    lockstep.filter = drop(0x170)
    with pytest.raises(ActuatorError, match='joint elbow: no answer from 0x171'):
        lockstep.driver.configure()


def test_a_faulty_actuator_is_refused(make_lockstep):
    lockstep = make_lockstep()
    error_flags(lockstep)
    with pytest.raises(ActuatorError, match='stall, over_current'):
        lockstep.driver.configure()


def test_a_joint_outside_its_band_is_refused_with_by_how_much(make_lockstep):
    lockstep = make_lockstep(joint={'shoulder': {'lost_turns': 'refuse'}})
    lockstep.emulator.plant.q[0] += 2 * math.pi
    with pytest.raises(ActuatorError, match=r'joint shoulder is at 4\.71.*, 4\.01'):
        lockstep.driver.configure()


def test_a_step_before_configure_is_refused(make_lockstep):
    lockstep = make_lockstep()
    with pytest.raises(ActuatorError, match='configure it'):
        lockstep.driver.step()
    with pytest.raises(ActuatorError, match='not configured'):
        lockstep.driver.enable()


def test_enable_before_the_velocity_is_known_is_refused(make_lockstep):
    lockstep = make_lockstep()
    lockstep.driver.configure()
    with pytest.raises(ActuatorError, match='no velocity yet'):
        lockstep.driver.enable()


def test_a_cycle_that_cannot_fit_the_bit_rate_is_refused_with_the_arithmetic(make_lockstep):
    with pytest.raises(ConfigurationError, match=r'6\.044 frames per cycle at 500 Hz') as caught:
        make_lockstep(bitrate=250_000)
    assert 'lower rate or raise can_bitrate' in str(caught.value)


# ---- run_lockstep


def test_the_same_seed_gives_the_same_log_bit_for_bit(make_lockstep, there_and_back):
    logs = [run_lockstep(there_and_back, make_lockstep(seed=seed).emulator) for seed in (3, 3, 4)]
    for what in ('t_ns', 'q', 'v', 'tau'):
        np.testing.assert_array_equal(getattr(logs[0], what), getattr(logs[1], what))
    assert not np.array_equal(logs[0].tau, logs[2].tau)


def test_a_lockstep_run_has_every_sample_of_the_motion(make_lockstep, there_and_back):
    log = run_lockstep(there_and_back, make_lockstep().emulator)
    assert log.names == ('shoulder', 'elbow')
    assert np.isfinite(log.v).all()
    assert (np.diff(log.t_ns) > 0).all()
    assert len(log) == pytest.approx(500 * 2.1, abs=2)
    assert log.q[:, 0].max() == pytest.approx(-np.pi / 2 + 0.5, abs=0.03)


def test_the_trajectory_of_a_refused_run_is_named(make_lockstep, there_and_back):
    far = Trajectory(there_and_back.names, np.zeros(1), np.array([[0.0, 0.0]]))
    with pytest.raises(TrajectoryError, match='starts with joint shoulder'):
        run_lockstep(far, make_lockstep().emulator)


def test_the_emulated_servo_is_off_after_a_run(make_lockstep, there_and_back):
    emulator = make_lockstep().emulator
    run_lockstep(there_and_back, emulator)
    servo = emulator.actuator('elbow')
    assert isinstance(servo, EmulatedServo)
    assert servo.mode == 0
    assert servo.commanded_current == 0.0
