# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An answer later than usual by more than a period has no time of measurement."""

from __future__ import annotations

import numpy as np
from lockstep import Lockstep, emulated_exoskeleton
from lockstep_bus import LockstepBus

from sosml_friction.actuators.driver.lateness import NEW_USUAL, Lateness

MS = 1_000_000


def test_the_usual_latency_is_the_median_and_what_is_later_by_the_tolerance_is_late():
    rng = np.random.default_rng(1)
    latencies = rng.permutation([MS // 2] * 700 + [MS] * 200 + [5 * MS] * 100)
    lateness = Lateness(2 * MS)
    late = [lateness.is_late(int(latency)) for latency in latencies]
    assert abs(lateness.usual_ns - MS // 2) < 0.2 * MS
    np.testing.assert_array_equal(late, latencies == 5 * MS)


def test_what_is_late_all_the_time_is_the_usual():
    """As an adapter that holds every frame back from now on."""
    lateness = Lateness(2 * MS)
    for _ in range(50):
        assert not lateness.is_late(MS)
    late = [lateness.is_late(9 * MS) for _ in range(2 * NEW_USUAL)]
    assert late == [True] * (NEW_USUAL - 1) + [False] * (NEW_USUAL + 1)


class _HaltingBus(LockstepBus):
    """The program stands still for 5 ms between two questions where ``halts`` says so."""

    halts = False

    def send(self, msg, timeout=None) -> None:
        # Its first question is that for the current, the second that for the angle.
        if self.halts and msg.data[0] == 0x92:
            self._clock.sleep_until_ns(self._clock.now_ns() + 5 * MS)
        super().send(msg, timeout)


def test_a_cycle_that_stood_still_between_effort_and_position_gives_no_sample():
    """Its effort is 5 ms older than its position."""
    with Lockstep(emulated_exoskeleton()) as lockstep:
        bus = _HaltingBus(lockstep.emulator, lockstep.clock)
        lockstep.driver._bus.cycle.bus = bus
        lockstep.driver.configure()
        lockstep.run(0.2)
        for k in range(50):
            before = len(lockstep.samples)
            bus.halts = k % 10 == 5
            lockstep.step()
            assert len(lockstep.samples) - before == (0 if bus.halts else 1)
        report = lockstep.driver.report()
        assert (report.late_cycles, report.incomplete_cycles) == (5, 0)
        assert abs(report.joints[0].usual_latency - 3e-4) < 2e-4
