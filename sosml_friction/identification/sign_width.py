# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Over which velocity friction changes its sign, where the model does not say."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.weak_form import WeakForm
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot


def with_sign_widths(
    model: RobotModelFile, logs: Sequence[JointLog], robot: Robot
) -> RobotModelFile:
    """
    Return the model with v0 of each sign that it does not state, as the weak form finds it.

    How friction turns around is no cause, and other terms would make up for it at slow motion. Of
    several recordings it is the median of those that show that the sign is no jump; where none
    does, the sign stays what it is.

    :param logs: recordings; their joints are the robot's.
    """
    unknown = [i for i, name in enumerate(robot.names) if not model.joints[name].sign_width]
    found: dict[int, list[float]] = {i: [] for i in unknown}
    for log in logs if unknown else ():
        form = WeakForm(log, robot)
        for i in unknown:
            try:
                found[i].append(form.rows(i).smoothing())
            except DataError:
                # Too short, or hardly moved: it shows nothing.
                continue
    joints = dict(model.joints)
    for i, widths in found.items():
        shown = [width for width in widths if width > 0.0]
        if shown:
            name, width = robot.names[i], float(np.median(shown))
            friction = joints[name].friction
            if friction is not None:
                friction = replace(friction, smoothing_velocity=width)
            joints[name] = replace(joints[name], friction=friction, smoothing_velocity=width)
    return replace(model, joints=joints)
