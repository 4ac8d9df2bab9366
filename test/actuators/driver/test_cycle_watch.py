# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""When the host, a pause of the cycle or another program is a fault: each from both sides."""

from __future__ import annotations

import pytest

from sosml_friction.actuators.bus.cycle import BusCounters
from sosml_friction.actuators.driver.cycle_watch import CycleWatch

MS = 1_000_000


@pytest.fixture
def watch(configuration):
    return CycleWatch(configuration)


def test_a_host_that_never_spoke_is_not_waited_for(watch):
    assert watch.start_cycle(10**12) == ''


@pytest.mark.parametrize(('silence_ms', 'fault'), [(1000, False), (1001, True)])
def test_a_host_may_be_silent_for_its_timeout(watch, silence_ms, fault):
    """1 s, as the configuration says."""
    watch.heartbeat(5 * MS)
    assert ('one of its callbacks hangs' in watch.start_cycle((5 + silence_ms) * MS)) == fault


def test_enabling_gives_the_host_its_time_anew(watch):
    watch.heartbeat(0)
    watch.enable(5000 * MS)
    assert watch.start_cycle(5900 * MS) == ''


@pytest.mark.parametrize(('pause_ms', 'fault'), [(86, False), (87, True)])
def test_the_cycle_may_stand_still_for_as_long_as_an_actuator_may_be_silent(
    watch, pause_ms, fault
):
    """80 ms, and one wait of 6 ms."""
    assert watch.start_cycle(0) == ''
    assert ('the cycle stood still for' in watch.start_cycle(pause_ms * MS)) == fault


def test_another_program_is_there_for_a_second_after_its_last_command(watch):
    counters = BusCounters()
    watch.end_cycle(counters, 0)
    assert watch.intruder() == ''
    counters.intruders = 1
    watch.end_cycle(counters, 5 * MS)
    assert 'another program' in watch.intruder()
    watch.end_cycle(counters, 1005 * MS)
    assert 'another program' in watch.intruder()
    watch.end_cycle(counters, 1006 * MS)
    assert watch.intruder() == ''


def test_the_bus_is_blocked_while_frames_are_refused(watch):
    counters = BusCounters(not_sent=2)
    watch.end_cycle(counters, 0)
    assert 'takes no frames' in watch.blockage()
    watch.end_cycle(counters, 2 * MS)
    assert watch.blockage() == ''
