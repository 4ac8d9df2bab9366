# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The exchange on a bus that misbehaves, frame by frame."""

from __future__ import annotations

import errno
from dataclasses import replace

import can
import pytest
from emulated_clock import EmulatedClock

from sosml_friction.actuators.bus.cycle import BusCycle
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.measurement import Setpoint
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.actuator import RmdXActuator
from sosml_friction.actuators.rmd_x.configuration import RmdXConfiguration
from sosml_friction.exceptions import ActuatorError
from sosml_friction.model.robot import JointLimits

JOINT = RmdXConfiguration(
    'shoulder', 1, 0.0, 1.25, can_id=1, current_limit=6.0, current_rate_limit=500.0,
    kp=250.0, kd=12.0,
)  # fmt: skip
LIMITS = JointLimits(-1.7, 0.7, 3.0, 8.0)
DEADLINE = 20_000_000
MOTION = rmd_x.Motion(25, 0.5, 0.0, 0.0)


class ScriptedBus:
    """A bus of lists: what is to be received, what was sent, what sending raises."""

    def __init__(self, clock, refused=0):
        self.clock = clock
        self.incoming: list[can.Message] = []
        self.sent: list[Frame] = []
        self.answers: dict[int, list] = {}
        self.send_errors: list[Exception] = []
        self.recv_error: Exception | None = None
        self.refused = refused
        self.closed = False

    def send(self, message, timeout=None):
        if self.send_errors:
            raise self.send_errors.pop(0)
        frame = Frame.from_message(message)
        self.sent.append(frame)
        self.incoming += [as_message(own) for own in self.answers.get(frame.data[0], [])]

    def recv(self, timeout=None):
        if self.recv_error is not None:
            raise self.recv_error
        if self.incoming:
            return self.incoming.pop(0)
        self.clock.sleep_until_ns(self.clock.now_ns() + round((timeout or 0.0) * 1e9))
        return None

    def shutdown(self):
        self.closed = True


def as_message(frame):
    return frame if isinstance(frame, can.Message) else frame.to_message()


def error_frame(kind):
    return can.Message(arbitration_id=kind, is_error_frame=True, dlc=8, data=bytes(8))


@pytest.fixture
def clock():
    return EmulatedClock()


@pytest.fixture
def own():
    return RmdXActuator(JOINT, LIMITS, 500.0)


@pytest.fixture
def bus(clock):
    bus = ScriptedBus(clock)
    bus.answers = {
        0xA1: [rmd_x.encode_reply(1, MOTION)],
        0x92: [rmd_x.encode_reply(1, rmd_x.Angle(0.1))],
        0x9A: [rmd_x.encode_reply(1, rmd_x.Status(25, True, 48.0, rmd_x.ErrorFlag(0)))],
        0xB1: [rmd_x.encode_reply(1, rmd_x.Uptime(1000))],
    }
    return bus


@pytest.fixture
def cycle(bus, clock, own):
    return BusCycle(bus, clock, [own])


def commands(bus):
    return [frame.data[0] for frame in bus.sent]


def test_all_requests_are_out_before_the_first_reply_is_taken(cycle, bus, own):
    assert cycle.exchange(own.release(0), DEADLINE) == set()
    assert commands(bus) == [0xA1, 0x92, 0x9A, 0xB1]
    assert own.measurement.tau == pytest.approx(0.625)


@pytest.mark.parametrize(
    'error',
    [
        can.CanOperationError('Transmit buffer full'),
        can.CanOperationError('Failed to transmit', errno.ENOBUFS),
    ],
)
def test_a_full_buffer_ends_the_sending_and_nothing_overtakes_what_was_refused(
    cycle, bus, own, error
):
    bus.send_errors = [error]
    missing = cycle.exchange(own.release(0), DEADLINE)
    assert len(missing) == 4
    assert bus.sent == []
    assert cycle.counters.not_sent == 1
    assert cycle.counters.failures == 0
    assert cycle.exchange(own.release(1), 2 * DEADLINE) == set()


def test_what_the_adapter_refuses_by_a_bell_is_counted_from_here_on(bus, clock, own):
    bus.refused = 3
    cycle = BusCycle(bus, clock, [own])
    cycle.exchange(own.release(0), DEADLINE)
    assert cycle.counters.not_sent == 0
    bus.refused = 5
    cycle.exchange(own.release(1), DEADLINE)
    assert cycle.counters.not_sent == 2


def test_an_echo_is_a_missing_answer_and_does_not_hold_the_cycle_up(cycle, bus, own, clock):
    bus.answers[0xA1] = [Frame(0x241, bytes.fromhex('A1 00 00 00 64 00 00 00'))]
    own.accept(rmd_x.encode_reply(1, rmd_x.Angle(0.0)), 0)
    missing = cycle.exchange(own.command(Setpoint(1.25, 0.0, 0.0), 0), DEADLINE)
    assert missing == {(0x241, 0xA1)}
    assert clock.now_ns() == 0
    assert (cycle.counters.echoes, own.timeouts) == (1, 1)
    # iq was never measured: an echo is no measurement.
    assert own.measurement.tau != own.measurement.tau


def test_what_the_motor_says_unasked_is_counted_apart(cycle, bus, own):
    bus.incoming = [rmd_x.encode_reply(1, rmd_x.TimeoutExpired()).to_message()]
    cycle.exchange(own.release(0), DEADLINE)
    counters = cycle.counters
    assert (counters.unsolicited, counters.stale, own.timeouts) == (1, 0, 1)


def test_a_reply_nobody_waits_for_is_stale_and_never_taken(cycle, bus, own):
    bus.incoming = [rmd_x.encode_reply(1, rmd_x.Angle(1.0)).to_message()]
    bus.answers[0x92] = []
    assert cycle.exchange(own.release(0), DEADLINE) == {(0x241, 0x92)}
    assert cycle.counters.stale == 1
    assert own.measurement.stamp_ns == 0


def test_a_measurement_is_of_when_it_was_asked_whenever_the_answer_is_read(cycle, bus, own, clock):
    clock.sleep_until_ns(1_000)
    answer = rmd_x.encode_reply(1, rmd_x.Angle(1.0)).to_message()

    def recv(timeout=None, taken=bus.recv):
        clock.sleep_until_ns(clock.now_ns() + 5_000)
        return taken(timeout)

    bus.answers[0x92] = [answer]
    bus.recv = recv
    assert cycle.exchange(own.release(0), DEADLINE) == set()
    asked_ns, received_ns = own.measurement.stamp_ns, own.measurement.received_ns
    assert 1_000 <= asked_ns <= received_ns - 5_000


def test_a_patient_request_does_not_hold_the_cycle_up(cycle, bus, own, clock):
    own = RmdXActuator(replace(JOINT, brake=True), LIMITS, 500.0)
    own.accept(rmd_x.encode_reply(1, rmd_x.Angle(0.0)), 0)
    cycle = BusCycle(bus, clock, [own])
    assert cycle.exchange(own.command(Setpoint(0.5, 0.0, 0.0), 0), DEADLINE) == set()
    assert commands(bus)[0] == 0x77
    assert clock.now_ns() == 0
    bus.incoming = [rmd_x.encode_reply(1, rmd_x.ReleaseBrake()).to_message()]
    cycle.exchange(own.command(Setpoint(0.5, 0.0, 0.0), 2), DEADLINE)
    assert own.waiting() == ''


def test_a_patient_request_is_overdue_after_its_time(bus, clock):
    own = RmdXActuator(replace(JOINT, brake=True), LIMITS, 500.0)
    own.accept(rmd_x.encode_reply(1, rmd_x.Angle(0.0)), 0)
    cycle = BusCycle(bus, clock, [own])
    cycle.exchange(own.command(Setpoint(0.5, 0.0, 0.0), 0), DEADLINE)
    for t_ns, fault in ((999_000_000, ''), (1_000_000_000, 'the brake did not answer')):
        clock.sleep_until_ns(t_ns)
        cycle.exchange(own.command(Setpoint(0.5, 0.0, 0.0), t_ns), t_ns + DEADLINE)
        assert fault in own.fault()
        assert bool(fault) == bool(own.fault())


def test_off_the_bus_nothing_is_sent_until_the_controller_restarts(cycle, bus, own):
    bus.incoming = [error_frame(0x40)]
    with pytest.raises(ActuatorError, match='bus-off'):
        cycle.exchange(own.release(0), DEADLINE)
    assert bus.sent == []
    assert not cycle.recover()
    bus.incoming = [error_frame(0x100)]
    assert cycle.recover()
    assert bus.sent == []
    assert cycle.exchange(own.release(1), DEADLINE) == set()
    assert cycle.counters.error_frames == 2


@pytest.mark.parametrize('where', ['send', 'recv'])
def test_a_lost_adapter_is_opened_again_and_nothing_is_sent_meanwhile(clock, own, where):
    first, second = ScriptedBus(clock), ScriptedBus(clock)
    openings = [ActuatorError('not yet'), second]

    def reopen():
        found = openings.pop(0)
        if isinstance(found, Exception):
            raise found
        return found

    cycle = BusCycle(first, clock, [own], reopen)
    gone = OSError(errno.ENODEV, 'No such device')
    if where == 'send':
        first.send_errors = [gone]
    else:
        first.recv_error = gone
    with pytest.raises(ActuatorError, match='No such device'):
        cycle.exchange(own.release(0), DEADLINE)
    assert not cycle.recover()
    assert cycle.recover()
    assert first.closed
    assert cycle.bus is second
    assert (first.sent, second.sent) == ([], [])
    assert cycle.counters.reopened == 1


def test_a_flood_ends_the_reading_at_the_deadline(cycle, bus, own, clock):
    """A bus that always has one frame more does not keep a cycle for ever."""
    stranger = Frame(0x123, b'').to_message()
    bus.answers = {}
    received = 0

    def recv(timeout=None):
        nonlocal received
        received += 1
        clock.sleep_until_ns(clock.now_ns() + 100_000)
        return stranger

    bus.recv = recv
    missing = cycle.exchange(own.release(0), clock.now_ns() + DEADLINE)
    assert len(missing) == 4
    assert received < 1000
