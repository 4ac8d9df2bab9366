# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The thread that owns the bus ends with the outputs off, however it ends."""

from __future__ import annotations

import threading

import pytest
from emulated_clock import EmulatedClock

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.driver.cycle_thread import CycleThread

PERIOD = 2_000_000


class Script:
    """A driver whose cycles take the time they are told, and note when they began."""

    class configuration:  # noqa: N801
        period_ns = PERIOD

    def __init__(self, clock: Clock, durations: list[int]) -> None:
        self.clock = clock
        self.durations = list(durations)
        self.starts: list[int] = []
        self.shut_downs = 0
        self.done = threading.Event()

    def step(self):
        self.starts.append(self.clock.now_ns())
        if not self.durations:
            raise RuntimeError('end of the script')
        self.clock.sleep_until_ns(self.clock.now_ns() + self.durations.pop(0))
        return len(self.starts)

    def shut_down(self):
        self.shut_downs += 1
        self.done.set()


def run(durations):
    clock = EmulatedClock()
    script, samples = Script(clock, durations), []
    thread = CycleThread(script, clock, samples.append)
    thread.start()
    assert script.done.wait(60.0)
    thread.stop()
    return script, samples, thread


def test_cycles_begin_on_an_absolute_grid():
    script, samples, thread = run([100_000, 1_900_000, 0, 500_000])
    assert script.starts == [k * PERIOD for k in range(5)]
    assert samples == [1, 2, 3, 4]
    assert (thread.overruns, thread.skipped) == (0, 0)


def test_a_cycle_that_takes_too_long_is_counted_and_the_lost_ones_are_skipped():
    """2.5 ms: the next begins at once, on the old grid after that; 7 ms: two are skipped."""
    script, _, thread = run([2_500_000, 0, 7_000_000, 0])
    assert script.starts == [0, 2_500_000, 4_000_000, 11_000_000, 12_000_000]
    assert (thread.overruns, thread.skipped) == (2, 2)
    # Late by 0.5 and by 5 ms: the second began at 4 ms and should have ended by 6.
    assert thread.late.text() == '<= 0.5 ms: 1, <= 5 ms: 1'
    assert thread.late.greatest_ns == 5_000_000
    # The second began 0.5 ms after its deadline and the fourth 1 ms, the others on theirs.
    assert thread.begun.text() == '<= 0.02 ms: 3, <= 0.5 ms: 1, <= 1 ms: 1'
    assert thread.begun.greatest_ns == 1_000_000


@pytest.mark.parametrize('culprit', ['step', 'publish'])
def test_an_exception_ends_in_outputs_off_and_is_kept(culprit):
    clock = EmulatedClock()
    script = Script(clock, [0, 0] if culprit == 'step' else [0] * 100)

    def publish(_):
        if culprit == 'publish':
            raise ValueError('no publisher')

    thread = CycleThread(script, clock, publish)
    thread.start()
    assert script.done.wait(60.0)
    thread.join()
    assert script.shut_downs == 1
    expected = 'end of the script' if culprit == 'step' else 'no publisher'
    assert str(thread.error) == expected


def test_stop_waits_until_the_outputs_are_off():
    script = Script(Clock(), [0] * 100_000)
    thread = CycleThread(script, Clock(), lambda _: None)
    thread.start()
    while len(script.starts) < 3:
        pass
    thread.stop()
    assert script.shut_downs == 1
    assert not thread.is_alive()
    assert thread.error is None


def test_a_cycle_that_hangs_in_the_bus_is_not_waited_for_for_ever():
    script = Script(Clock(), [])
    entered, release = threading.Event(), threading.Event()

    def hang():
        entered.set()
        release.wait(60.0)

    script.step = hang
    thread = CycleThread(script, Clock(), lambda _: None)
    thread.start()
    assert entered.wait(30.0)
    assert not thread.stop(patience=0.01)
    assert script.shut_downs == 0
    release.set()
    assert thread.stop(patience=30.0)
    assert script.shut_downs == 1
