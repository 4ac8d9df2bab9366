# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One exchange on the bus: all requests out, then all replies in, until one deadline."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass

import can

from sosml_friction.actuators.actuator import Actuator, Request
from sosml_friction.actuators.clock import Clock
from sosml_friction.actuators.frame import Frame
from sosml_friction.exceptions import ActuatorError, CanProtocolError

# More frames than this before a cycle are not late replies but a flood.
_DRAIN_LIMIT = 256


@dataclass
class BusCounters:
    """
    Count frames since the start.

    ``stale``: from a known actuator but not asked for now (late, double, unsolicited);
    ``foreign``: from an identifier nobody here talks to; ``undecodable``: a known identifier with
    bytes that are no reply; ``missed``: requests without a reply by the deadline.
    """

    sent: int = 0
    received: int = 0
    stale: int = 0
    foreign: int = 0
    undecodable: int = 0
    missed: int = 0


class BusCycle:
    """
    Own a python-can bus and exchange requests for replies on it. One thread may use it.

    Replies are matched by (identifier, command byte) or (identifier, sequence), so that a late or
    foreign frame is never taken for the answer; each goes to its actuator with the time it was
    received.
    """

    def __init__(self, bus: can.BusABC, clock: Clock, actuators: Iterable[Actuator]) -> None:
        self._bus = bus
        self._clock = clock
        self._actuators = {actuator.reply_id: actuator for actuator in actuators}
        self.counters = BusCounters()

    def exchange(self, requests: Sequence[Request], deadline_ns: int) -> set[Hashable]:
        """
        Send all requests, collect their replies; return the keys of those that did not come.

        What lies in the receive buffer beforehand is dropped as stale. At the deadline, what has
        arrived by then is still read.

        :raises ActuatorError: if the bus fails.
        """
        counters = self.counters
        try:
            self._drain()
            for request in requests:
                self._bus.send(request.frame.to_message())
                counters.sent += 1
            pending = {request.key for request in requests}
            late = 0
            while pending and late < _DRAIN_LIMIT:
                timeout = max(0.0, (deadline_ns - self._clock.now_ns()) * 1e-9)
                message = self._bus.recv(timeout)
                if message is None:
                    if timeout > 0.0 and self._clock.now_ns() < deadline_ns:
                        continue
                    break
                late += timeout == 0.0
                self._take(message, self._clock.now_ns(), pending)
        except (can.CanError, OSError) as error:
            reason = ' '.join(str(error).split())
            raise ActuatorError(
                f'the CAN bus failed ({reason}): when it is back, clean up and configure the '
                'driver'
            ) from error
        counters.missed += len(pending)
        return pending

    def _drain(self) -> None:
        for _ in range(_DRAIN_LIMIT):
            message = self._bus.recv(0.0)
            if message is None:
                return
            self._take(message, 0, set())

    def _take(self, message: can.Message, stamp_ns: int, pending: set[Hashable]) -> None:
        counters = self.counters
        counters.received += 1
        frame = Frame.from_message(message)
        actuator = None if frame is None else self._actuators.get(frame.can_id)
        if frame is None or actuator is None:
            counters.foreign += 1
            return
        try:
            key = actuator.key(frame)
            if key not in pending:
                counters.stale += 1
                return
            actuator.accept(frame, stamp_ns)
        except CanProtocolError:
            counters.undecodable += 1
            return
        pending.discard(key)
