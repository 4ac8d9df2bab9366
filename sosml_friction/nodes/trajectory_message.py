# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory from the message that carries it, and into it."""

import numpy as np
from builtin_interfaces.msg import Duration
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint

from sosml_friction.bags.serialization import serialize
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


def message_from_trajectory(trajectory: Trajectory) -> JointTrajectoryMessage:
    """Return the message that carries a trajectory, its stamp 0: it begins when it arrives."""
    message = JointTrajectoryMessage(joint_names=list(trajectory.names))
    for k, t in enumerate(trajectory.t):
        seconds, nanoseconds = divmod(round(t * 1e9), 1_000_000_000)
        message.points.append(
            JointTrajectoryPoint(
                positions=trajectory.q[k].tolist(),
                velocities=[] if trajectory.v is None else trajectory.v[k].tolist(),
                time_from_start=Duration(sec=seconds, nanosec=nanoseconds),
            )
        )
    return message


def trajectory_bytes(message: JointTrajectoryMessage) -> bytes:
    """
    Return the CDR bytes of a trajectory, to its last byte and none beyond.

    rclpy reserves more than it fills, eight bytes for each empty array, and strict readers refuse
    what they do not know.
    """
    end = _string(8, message.header.frame_id)  # behind the stamp
    end = _aligned(end, 4) + 4
    for name in message.joint_names:
        end = _string(end, name)
    end = _aligned(end, 4) + 4
    for point in message.points:
        for values in (point.positions, point.velocities, point.accelerations, point.effort):
            end = _aligned(end, 4) + 4
            if len(values):
                end = _aligned(end, 8) + 8 * len(values)
        end = _aligned(end, 4) + 8
    # Offsets are counted behind the encapsulation header.
    return serialize(message)[: 4 + end]


def _aligned(offset: int, size: int) -> int:
    return -(-offset // size) * size


def _string(offset: int, text: str) -> int:
    """Return where a string ends that is written at ``offset``: its length, its bytes, a zero."""
    return _aligned(offset, 4) + 4 + len(text.encode()) + 1
