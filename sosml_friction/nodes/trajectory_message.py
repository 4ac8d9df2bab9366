# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory from the message that carries it."""

import numpy as np
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.motion.trajectory import Trajectory


def trajectory_from_message(message: JointTrajectoryMessage) -> Trajectory:
    """
    Return the message's trajectory; its accelerations, efforts and start time are not used.

    :raises TrajectoryError: if points have positions or velocities of differing numbers.
    """
    names = tuple(message.joint_names)
    points = message.points
    times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in points]
    if not names or not points:
        raise TrajectoryError(
            f'the trajectory has {len(points)} points of {len(names)} joints: give at least one '
            'point, or call ~/stop to end the motion'
        )
    with_velocity = any(len(p.velocities) for p in points)
    for i, point in enumerate(points):
        lengths = [len(point.positions)] + ([len(point.velocities)] if with_velocity else [])
        if any(length != len(names) for length in lengths):
            raise TrajectoryError(
                f'point {i} of the trajectory has {len(point.positions)} positions and '
                f'{len(point.velocities)} velocities for {len(names)} joints: give each joint a '
                'position, and velocities at all points or at none'
            )
    n = len(names)
    return Trajectory(
        names,
        np.array(times),
        np.array([p.positions for p in points], dtype=float).reshape(-1, n),
        np.array([p.velocities for p in points], dtype=float).reshape(-1, n)
        if with_velocity
        else None,
    )
