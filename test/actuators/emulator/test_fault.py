# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The emulator's faults: their words, and what each does to frames and actuators."""

from __future__ import annotations

import math
import time
from pathlib import Path

import can
import numpy as np
import pytest
from emulated_clock import EmulatedClock
from hypothesis import given
from hypothesis import strategies as st
from lockstep import emulated_exoskeleton
from lockstep_bus import LockstepBus
from quiet_emulator import DBC, MS, QUIET

from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.actuators.bus.slcan_server import SlcanServerBus
from sosml_friction.actuators.emulator.emulator_thread import EmulatorThread
from sosml_friction.actuators.emulator.fault import FAULTS, parse_fault, parse_faults
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.servo.dbc import Mode, ServoCommand, ServoFlag
from sosml_friction.exceptions import ActuatorError, ConfigurationError

JOINTS = ('shoulder', 'elbow')
UNWATCHED = QUIET.changed(comm_timeout=0.0, servo_watchdog=10.0)
ASK = rmd_x.encode_request(1, rmd_x.ReadAngle())
PATIENCE = 10.0
# What has not come true by then never will.
LONG = 60.0


@pytest.fixture
def emulator():
    return emulated_exoskeleton(options=UNWATCHED)


# ---- words


@pytest.mark.parametrize('kind', FAULTS, ids=lambda kind: kind.name)
def test_every_fault_is_named_by_the_words_it_prints(kind):
    fault = parse_fault(kind.name, JOINTS)
    assert parse_fault(str(fault), JOINTS) == fault
    assert fault.joint == ''


def test_arguments_and_joints_are_read():
    fault = parse_fault('drop joint=elbow fraction=0.25 direction=requests', JOINTS)
    assert (fault.name, fault.joint, fault.number('fraction')) == ('drop', 'elbow', 0.25)
    assert parse_fault('error_bits bits=0x12', JOINTS).number('bits') == 18.0
    assert [f.name for f in parse_faults('drop ; ; duplicate', JOINTS)] == ['drop', 'duplicate']
    assert parse_faults('', JOINTS) == ()


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('silence', 'there is no fault'),
        ('drop joint=wrist', 'use one of shoulder, elbow'),
        ('drop often=1', 'it takes fraction, direction, joint'),
        ('drop fraction=2', 'from 0 to 1'),
        ('drop fraction=nan', 'from 0 to 1'),
        ('drop fraction=much', 'from 0 to 1'),
        ('drop direction=up', 'requests, replies, both'),
        ('bus_off joint=shoulder', 'it takes none'),
        ('delay seconds=-1', 'from 0'),
        ('error_bits bits=0xZZ', '65535'),
    ],
)
def test_what_does_not_exist_is_refused_in_one_sentence(text, sentence):
    with pytest.raises(ConfigurationError, match=sentence) as caught:
        parse_fault(text, JOINTS)
    assert '\n' not in str(caught.value)


def assert_taken_or_refused(text):
    """What is taken says itself in words that are taken; any other exception fails the test."""
    try:
        faults = parse_faults(text, JOINTS)
    except ConfigurationError:
        return
    assert parse_faults('; '.join(map(str, faults)), JOINTS) == faults


@given(st.text(max_size=40))
def test_any_text_is_a_fault_or_a_refusal(text):
    assert_taken_or_refused(text)


@pytest.mark.parametrize('kind', FAULTS, ids=lambda kind: kind.name)
def test_any_argument_of_a_fault_is_taken_or_refused(kind):
    for key in ('joint', 'other', *(own.name for own in kind.arguments)):
        for value in ('', '0x', '0x1', '-1', '0', 'nan', 'inf', '1e99', 'both', 'elbow', 'a=b'):
            assert_taken_or_refused(f'{kind.name} {key}={value}')


def test_nothing_begins_when_one_of_several_does_not_exist(emulator):
    with pytest.raises(ConfigurationError):
        emulator.inject('drop; no_such')
    assert emulator.faults == ()


def test_setting_faults_keeps_begins_and_ends(emulator):
    emulator.set_faults('silent joint=shoulder; reboot joint=elbow seconds=0.1')
    assert [fault.name for fault in emulator.faults] == ['silent']
    # An event that is still written there does not happen again.
    emulator.advance(200 * MS)
    emulator.set_faults('reboot joint=elbow seconds=0.1; duplicate')
    assert [fault.name for fault in emulator.faults] == ['duplicate']
    assert len(emulator.handle(DBC.encode_command(ServoCommand(Mode.OFF, 1)), 200 * MS)) == 2
    emulator.set_faults('')
    assert emulator.faults == ()


# ---- frames


def test_dropped_frames_do_not_arrive(emulator):
    emulator.inject('drop joint=shoulder direction=requests')
    assert emulator.handle(ASK, 0) == []
    assert emulator.actuator('shoulder').frames == 0
    emulator.set_faults('drop joint=shoulder direction=replies')
    assert emulator.handle(ASK, MS) == []
    assert emulator.actuator('shoulder').frames == 1
    assert emulator.handle(DBC.encode_command(ServoCommand(Mode.OFF, 1)), MS)


def test_a_fraction_of_frames_is_dropped(emulator):
    emulator.inject('drop fraction=0.3 direction=replies')
    answered = sum(bool(emulator.handle(ASK, k * MS)) for k in range(1000))
    # Binomial: 700 with a standard deviation of 14.5.
    assert abs(answered - 700) < 5 * 14.5


def test_delayed_replies_come_later_and_delayed_requests_act_later(emulator):
    ((on_time, _),) = emulator.handle(ASK, 0)
    emulator.inject('delay seconds=0.01')
    ((late, _),) = emulator.handle(ASK, 0)
    assert late - on_time >= 10 * MS
    emulator.set_faults('delay seconds=0.01 direction=requests')
    assert emulator.handle(rmd_x.encode_request(1, rmd_x.SetCurrent(1.0)), MS) == []
    emulator.advance(10 * MS)
    assert emulator.actuator('shoulder').commanded_current == 0.0
    emulator.advance(12 * MS)
    assert emulator.actuator('shoulder').commanded_current == 1.0
    ((when, reply),) = emulator.take_sent()
    assert when > 11 * MS
    assert reply.data[0] == 0xA1


def test_duplicates_are_heard_twice(emulator):
    emulator.inject('duplicate direction=replies')
    (_, first), (_, second) = emulator.handle(ASK, 0)
    assert first == second
    assert emulator.actuator('shoulder').frames == 1


def test_reordered_replies_change_places(emulator):
    emulator.inject('reorder')
    assert emulator.handle(rmd_x.encode_request(1, rmd_x.SetCurrent(0.0)), 0) == []
    replies = emulator.handle(ASK, 0)
    assert [frame.data[0] for _, frame in sorted(replies)] == [0x92, 0xA1]


def test_a_bit_error_turns_exactly_one_bit_over(emulator):
    good = emulator.handle(ASK, 0)[0][1].data
    emulator.inject('bit_errors')
    for k in range(50):
        ((_, frame),) = emulator.handle(ASK, k * MS)
        wrong = np.frombuffer(good, np.uint8) ^ np.frombuffer(frame.data, np.uint8)
        assert np.unpackbits(wrong).sum() == 1


def test_without_a_fault_nothing_is_drawn_from_its_generator():
    """A run with a fault that has ended continues as one without, if frames are the same."""
    plain, faulty = (emulated_exoskeleton(seed=5) for _ in range(2))
    plain.handle(ASK, 0)
    faulty.inject('bit_errors')
    faulty.handle(ASK, 0)
    faulty.clear()
    for k in range(1, 20):
        assert plain.handle(ASK, k * MS) == faulty.handle(ASK, k * MS)


# ---- actuators


def test_a_silent_actuator_neither_hears_nor_answers(emulator):
    emulator.inject('silent joint=shoulder')
    assert emulator.handle(ASK, 0) == []
    assert emulator.actuator('shoulder').frames == 0


def test_a_power_cycle_leaves_the_angle_wrong_by_motor_turns(emulator):
    emulator.inject('power_cycle joint=shoulder turns=-2 seconds=0.5')
    assert emulator.handle(ASK, 100 * MS) == []
    emulator.advance(600 * MS)
    ((_, frame),) = emulator.handle(ASK, 600 * MS)
    assert rmd_x.decode_reply(frame)[1].angle == pytest.approx(-math.tau / 4, abs=1e-4)
    emulator.clear('power_cycle')
    ((_, frame),) = emulator.handle(ASK, 600 * MS)
    assert rmd_x.decode_reply(frame)[1].angle == pytest.approx(0.0, abs=1e-4)


def test_error_bits_are_reported_and_keep_the_output_off(emulator):
    emulator.handle(rmd_x.encode_request(1, rmd_x.SetCurrent(1.0)), 0)
    emulator.inject('error_bits joint=shoulder bits=0x12; error_bits joint=elbow bits=4')
    emulator.advance(5 * MS)
    np.testing.assert_allclose(emulator.effort, 0.0, atol=1e-6)
    emulator.handle(rmd_x.encode_request(1, rmd_x.SetCurrent(1.0)), 5 * MS)
    assert emulator.actuator('shoulder').commanded_current == 0.0
    ((_, frame),) = emulator.handle(rmd_x.encode_request(1, rmd_x.ReadStatus()), 5 * MS)
    assert rmd_x.decode_reply(frame)[1].errors == 0x12
    ((_, frame),) = emulator.handle(DBC.encode_command(ServoCommand(Mode.POSITION, 1)), 5 * MS)
    assert DBC.decode_state(frame).status == ServoFlag.UNDER_VOLTAGE


def test_a_stuck_encoder_gives_the_same_angle_while_the_joint_moves(emulator):
    emulator.handle(rmd_x.encode_request(1, rmd_x.SetCurrent(3.0)), 0)
    emulator.advance(100 * MS)
    emulator.inject('stuck_encoder joint=shoulder')
    angles = set()
    before = emulator.q[0]
    for k in range(101, 200):
        angles.add(emulator.handle(ASK, k * MS)[0][1].data)
    assert len(angles) == 1
    assert abs(emulator.q[0] - before) > 0.02


# ---- the bus


def lockstep_bus(emulator):
    clock = EmulatedClock()
    return clock, LockstepBus(emulator, clock)


def test_off_the_bus_an_error_frame_tells_it_and_a_few_frames_wait(emulator):
    clock, bus = lockstep_bus(emulator)
    emulator.inject('bus_off')
    message = bus.recv(0.0)
    assert message.is_error_frame
    assert message.arbitration_id & 0x40
    for _ in range(10):
        bus.send(ASK.to_message())
    with pytest.raises(can.CanOperationError) as caught:
        bus.send(ASK.to_message())
    assert caught.value.error_code == 105
    assert bus.recv(0.05) is None
    emulator.clear()
    assert bus.recv(0.0).arbitration_id & 0x100
    assert sum(bus.recv(0.05) is not None for _ in range(11)) == 10
    assert clock.now_ns() > 50 * MS
    bus.shutdown()


@pytest.mark.parametrize(('fault', 'code'), [('tx_full', None), ('tx_full errno=105', 105)])
def test_a_full_transmit_buffer_comes_in_both_forms(emulator, fault, code):
    _, bus = lockstep_bus(emulator)
    emulator.inject(fault)
    with pytest.raises(can.CanOperationError, match='Transmit buffer full') as caught:
        bus.send(ASK.to_message())
    assert caught.value.error_code == code
    emulator.clear()
    bus.send(ASK.to_message())
    assert bus.recv(0.1) is not None
    bus.shutdown()


def test_an_adapter_that_is_gone_is_enodev(emulator):
    _, bus = lockstep_bus(emulator)
    emulator.inject('adapter_gone')
    for use in (lambda: bus.send(ASK.to_message()), lambda: bus.recv(0.0)):
        with pytest.raises(OSError, match='No such device'):
            use()
    bus.shutdown()


# ---- the same over bytes


@pytest.fixture
def wire(emulator):
    """Return the emulator's thread on a TCP port, and the port."""
    server = SlcanServerBus('127.0.0.1:0')
    thread = EmulatorThread(server, emulator)
    thread.start()
    yield thread, f'socket://127.0.0.1:{server.port}'
    thread.stop()
    server.shutdown()
    assert thread.error is None


def answer(bus, wait=PATIENCE):
    """Send and return the first reply, or None."""
    bus.send(ASK.to_message())
    return bus.recv(wait)


def until(bus, answered, wait=0.1):
    """Ask until the motor answers, or until it does not."""
    end = time.monotonic() + LONG
    while (answer(bus, wait) is not None) is not answered:
        assert time.monotonic() < end


def connected(channel):
    """Return a bus on which the motor answers."""
    bus = open_bus('slcan', channel, 1_000_000)
    until(bus, True, 0.5)
    return bus


def test_faults_begin_and_end_on_the_wire(wire):
    thread, channel = wire
    bus = connected(channel)
    thread.set_faults('silent joint=shoulder')
    until(bus, False)
    thread.set_faults('')
    until(bus, True)
    with pytest.raises(ConfigurationError):
        thread.set_faults('no_such')
    bus.shutdown()


def test_off_the_bus_the_adapter_refuses_frames_with_a_bell(wire):
    thread, channel = wire
    bus = connected(channel)
    before = bus.refused
    thread.set_faults('bus_off')
    end = time.monotonic() + LONG
    while bus.refused == before:
        assert time.monotonic() < end
        answer(bus, 0.05)
    thread.set_faults('')
    until(bus, True)
    bus.shutdown()


def test_an_adapter_that_stops_reading_keeps_frames_and_delivers_them_late(wire, emulator):
    """The line holds them: what a host sends meanwhile is executed afterwards."""
    thread, channel = wire
    bus = connected(channel)
    thread.set_faults('tx_full')
    until(bus, False)
    before = emulator.actuator('shoulder').frames
    for _ in range(20):
        bus.send(ASK.to_message())
    thread.set_faults('')
    end = time.monotonic() + LONG
    while emulator.actuator('shoulder').frames < before + 20:
        assert time.monotonic() < end
        bus.recv(0.2)
    bus.shutdown()


def test_an_unplugged_adapter_is_an_error_and_can_be_opened_again(wire):
    thread, channel = wire
    bus = connected(channel)
    thread.set_faults('adapter_gone')

    def use_it():
        while True:
            answer(bus, 0.05)

    with pytest.raises(can.CanOperationError):
        use_it()
    bus.shutdown()
    thread.set_faults('')
    while True:
        try:
            bus = open_bus('slcan', channel, 1_000_000)
            if answer(bus, 0.5) is not None:
                break
        except (ActuatorError, can.CanError):
            continue
    bus.shutdown()


def test_faults_act_on_the_virtual_interface_too(emulator):
    far, near = (open_bus('virtual', 'sosml_test_fault', 1_000_000) for _ in range(2))
    thread = EmulatorThread(far, emulator)
    thread.start()
    until(near, True, 0.5)
    for fault in ('drop joint=shoulder', 'bus_off'):
        thread.set_faults(fault)
        until(near, False, 0.05)
        thread.set_faults('')
        until(near, True, 0.05)
    thread.stop()
    assert thread.error is None
    far.shutdown()
    near.shutdown()


def test_where_the_machine_stops_emulated_time_stands_still(emulator):
    """What a stalled process would have to catch up with must not keep the answers waiting."""

    class SlowBus:
        def recv(self, timeout):
            time.sleep(0.1)

    thread = EmulatorThread(SlowBus(), emulator)
    begin = time.monotonic_ns()
    thread.start()
    while thread.lost_ns < 300 * MS:
        assert time.monotonic_ns() - begin < LONG * 1e9
        time.sleep(0.01)
    thread.stop()
    assert thread.error is None
    assert emulator.time_ns + thread.lost_ns <= time.monotonic_ns() - begin + 50 * MS
    assert emulator.time_ns < 0.5 * thread.lost_ns
    # The motor's own clock goes on: it was not switched on anew.
    ask = rmd_x.encode_request(1, rmd_x.ReadUptime())
    ((_, reply),) = emulator.handle(ask, emulator.time_ns)
    uptime_ns = rmd_x.decode_reply(reply)[1].milliseconds * MS
    assert uptime_ns == pytest.approx(emulator.time_ns + thread.lost_ns, abs=2 * MS)


def test_the_page_of_faults_names_them_all_with_their_arguments():
    page = (Path(__file__).resolve().parents[3] / 'docs' / 'faults.md').read_text()
    table = page[: page.index('## What becomes of the torque')]
    rows = {line.split('`')[1]: line for line in table.splitlines() if line.startswith('| `')}
    assert sorted(rows) == sorted(kind.name for kind in FAULTS)
    for kind in FAULTS:
        for argument in kind.arguments:
            assert f'`{argument.name}`' in rows[kind.name]
