# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver tells a recording of its controllers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sosml_friction.actuators.driver.configuration import RMD_X, TORQUE_MODE, DriverConfiguration
from sosml_friction.bags.controllers import ACTUATOR, PD
from sosml_friction.model.robot import JointLimits


def controller_entries(
    configuration: DriverConfiguration, limits: Sequence[JointLimits]
) -> dict[str, dict[str, Any]]:
    """
    Return an entry for each joint, as :mod:`sosml_friction.bags.controllers` describes it.

    :param limits: of the URDF; the lower of its effort and the current limit counts.
    """
    entries: dict[str, dict[str, Any]] = {}
    for joint, limit in zip(configuration.joints, limits, strict=True):
        if joint.driver != RMD_X:
            reason = f'the loop of {joint.name} is in its servo'
            entries[joint.name] = {'kind': ACTUATOR, 'reason': reason}
        elif joint.mode != TORQUE_MODE:
            reason = f"{joint.name} is in mode {joint.mode}, the motor's own loop"
            entries[joint.name] = {'kind': ACTUATOR, 'reason': reason}
        else:
            entries[joint.name] = {
                'kind': PD,
                'kp': joint.kp,
                'kd': joint.kd,
                'limit': min(joint.current_limit * joint.torque_constant, limit.effort),
                'rate_limit': joint.current_rate_limit * joint.torque_constant,
                'rate': configuration.rate,
                'velocity_window': configuration.velocity_window,
            }
    return entries
