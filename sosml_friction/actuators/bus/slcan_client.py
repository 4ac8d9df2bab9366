# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""python-can's slcan interface, read in blocks."""

import os
import select
import time
from typing import Any

import can
from can.interfaces.slcan import slcanBus

from sosml_friction.actuators.bus.slcan_lines import SlcanLines

#: Lines without a frame that one wait skips, as many as a drain takes frames: no flood of them
#: keeps a cycle.
_MOST_SKIPPED = 256


class SlcanClient(slcanBus):
    """
    Speak slcan as python-can does, but read what is there at once instead of byte by byte.

    python-can's own reader costs three system calls a byte and waits a millisecond when there is
    nothing: a 500 Hz cycle cannot afford either. Only reading lines differs; frames are written
    and parsed by python-can. A line that is no frame is skipped: there, one ends the wait, and
    frames that lie behind an acknowledgement are not seen by a wait of 0. What cannot be parsed
    is counted in ``malformed``; a bell, by which an adapter refuses a frame or a command (off the
    bus, queue full), in ``refused``: python-can drops it without a word.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self._received = SlcanLines()
        self._read_all = False
        self.malformed = 0
        self.refused = 0
        super().__init__(*args, **kwargs)

    def _read(self, timeout: float | None) -> str | None:
        descriptor = self.serialPortOrig.fileno()
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            line = self._received.pop()
            if line is not None and line.endswith('\a'):
                self.refused += 1
                continue
            if line is not None:
                return line + '\r'
            wait = None if deadline is None else max(0.0, deadline - time.monotonic())
            try:
                ready, _, _ = select.select([descriptor], [], [], wait)
                if not ready:
                    self._read_all = True
                    return None
                data = os.read(descriptor, 4096)
            except BlockingIOError:
                continue
            except (OSError, ValueError) as error:
                raise can.CanOperationError(f'could not read from slcan: {error}') from error
            if not data:
                raise can.CanOperationError('the slcan adapter closed the connection')
            self._received.feed(data)

    def flush(self) -> None:
        """Forget what was received but not read."""
        self._received.clear()
        super().flush()

    def shutdown(self) -> None:
        """Close the channel and the port, also when the adapter is gone."""
        try:
            super().shutdown()
        except can.CanOperationError:
            self.serialPortOrig.close()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        deadline = None if timeout is None else time.monotonic() + timeout
        self._read_all = False
        for _ in range(_MOST_SKIPPED):
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            try:
                message, filtered = super()._recv_internal(left)
            except (ValueError, IndexError, KeyError):
                self.malformed += 1
                continue
            if message is not None or self._read_all:
                return message, filtered
        return None, False
