# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The emulator in real time: when a frame arrived, whatever the machine is busy with."""

from __future__ import annotations

import itertools
import time
from collections import deque

import can
import pytest
from lockstep import emulated_exoskeleton
from quiet_emulator import QUIET

from sosml_friction.actuators.emulator.emulator_thread import EmulatorThread
from sosml_friction.actuators.emulator.frame_faults import FRAME_NS
from sosml_friction.actuators.rmd_x import codec as rmd_x

ASK = rmd_x.encode_request(1, rmd_x.ReadAngle())
# What has not come true by then never will.
LONG = 60.0
SLOW_S = 0.005


class Line:
    """Deliver frames in bursts: the next burst is sent when all of the last are answered."""

    def __init__(self, *bursts: int) -> None:
        self.bursts, self.waiting, self.answers = deque(bursts), deque(), 0

    def recv(self, timeout: float) -> can.Message | None:
        if not self.waiting and timeout > 0.0:
            time.sleep(timeout)
            if self.bursts and not self.answers:
                self.answers = self.bursts.popleft()
                self.waiting.extend([ASK.to_message()] * self.answers)
        return self.waiting.popleft() if self.waiting else None

    def send(self, message: can.Message) -> None:
        self.answers -= 1


@pytest.mark.parametrize('bursts', [(3, 3), (1, 1, 1)])
def test_frames_that_came_together_are_a_frame_apart_however_slow_the_emulator(
    monkeypatch, bursts
):
    """What it computes for a frame is no time on the wire; between bursts time goes by."""
    emulator = emulated_exoskeleton(options=QUIET)
    arrivals: list[int] = []
    handle = emulator.handle

    def slow(frame, t_ns):
        arrivals.append(t_ns)
        time.sleep(SLOW_S)
        return handle(frame, t_ns)

    monkeypatch.setattr(emulator, 'handle', slow)
    line = Line(*bursts)
    thread = EmulatorThread(line, emulator)
    begin = time.monotonic()
    thread.start()
    while line.bursts or line.answers:
        assert time.monotonic() - begin < LONG
        time.sleep(0.001)
    thread.stop()
    assert thread.error is None
    begun = 0
    for size in bursts:
        own = arrivals[begun : begun + size]
        assert [b - a for a, b in itertools.pairwise(own)] == [FRAME_NS] * (size - 1)
        if begun:
            assert own[0] - arrivals[begun - 1] > SLOW_S * 1e9
        begun += size
