# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What must be right before joints are driven: limits, identifiers, bus load, the start-ups."""

import math
from collections.abc import Sequence

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.cycle import BusCycle
from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.start_up import ANSWER_TIMEOUT_NS, Check, StartUp
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import JointLimits, Robot

# A standard frame of 8 bytes with its pause: without and with the worst stuffing.
FRAME_BITS = 111
FRAME_BITS_STUFFED = 135
# How long the bus is listened to at a time.
_LISTEN_NS = 20_000_000


def check_robot(robot: Robot, names: tuple[str, ...], who: str) -> None:
    """
    Refuse a model of other joints, and limits that limit nothing, NaN among them.

    :raises ConfigurationError: with the joint and its limit.
    """
    if robot.names != names:
        raise ConfigurationError(
            f'the model has the joints {", ".join(robot.names)}, the {who} {", ".join(names)}: '
            'name the same, in the same order'
        )
    for name, own in zip(robot.names, robot.limits, strict=True):
        for what, value in (('velocity', own.velocity), ('effort', own.effort)):
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigurationError(
                    f'the URDF gives joint {name} the {what} limit {value:g}: give a positive '
                    'number'
                )
        if not (math.isfinite(own.lower) and math.isfinite(own.upper) and own.lower < own.upper):
            raise ConfigurationError(
                f'the URDF limits joint {name} to {own.lower:g} to {own.upper:g}: give two '
                'numbers, the lower one first'
            )


def make_actuators(
    configuration: DriverConfiguration, limits: Sequence[JointLimits]
) -> list[Actuator]:
    """Build the actuator of each joint; one identifier for two is a ConfigurationError."""
    actuators = [
        Actuator.kind(joint.driver)(
            joint,
            limit,
            configuration.rate,
            margin=configuration.limit_margin,
            stop_deceleration=configuration.stop_deceleration,
        )
        for joint, limit in zip(configuration.joints, limits, strict=True)
    ]
    by_id: dict[int, str] = {}
    for actuator in actuators:
        other = by_id.setdefault(actuator.reply_id, actuator.name)
        if other != actuator.name:
            raise ConfigurationError(
                f'joints {other} and {actuator.name} both answer from {actuator.reply_id:#05x}: '
                'give each its own identifier'
            )
    return actuators


def bus_load(
    actuators: Sequence[Actuator], configuration: DriverConfiguration
) -> tuple[float, str]:
    """Return the worst share of the bit rate the cycle takes, and it as a sentence."""
    frames = sum(actuator.frames_per_cycle for actuator in actuators)
    least, worst = (
        frames * configuration.rate * bits / configuration.bitrate
        for bits in (FRAME_BITS, FRAME_BITS_STUFFED)
    )
    text = (
        f'{frames:g} frames per cycle at {configuration.rate:g} Hz of {FRAME_BITS} to '
        f'{FRAME_BITS_STUFFED} bits take {100 * least:.1f} to {100 * worst:.1f} % of '
        f'{configuration.bitrate} bit/s'
    )
    return worst, text


def run_start_ups(
    cycle: BusCycle,
    clock: Clock,
    actuators: Sequence[Actuator],
    *,
    read_only: bool = True,
    watchdog: bool = True,
) -> tuple[Check, ...]:
    """
    Run the start-ups of ``actuators`` and return what each step found, joint by joint.

    ``read_only`` writes nothing to any motor: its ``watchdog``, which takes a second to judge, is
    never set.

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
