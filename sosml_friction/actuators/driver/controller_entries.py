# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver tells a recording of its controllers."""

from collections.abc import Sequence
from typing import Any

from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.joint_configuration import HostLoop
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
        loop = joint.loop(limit)
        if not isinstance(loop, HostLoop):
            entries[joint.name] = {'kind': ACTUATOR, 'reason': loop}
            continue
        entries[joint.name] = {
            'kind': PD,
            **loop._asdict(),
            'rate': configuration.rate,
            'velocity_window': configuration.velocity_window,
        }
    return entries
