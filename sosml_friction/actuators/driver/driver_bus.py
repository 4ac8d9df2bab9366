# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's bus: lost, tried again, and left with every output off."""

from collections.abc import Callable, Hashable, Sequence

import can

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.cycle import BusCycle
from sosml_friction.actuators.driver.checks import run_start_ups
from sosml_friction.actuators.driver.start_up import Check, Request
from sosml_friction.exceptions import ActuatorError

SHUT_DOWN_TIMEOUT_NS = 20_000_000
SHUT_DOWN_ATTEMPTS = 3
# How often a lost bus is tried again, and how long its first question waits.
RETRY_NS = 100_000_000
PROBE_TIMEOUT_NS = 20_000_000


class DriverBus:
    """
    Exchange frames and survive the loss of the bus; one thread may use it.

    ``error`` says why the bus is lost, '' while it is there. ``deaf``: nobody answered the last
    exchange at all. ``reopen`` may take its time.
    """

    def __init__(
        self,
        bus: can.BusABC,
        clock: Clock,
        actuators: Sequence[Actuator],
        reopen: Callable[[], can.BusABC] | None,
    ) -> None:
        self.cycle = BusCycle(bus, clock, actuators, reopen)
        self._clock = clock
        self._actuators = actuators
        self._commanded = False
        self._retry_ns = 0
        self.begin()

    def begin(self) -> None:
        """Start anew: the bus is there."""
        self.error = ''
        self.deaf = False

    def exchange(self, requests: Sequence[Request], deadline_ns: int) -> set[Hashable]:
        """Send requests, collect replies; return the keys of those that did not come."""
        self._commanded = True
        try:
            missing = self.cycle.exchange(requests, deadline_ns)
        except ActuatorError as error:
            self._lose(error)
            return {request.key for request in requests}
        self.deaf = all(request.key in missing for request in requests)
        return missing

    def start_up(self, actuators: Sequence[Actuator]) -> tuple[Check, ...] | None:
        """Ask actuators anew who they are, reading only; None if the bus is lost meanwhile."""
        try:
            return run_start_ups(
                self.cycle, self._clock, actuators, read_only=True, watchdog=False
            )
        except ActuatorError as error:
            self._lose(error)
            return None

    def _lose(self, error: ActuatorError) -> None:
        self.error = str(error)
        self._retry_ns = self._clock.now_ns() + RETRY_NS

    def recover(self, now_ns: int) -> bool:
        """Try a lost bus again; if somebody answers a harmless question, let all go: True."""
        if now_ns < self._retry_ns:
            return False
        self._retry_ns = now_ns + RETRY_NS
        if not self.cycle.recover():
            return False
        questions = [request for actuator in self._actuators for request in actuator.probe()]
        try:
            missing = self.cycle.exchange(questions, self._clock.now_ns() + PROBE_TIMEOUT_NS)
        except ActuatorError as error:
            self.error = str(error)
            return False
        if len(missing) == len(questions):
            return False
        self.error = ''
        # A motor without a watchdog of its own still has the current of the moment the bus was
        # lost: no question is more urgent than to end that.
        released = [request for own in self._actuators for request in own.release(now_ns)]
        try:
            self.cycle.exchange(released, self._clock.now_ns() + PROBE_TIMEOUT_NS)
        except ActuatorError as error:
            self._lose(error)
        return not self.error

    def shut_down(self) -> None:
        """
        Switch all outputs off, tried even on a faulty bus; one that was lost is opened again once.

        Nothing is sent if nothing was ever commanded.
        """
        if not self._commanded:
            return
        left = list(self._actuators)
        lost, reopened = bool(self.error), False
        for _ in range(SHUT_DOWN_ATTEMPTS):
            try:
                if lost and not reopened:
                    reopened = True
                    self.cycle.recover()
                asked = [(actuator, actuator.shut_down()) for actuator in left]
                missing = self.cycle.exchange(
                    [request for _, own in asked for request in own],
                    self._clock.now_ns() + SHUT_DOWN_TIMEOUT_NS,
                )
            except Exception:
                # Whatever it was, a defect in a CAN driver included: the joint is still driven.
                lost = True
                continue
            left = [
                actuator
                for actuator, own in asked
                if any(request.key in missing for request in own)
            ]
            if not left:
                break
        self._commanded = False
