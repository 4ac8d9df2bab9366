# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A bus whose other end is the emulator, in emulated time."""

from __future__ import annotations

import errno
import heapq
import os
from typing import Any

import can
from emulated_clock import EmulatedClock

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.emulator.emulator import ExoskeletonEmulator

# Frames that wait in the kernel while the controller is off the bus (txqueuelen).
_QUEUE = 10
# Bits of the identifier of a SocketCAN error frame.
_BUS_OFF = 0x040
_RESTARTED = 0x100


class LockstepBus(can.BusABC):
    """
    Hand frames to an emulator and its replies back when they are due on an emulated clock.

    Waiting for a frame moves the clock to the next reply or to the end of the wait; nothing else
    here takes time. The emulator's faults of the bus look as on SocketCAN: ``bus_off`` gives an
    error frame, 10 frames that are kept back and leave at its end, and ENOBUFS for more;
    ``tx_full`` fails to send, with its errno or without one as python-can does; ``adapter_gone``
    is ENODEV. Not modelled: the time frames take on the wire, arbitration.
    """

    def __init__(self, emulator: ExoskeletonEmulator, clock: EmulatedClock, **kwargs: Any) -> None:
        self._emulator = emulator
        self._clock = clock
        self._replies: list[tuple[int, int, Frame | can.Message]] = []
        self._queue: list[Frame] = []
        self._off = False
        self._count = 0
        self._can_protocol = can.CanProtocol.CAN_20
        super().__init__(channel='lockstep', **kwargs)
        self.channel_info = 'emulated exoskeleton in lockstep'

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Give the emulator a frame at the present emulated time."""
        self._catch_up()
        frame = Frame.from_message(msg)
        if frame is None:
            return
        fault = self._emulator.bus_fault()
        if fault is None:
            self._hand_over(frame)
        elif fault.name == 'tx_full':
            raise can.CanOperationError('Transmit buffer full', int(fault.number('errno')) or None)
        elif len(self._queue) < _QUEUE:
            self._queue.append(frame)
        else:
            raise can.CanOperationError('Failed to transmit: No buffer space', errno.ENOBUFS)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next reply within ``timeout`` [s] of emulated time; None waits for ever."""
        self._catch_up()
        now_ns = self._clock.now_ns()
        due_ns = self._replies[0][0] if self._replies else None
        if due_ns is None or (timeout is not None and due_ns > now_ns + round(timeout * 1e9)):
            if timeout is not None:
                self._clock.sleep_until_ns(now_ns + round(timeout * 1e9))
            return None
        self._clock.sleep_until_ns(due_ns)
        _, _, frame = heapq.heappop(self._replies)
        message = frame.to_message() if isinstance(frame, Frame) else frame
        message.timestamp = self._clock.now_ns() * 1e-9
        message.is_rx = True
        return message

    def _hand_over(self, frame: Frame) -> None:
        for t_ns, reply in self._emulator.handle(frame, self._clock.now_ns()):
            self._push(t_ns, reply)

    def _push(self, t_ns: int, frame: Frame | can.Message) -> None:
        self._count += 1
        heapq.heappush(self._replies, (t_ns, self._count, frame))

    def _catch_up(self) -> None:
        """Take what the emulator sent by itself, and what became of the bus."""
        now_ns = self._clock.now_ns()
        self._emulator.advance(now_ns)
        for t_ns, frame in self._emulator.take_sent():
            self._push(t_ns, frame)
        fault = self._emulator.bus_fault()
        if fault is not None and fault.name == 'adapter_gone':
            raise OSError(errno.ENODEV, os.strerror(errno.ENODEV))
        off = fault is not None and fault.name == 'bus_off'
        if off and not self._off:
            # What had not arrived yet never will.
            self._replies.clear()
            self._push(now_ns, _error_frame(_BUS_OFF))
        elif self._off and not off:
            self._push(now_ns, _error_frame(_RESTARTED))
            waiting, self._queue = self._queue, []
            for frame in waiting:
                self._hand_over(frame)
        self._off = off

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return self.recv(timeout), False


def _error_frame(kind: int) -> can.Message:
    return can.Message(
        arbitration_id=kind, is_extended_id=False, is_error_frame=True, dlc=8, data=bytes(8)
    )
