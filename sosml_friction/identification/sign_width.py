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
from sosml_friction.regression.signals import WIDEST_SIGN


def with_sign_widths(
    model: RobotModelFile, logs: Sequence[JointLog], robot: Robot, joints: Sequence[str]
) -> RobotModelFile:
    """
    Return the model with v0 of each sign that it does not state, as the weak form finds it.

    Other terms of a law that is fitted would make up for it at slow motion, and do so before it is
    sure: beside a jump, a Stribeck term took the exponent 2 and half of its size. Of several
    recordings it is the median of those in which a smooth sign fits better than a jump.

    :param logs: recordings; their joints are the robot's.
    :param joints: whose law is fitted.
    """
    unknown = [
        i
        for i, name in enumerate(robot.names)
        if name in joints and not model.joints[name].sign_width
    ]
    found: dict[int, list[float]] = {i: [] for i in unknown}
    for log in logs if unknown else ():
        form = WeakForm(log, robot)
        for i in unknown:
            try:
                rows = form.rows(i)
                top = float(np.quantile(np.abs(rows.mean_v[rows.keep]), 0.99))
                width = rows.likeliest_smoothing()
                if width < WIDEST_SIGN * top:
                    found[i].append(width)
            except DataError:
                # Too short, or hardly moved: it shows nothing.
                continue
    changed = dict(model.joints)
    for i, widths in found.items():
        shown = [width for width in widths if width > 0.0]
        if shown:
            name, width = robot.names[i], float(np.median(shown))
            friction = changed[name].friction
            if friction is not None:
                friction = replace(friction, smoothing_velocity=width)
            changed[name] = replace(changed[name], friction=friction, smoothing_velocity=width)
    return replace(model, joints=changed)
