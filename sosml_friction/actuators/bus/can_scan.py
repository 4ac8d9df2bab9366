# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Who is on the bus: ask every type of actuator, command none."""

import can

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.inquiry import FoundActuator, Inquiry
from sosml_friction.exceptions import ActuatorError

# Another host's cycle would be heard within this time.
LISTEN_NS = 200_000_000


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
