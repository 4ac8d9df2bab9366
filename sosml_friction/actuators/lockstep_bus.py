# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A bus whose other end is the emulator, in emulated time."""

from __future__ import annotations

import heapq
from typing import Any

import can

from sosml_friction.actuators.clock import EmulatedClock
from sosml_friction.actuators.emulator import ExoskeletonEmulator
from sosml_friction.actuators.frame import Frame


class LockstepBus(can.BusABC):
    """
    Hand frames to an emulator and its replies back when they are due on an emulated clock.

    Waiting for a frame moves the clock to the next reply or to the end of the wait; nothing else
    here takes time. Not modelled: the time frames take on the wire, arbitration, errors.
    """

    def __init__(self, emulator: ExoskeletonEmulator, clock: EmulatedClock, **kwargs: Any) -> None:
        self._emulator = emulator
        self._clock = clock
        self._replies: list[tuple[int, int, Frame]] = []
        self._count = 0
        self._can_protocol = can.CanProtocol.CAN_20
        super().__init__(channel='lockstep', **kwargs)
        self.channel_info = 'emulated exoskeleton in lockstep'

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Give the emulator a frame at the present emulated time."""
        frame = Frame.from_message(msg)
        if frame is None:
            return
        for t_ns, reply in self._emulator.handle(frame, self._clock.now_ns()):
            self._count += 1
            heapq.heappush(self._replies, (t_ns, self._count, reply))

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next reply within ``timeout`` [s] of emulated time; None waits for ever."""
        now_ns = self._clock.now_ns()
        due_ns = self._replies[0][0] if self._replies else None
        if due_ns is None or (timeout is not None and due_ns > now_ns + round(timeout * 1e9)):
            if timeout is not None:
                self._clock.sleep_until_ns(now_ns + round(timeout * 1e9))
            return None
        self._clock.sleep_until_ns(due_ns)
        _, _, frame = heapq.heappop(self._replies)
        message = frame.to_message()
        message.timestamp = self._clock.now_ns() * 1e-9
        message.is_rx = True
        return message

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return self.recv(timeout), False
