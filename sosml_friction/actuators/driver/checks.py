# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What must fit before a driver is made: limits, identifiers, the load of the bus."""

import math
from collections.abc import Sequence

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import JointLimits, Robot

# A standard frame of 8 bytes with its pause: without and with the worst stuffing.
FRAME_BITS = 111
FRAME_BITS_STUFFED = 135


def check_robot(robot: Robot, names: tuple[str, ...], who: str) -> None:
    """
    Refuse a model of other joints, and limits that limit nothing: comparison with NaN is false.

    :param who: has the joints ``names``.
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
