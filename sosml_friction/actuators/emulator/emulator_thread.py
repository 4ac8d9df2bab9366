# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The thread that runs the emulated hardware on a real bus, in real time."""

import heapq
import queue
import threading

import can

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.bus.slcan_server import SlcanServerBus
from sosml_friction.actuators.emulator.emulator import STEP_NS, ExoskeletonEmulator
from sosml_friction.actuators.emulator.fault import parse_faults
from sosml_friction.actuators.emulator.frame_faults import FRAME_NS

# The plant is kept up to date at least this often.
_TICK = 2e-3
_MOST_BEHIND_NS = 20_000_000
# At most so many frames are dealt with before an answer goes out: a cycle of ten joints, no flood.
_BURST = 32


class EmulatorThread(threading.Thread):
    """
    Own the bus: take frames when they come, send replies when they are due.

    Emulated time is the time since the start. Frames that came while one was dealt with followed
    it on the wire: how long this program computes sets no two measurements apart. A reply later
    than due, for want of the processor, is sent at once. Where the machine does not run this
    thread for longer than 20 ms, emulated time stands still meanwhile, and ``lost_ns`` counts it:
    to integrate all of it afterwards would keep the answers waiting longer still.
    """

    def __init__(self, bus: can.BusABC, emulator: ExoskeletonEmulator) -> None:
        super().__init__(name='emulator', daemon=True)
        self._bus = bus
        self._clock = Clock()
        self._emulator = emulator
        self._stop_event = threading.Event()
        self._wanted: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._replies: list[tuple[int, int, Frame]] = []
        self._count = 0
        self._start_ns = 0
        self.lost_ns = 0
        self.error: BaseException | None = None
        # The first step may take seconds, to compile: not while somebody waits for an answer.
        emulator.advance(emulator.time_ns + STEP_NS)

    def set_faults(self, faults: str) -> None:
        """
        Have these faults and no others, from any thread; they begin with the next frame or tick.

        :raises ConfigurationError: if one of them does not exist; then nothing changes.
        """
        parse_faults(faults, self._emulator.names)
        self._wanted.put(faults)

    def run(self) -> None:
        """Run until :meth:`stop`; an exception is kept in ``error``."""
        self._start_ns = self._clock.now_ns() - self._emulator.time_ns
        try:
            while not self._stop_event.is_set():
                now_ns = self._now_ns()
                self._change_faults(now_ns)
                message = self._bus.recv(self._send_due(now_ns))
                if message is None:
                    self._emulator.advance(self._now_ns())
                else:
                    self._take_burst(message)
                self._push(self._emulator.take_sent())
        except BaseException as error:
            self.error = error

    def _take_burst(self, message: can.Message) -> None:
        """Take a frame, and those that came while it was dealt with: they followed on the wire."""
        arrival_ns = self._now_ns()
        for _ in range(_BURST):
            frame = Frame.from_message(message)
            if frame is not None:
                self._push(self._emulator.handle(frame, arrival_ns))
            following = self._bus.recv(0.0)
            if following is None:
                break
            message = following
            arrival_ns = min(arrival_ns + FRAME_NS, self._now_ns())

    def _send_due(self, now_ns: int) -> float:
        """Send the replies that are due; return how long the next may wait for [s]."""
        replies = self._replies
        while replies and replies[0][0] <= now_ns:
            self._bus.send(heapq.heappop(replies)[2].to_message())
        return min(_TICK, (replies[0][0] - now_ns) * 1e-9) if replies else _TICK

    def _now_ns(self) -> int:
        """Return the emulated time now [ns]."""
        now_ns = self._clock.now_ns() - self._start_ns
        behind_ns = now_ns - self._emulator.time_ns - _MOST_BEHIND_NS
        if behind_ns > 0:
            self._start_ns += behind_ns
            self.lost_ns += behind_ns
            for actuator in self._emulator.actuators:
                actuator.clock_ahead_ns = self.lost_ns
            now_ns -= behind_ns
        return now_ns

    def _push(self, frames: list[tuple[int, Frame]]) -> None:
        for t_ns, frame in frames:
            self._count += 1
            heapq.heappush(self._replies, (t_ns, self._count, frame))

    def _change_faults(self, now_ns: int) -> None:
        while not self._wanted.empty():
            self._emulator.advance(now_ns)
            self._emulator.set_faults(self._wanted.get())
            fault = self._emulator.bus_fault()
            if fault is not None:
                # What had not arrived yet never will.
                self._replies.clear()
            if isinstance(self._bus, SlcanServerBus):
                self._bus.fault = '' if fault is None else fault.name

    def stop(self) -> None:
        """End and wait."""
        self._stop_event.set()
        if self.is_alive():
            self.join()
