# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The check of a trajectory that was asked for, before a driver follows it."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.robot import JointLimits
from sosml_friction.motion.trajectory import Trajectory

# A velocity left over at the last point, where the joint then holds [rad/s or m/s].
_END_VELOCITY = 0.01


def prepare_trajectory(
    trajectory: Trajectory,
    names: Sequence[str],
    limits: Sequence[JointLimits],
    position: FloatArray,
    tolerance: FloatArray,
) -> Trajectory:
    """
    Check a trajectory as a whole; return it in the order of ``names`` and starting at time 0.

    :param names: the driver's joints.
    :param limits: position and velocity limits of each; extremes between points count too.
    :param position: where the joints are (n,) [rad or m].
    :param tolerance: how far from there the trajectory may start, per joint (n,) [rad or m].
    :raises TrajectoryError: with what is wrong, where, and the numbers.
    """
    names = tuple(names)
    if sorted(trajectory.names) != sorted(names):
        raise TrajectoryError(
            f'the trajectory moves {", ".join(trajectory.names) or "no joint"}: it must name '
            f'{", ".join(names)}, each once'
        )
    wanted = trajectory.ordered(names)
    if wanted.v is not None and np.any(np.abs(wanted.v[-1]) > _END_VELOCITY):
        joint = int(np.argmax(np.abs(wanted.v[-1])))
        raise TrajectoryError(
            f'the trajectory ends with joint {names[joint]} at {wanted.v[-1, joint]:.3g} per '
            'second: let it end at rest'
        )
    distance = np.abs(wanted.q[0] - position)
    for joint, name in enumerate(names):
        if not wanted.t[0] > 0.0 and not distance[joint] <= tolerance[joint]:
            raise TrajectoryError(
                f'the trajectory starts with joint {name} at {wanted.q[0, joint]:.4f}, '
                f'{distance[joint]:.4f} from where it is ({position[joint]:.4f}): start within '
                f'{tolerance[joint]:g}, or give the first point a time above 0 to go there'
            )
    prepared = wanted.from_rest(position)
    _check_limits(prepared, limits)
    return prepared


def _check_limits(trajectory: Trajectory, limits: Sequence[JointLimits]) -> None:
    low, high, fastest = trajectory.extremes()
    for joint, (name, limit) in enumerate(zip(trajectory.names, limits, strict=True)):
        for value, wrong in (
            (low[joint], low[joint] < limit.lower),
            (high[joint], high[joint] > limit.upper),
        ):
            if wrong:
                raise TrajectoryError(
                    f'the trajectory takes joint {name} to {value:.4f}, outside its limits '
                    f'{limit.lower:g} to {limit.upper:g}'
                )
        if fastest[joint] > limit.velocity:
            raise TrajectoryError(
                f'the trajectory moves joint {name} at {fastest[joint]:.4f} per second where its '
                f'limit is {limit.velocity:g}: make it slower'
            )
