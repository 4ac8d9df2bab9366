# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The emulated hardware: physics, quantisation, latency, watchdogs, determinism."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from lockstep import default_configuration, emulated_exoskeleton
from quiet_emulator import DBC, MS, QUIET

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.emulator.emulated_actuator import CURRENT_LOOP
from sosml_friction.actuators.emulator.emulator import (
    STEP_NS,
    ExoskeletonEmulator,
    hanging_position,
)
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.servo.dbc import Mode, ServoCommand, ServoFlag
from sosml_friction.model.model_folder import read_model
from sosml_friction.share import share_directory

NO_TIMEOUT = QUIET.changed(comm_timeout=0.0)


def ask(emulator, request, t_ns):
    ((t_reply, frame),) = emulator.handle(rmd_x.encode_request(1, request), t_ns)
    return t_reply, rmd_x.decode_reply(frame)[1]


def command(emulator, t_ns, mode, target=0.0, sequence=1):
    ((_, frame),) = emulator.handle(DBC.encode_command(ServoCommand(mode, sequence, target)), t_ns)
    return DBC.decode_state(frame)


def test_the_arm_hangs_at_rest_until_something_drives_it():
    emulator = emulated_exoskeleton(options=QUIET)
    emulator.advance(2000 * MS)
    np.testing.assert_allclose(emulator.q, [-math.pi / 2, 0.0], atol=1e-12)


def test_the_effort_on_the_plant_is_torque_constant_times_current():
    emulator = emulated_exoskeleton(options=QUIET)
    for k in range(20):
        ask(emulator, rmd_x.SetCurrent(2.0), k * MS)
    assert emulator.effort[0] == pytest.approx(1.25 * 2.0, rel=1e-6)
    assert emulator.effort[1] == 0.0
    assert emulator.v[0] > 0.0


def test_the_current_follows_with_its_first_order_lag():
    emulator = emulated_exoskeleton(options=QUIET)
    ask(emulator, rmd_x.SetCurrent(1.0), 0)
    emulator.advance(MS)
    share = 1.0 - math.exp(-1e-3 / CURRENT_LOOP)
    assert emulator.actuator('shoulder').current == pytest.approx(share, rel=1e-9)


def test_the_motor_clamps_to_its_own_limit():
    emulator = emulated_exoskeleton(options=QUIET)
    ask(emulator, rmd_x.SetCurrent(100.0), 0)
    assert emulator.actuator('shoulder').commanded_current == 7.2


def test_the_angle_is_rounded_to_hundredths_of_a_degree():
    emulator = emulated_exoskeleton(options=QUIET)
    for degrees, counts in ((0.0149, 1), (0.0151, 2), (-0.0151, -2)):
        emulator.plant.q[0] = -math.pi / 2 + math.radians(degrees)
        (reply,) = emulator.handle(rmd_x.encode_request(1, rmd_x.ReadAngle()), 0)
        assert int.from_bytes(reply[1].data[4:8], 'little', signed=True) == counts


def test_the_reported_current_is_the_actual_one_with_noise_and_rounding():
    emulator = emulated_exoskeleton(options=EmulatorOptions(rmd_current_noise=0.03))
    current = []
    for k in range(3000):
        _, reply = ask(emulator, rmd_x.SetCurrent(0.2), k * MS)
        current.append(reply.current)
    current = np.array(current[20:])
    np.testing.assert_allclose(current * 100, np.round(current * 100), atol=1e-9)
    assert current.mean() == pytest.approx(0.2, abs=0.003)
    assert current.std() == pytest.approx(math.hypot(0.03, 0.01 / math.sqrt(12)), rel=0.06)


def test_replies_come_after_their_latency_and_in_order():
    emulator = emulated_exoskeleton(options=EmulatorOptions(latency=3e-4, latency_jitter=5e-5))
    latency, last = [], 0
    for k in range(500):
        t = k * 2 * MS
        for request in (rmd_x.SetCurrent(0.0), rmd_x.ReadAngle()):
            t_reply, _ = ask(emulator, request, t)
            assert t_reply >= max(t + 300_000, last + 130_000)
            last = t_reply
        latency.append(last - t)
    assert np.mean(latency) < 700_000


def test_the_motor_turns_off_when_frames_stop_coming():
    emulator = emulated_exoskeleton(options=QUIET)
    ask(emulator, rmd_x.SetCurrent(1.0), 0)
    emulator.advance(49 * MS)
    assert emulator.effort[0] == pytest.approx(1.25)
    emulator.advance(65 * MS)
    assert abs(emulator.effort[0]) < 1e-4
    assert emulator.actuator('shoulder').watchdog_trips == 1


def test_without_a_timeout_the_last_command_runs_on():
    emulator = emulated_exoskeleton(
        options=EmulatorOptions(comm_timeout=0.0, rmd_current_noise=0.0)
    )
    ask(emulator, rmd_x.SetCurrent(0.5), 0)
    emulator.advance(1000 * MS)
    assert emulator.effort[0] == pytest.approx(0.625)


def test_shutdown_is_echoed_and_ends_the_torque():
    emulator = emulated_exoskeleton(options=QUIET)
    ask(emulator, rmd_x.SetCurrent(1.0), 0)
    assert ask(emulator, rmd_x.Shutdown(), 5 * MS)[1] == rmd_x.Shutdown()
    emulator.advance(20 * MS)
    assert abs(emulator.effort[0]) < 1e-4


def test_stop_is_echoed_and_the_motor_holds_by_itself():
    emulator = emulated_exoskeleton(options=NO_TIMEOUT)
    ask(emulator, rmd_x.SetCurrent(3.0), 0)
    emulator.advance(50 * MS)
    assert emulator.v[0] > 0.1
    assert ask(emulator, rmd_x.Stop(), 50 * MS)[1] == rmd_x.Stop()
    emulator.advance(1000 * MS)
    assert abs(emulator.v[0]) < 0.01
    # Up against gravity: that takes torque.
    assert emulator.q[0] > -math.pi / 2 + 0.005
    assert emulator.effort[0] > 0.01


def test_the_motors_speed_loop_follows_a_speed():
    emulator = emulated_exoskeleton(options=NO_TIMEOUT)
    _, reply = ask(emulator, rmd_x.SetSpeed(0.5), 0)
    assert isinstance(reply, rmd_x.Motion)
    assert reply.of == rmd_x.Command.SPEED
    emulator.advance(1000 * MS)
    # Gravity grows by some 5 Nm/rad: at 0.5 rad/s over 225 Nm/rad of integral that is 0.01 rad/s,
    # and friction's falling side as much again.
    assert emulator.v[0] == pytest.approx(0.5, abs=0.04)


def test_the_motors_position_loop_goes_to_an_angle_no_faster_than_told():
    emulator = emulated_exoskeleton(options=NO_TIMEOUT)
    ask(emulator, rmd_x.SetPosition(math.radians(30.0), math.radians(40.0)), 0)
    fastest = 0.0
    for k in range(2000):
        emulator.advance(k * MS)
        fastest = max(fastest, float(emulator.v[0]))
    assert emulator.q[0] == pytest.approx(-math.pi / 2 + math.radians(30.0), abs=0.01)
    assert fastest <= 1.1 * math.radians(40.0)


def test_a_motor_that_timed_out_says_so_every_second_and_echoes_one_request():
    emulator = emulated_exoskeleton(options=QUIET)
    ask(emulator, rmd_x.SetCurrent(0.5), 0)
    emulator.advance(2100 * MS)
    said = emulator.take_sent()
    assert [frame.data[0] for _, frame in said] == [0xF1, 0xF1, 0xF1]
    assert said[0][0] == pytest.approx(50 * MS, abs=MS)
    request = rmd_x.encode_request(1, rmd_x.SetCurrent(1.0))
    ((_, echo),) = emulator.handle(request, 2100 * MS)
    assert echo == Frame(0x241, request.data)
    assert emulator.actuator('shoulder').commanded_current == 0.0
    ask(emulator, rmd_x.SetCurrent(1.0), 2101 * MS)
    assert emulator.actuator('shoulder').commanded_current == 1.0


def test_a_reset_motor_is_dark_for_a_while_and_counts_its_uptime_anew():
    emulator = emulated_exoskeleton(options=NO_TIMEOUT)
    ask(emulator, rmd_x.SetCurrent(1.0), 500 * MS)
    assert ask(emulator, rmd_x.ReadUptime(), 500 * MS)[1].milliseconds == 500
    assert emulator.handle(rmd_x.encode_request(1, rmd_x.Reset()), 600 * MS) == []
    assert emulator.handle(rmd_x.encode_request(1, rmd_x.ReadUptime()), 1000 * MS) == []
    assert emulator.actuator('shoulder').commanded_current == 0.0
    assert ask(emulator, rmd_x.ReadUptime(), 1800 * MS)[1].milliseconds == 100


def test_the_brake_answers_late_and_a_locked_motor_gives_no_torque():
    emulator = emulated_exoskeleton(options=NO_TIMEOUT)
    t_reply, _ = ask(emulator, rmd_x.LockBrake(), 0)
    assert t_reply > 50 * MS
    ask(emulator, rmd_x.SetCurrent(1.0), MS)
    assert emulator.actuator('shoulder').commanded_current == 0.0
    ask(emulator, rmd_x.ReleaseBrake(), 200 * MS)
    ask(emulator, rmd_x.SetCurrent(1.0), 300 * MS)
    assert emulator.actuator('shoulder').commanded_current == 1.0


def test_the_timeout_can_be_written():
    emulator = emulated_exoskeleton(options=NO_TIMEOUT)
    ask(emulator, rmd_x.SetCurrent(0.5), 0)
    assert ask(emulator, rmd_x.SetTimeout(20), MS)[1] == rmd_x.SetTimeout(20)
    emulator.advance(40 * MS)
    assert emulator.actuator('shoulder').watchdog_trips == 1


def test_status_and_version_are_told():
    emulator = emulated_exoskeleton()
    assert ask(emulator, rmd_x.ReadStatus(), 0)[1] == rmd_x.Status(
        25, True, 48.0, rmd_x.ErrorFlag(0)
    )
    assert ask(emulator, rmd_x.ReadVersion(), 0)[1].date == 20220206


def test_the_winding_warms_with_the_square_of_the_current():
    emulator = emulated_exoskeleton(options=EmulatorOptions(comm_timeout=0.0))
    motor = emulator.actuator('shoulder')
    motor.current = motor._commanded = 4.0
    for t in range(0, 60_000, 100):
        motor.control(t * MS, 0.0, 0.0)
    assert motor.temperature == pytest.approx(25 + 16 * (1 - math.exp(-59.9 / 600)), abs=0.01)


def test_the_servo_follows_its_target_and_says_so():
    emulator = emulated_exoskeleton(options=QUIET)
    for k in range(1000):
        state = command(emulator, k * MS, Mode.POSITION, 0.5, sequence=k)
    assert state.sequence_echo == 999 % 256
    assert state.status == ServoFlag.OUTPUT_ON
    assert state.position == pytest.approx(emulator.q[1], abs=2e-4)
    # Gravity and friction over the loop's gain are what is left.
    gravity = 9.81 * math.cos(math.radians(20)) * 1.8 * 0.135
    assert abs(emulator.q[1] - 0.5) < (gravity + 0.65) / 120.0
    assert state.current == pytest.approx(emulator.actuator('elbow').current, abs=6e-4)


def test_the_servo_takes_currents_too():
    emulator = emulated_exoskeleton(options=QUIET)
    for k in range(20):
        command(emulator, k * MS, Mode.CURRENT, 0.8)
    assert emulator.effort[1] == pytest.approx(0.8, rel=1e-6)


def test_the_servo_turns_off_without_commands_and_says_so_once():
    emulator = emulated_exoskeleton(options=QUIET)
    command(emulator, 0, Mode.CURRENT, 0.8)
    emulator.advance(70 * MS)
    assert abs(emulator.effort[1]) < 1e-4
    assert command(emulator, 70 * MS, Mode.OFF).status == ServoFlag.WATCHDOG
    assert command(emulator, 71 * MS, Mode.OFF).status == ServoFlag(0)


def test_a_servo_without_current_sensor_reports_not_available():
    emulator = emulated_exoskeleton(options=EmulatorOptions(servo_current_available=False))
    assert math.isnan(command(emulator, 0, Mode.OFF).current)


def test_frames_for_nobody_and_frames_that_say_nothing_are_counted_and_not_answered():
    emulator = emulated_exoskeleton()
    assert emulator.handle(Frame(0x150, bytes(8)), 0) == []
    assert emulator.handle(Frame(0x141, b'\x11' * 8), 0) == []
    assert emulator.handle(Frame(0x170, b'\x09' * 8), 0) == []
    assert emulator.foreign_frames == 1
    assert [actuator.undecodable for actuator in emulator.actuators] == [1, 1]


def test_the_plants_path_does_not_depend_on_when_it_is_looked_at():
    """Same frames at the same times, other calls in between: bit for bit the same."""
    rng = np.random.default_rng(0)
    emulators = [emulated_exoskeleton(seed=5) for _ in range(2)]
    for k in range(400):
        t = k * 2 * MS + int(rng.integers(0, MS))
        for emulator in emulators:
            ask(emulator, rmd_x.SetCurrent(math.sin(k / 50)), t)
        for extra in np.sort(rng.integers(t, t + MS // 2, 3)):
            emulators[0].advance(int(extra))
    for emulator in emulators:
        emulator.advance(1000 * MS)
    np.testing.assert_array_equal(emulators[0].q, emulators[1].q)
    np.testing.assert_array_equal(emulators[0].v, emulators[1].v)


def test_a_measurement_is_of_the_time_it_was_asked_not_of_the_grid():
    emulator = emulated_exoskeleton(options=QUIET)
    emulator.plant.v[0] = 2.0
    frame = rmd_x.encode_request(1, rmd_x.ReadAngle())
    angles = []
    for t in (0, STEP_NS // 2):
        ((_, reply),) = emulator.handle(frame, t)
        angles.append(rmd_x.decode_reply(reply)[1].angle)
    assert angles[1] - angles[0] == pytest.approx(2.0 * STEP_NS / 2 * 1e-9, abs=1.8e-4)
    assert emulator.time_ns == 0


def test_hardware_may_differ_from_what_the_driver_believes():
    configuration = default_configuration()
    emulator = ExoskeletonEmulator(
        read_model(share_directory() / 'config' / 'emulated_exoskeleton'),
        (replace(configuration.joints[0], torque_constant=1.0), configuration.joints[1]),
        hanging_position(2),
        options=QUIET,
    )
    for k in range(20):
        ask(emulator, rmd_x.SetCurrent(1.0), k * MS)
    assert emulator.effort[0] == pytest.approx(1.0, rel=1e-6)
