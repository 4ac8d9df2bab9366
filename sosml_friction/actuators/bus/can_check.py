# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A bus for a person to look at: who is there, and the driver's start-up, read-only."""

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import can

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.cycle import BusCycle
from sosml_friction.actuators.bus.inquiry import FoundActuator, Inquiry
from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.actuators.driver import checks
from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.start_up import Check
from sosml_friction.exceptions import ActuatorError
from sosml_friction.model.model_folder import read_model
from sosml_friction.share import share_directory

BUS = 'bus'
# Another host's cycle would be heard within this time.
LISTEN_NS = 200_000_000


def check_bus(
    values: Mapping[str, Any], interface: str, channel: str, bitrate: int
) -> tuple[Check, ...]:
    """
    Return what every step of the start-up found, and whether the cycle fits the bit rate.

    Nothing is written to an actuator and no motor is commanded; a servo bridge, which answers
    nothing else, is told "off". ``values`` are the parameters of driver_node, flat.

    :raises ConfigurationError: if they do not fit each other or the model.
    :raises ActuatorError: if the bus cannot be opened or fails, or another host is driving.
    """
    configuration = DriverConfiguration.from_parameters({**values, 'can_bitrate': bitrate})
    model = values.get('model') or share_directory() / 'config' / 'exoskeleton'
    robot = read_model(Path(model)).make_robot()
    checks.check_robot(robot, configuration.names, 'parameters')
    actuators = checks.make_actuators(configuration, robot.limits)
    worst, load = checks.bus_load(actuators, configuration)
    fits = Check(BUS, 'load', load, 'lower rate or raise can_bitrate' if worst > 1.0 else '')
    bus = open_bus(interface, channel, bitrate)
    clock = Clock()
    cycle = BusCycle(bus, clock, actuators)
    try:
        cycle.listen(clock.now_ns() + LISTEN_NS)
        if cycle.counters.intruders:
            raise ActuatorError(
                'another host commands these actuators: stop it first, or they answer two and a '
                'servo that it drives is switched off'
            )
        return fits, *checks.run_start_ups(cycle, clock, actuators, read_only=True)
    finally:
        # What was found stands, whether the adapter says goodbye or not.
        with contextlib.suppress(can.CanError, OSError):
            bus.shutdown()


def scan_bus(inquiry: Inquiry) -> list[FoundActuator]:
    """
    Return who answers, by identifier; read-only.

    Each type of actuator asks in its own way. A servo bridge answers nothing but a command: it is
    told "off", which it is anyway while no driver runs. So the bus is listened to first, and where
    somebody else talks nothing is asked.

    :raises ActuatorError: if the bus fails, or another host is talking on it.
    """
    kinds = Actuator.registry.values()
    try:
        for frame in inquiry.listen(LISTEN_NS):
            if not any(kind.speaks_unasked(frame) for kind in kinds):
                raise ActuatorError(
                    f'another host is talking on the bus (frame {frame} was heard before anything '
                    'was asked): stop it first, or the motors answer two'
                )
        found = [actuator for kind in kinds for actuator in kind.scan(inquiry)]
    except (can.CanError, OSError) as error:
        raise ActuatorError(
            f'the CAN bus failed while it was scanned ({" ".join(str(error).split())}): check '
            'the adapter, the bit rate and the power of the bus'
        ) from error
    return sorted(found, key=lambda actuator: actuator.can_id)
