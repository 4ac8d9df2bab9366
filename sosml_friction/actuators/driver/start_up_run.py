# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Run the start-ups of actuators on a bus, all joints side by side."""

from collections.abc import Sequence

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.cycle import BusCycle
from sosml_friction.actuators.driver.start_up import ANSWER_TIMEOUT_NS, Check, StartUp

_LISTEN_NS = 20_000_000


def run_start_ups(
    cycle: BusCycle,
    clock: Clock,
    actuators: Sequence[Actuator],
    *,
    read_only: bool = True,
    watchdog: bool = True,
) -> tuple[Check, ...]:
    """
    Run the start-up of ``actuators`` and return what each step found, joint by joint.

    :param read_only: write nothing to any motor: the motor's watchdog is judged, never set.
    :param watchdog: judge it, which takes a second.
    :raises ActuatorError: if the bus fails.
    """
    start_ups = [
        StartUp(own.name, own.start_up(read_only=read_only, watchdog=watchdog), own.silence())
        for own in actuators
    ]
    while not all(own.done for own in start_ups):
        _listen(cycle, clock, start_ups)
        asked = [own.requests() for own in start_ups]
        requests = [request for own in asked for request in own]
        end_ns = clock.now_ns() + ANSWER_TIMEOUT_NS
        missing = cycle.exchange(requests, end_ns) if requests else set()
        for own, mine in zip(start_ups, asked, strict=True):
            own.take(missing, mine)
    return tuple(check for own in start_ups for check in own.checks)


def _listen(cycle: BusCycle, clock: Clock, start_ups: Sequence[StartUp]) -> None:
    pausing = [own for own in start_ups if own.pause_ns]
    if not pausing:
        return
    end_ns = clock.now_ns() + max(own.pause_ns for own in pausing)
    while clock.now_ns() < end_ns and not all(own.heard() for own in pausing):
        cycle.listen(min(end_ns, clock.now_ns() + _LISTEN_NS))
