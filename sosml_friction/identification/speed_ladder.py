# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""T1, the speed ladder: plateaus of rising then falling speed, each in both directions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.identification.motion import Motion
from sosml_friction.model.trajectory import Trajectory


def speed_ladder(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    speeds: Sequence[float],
    plateau_s: float = 0.8,
    ramp_s: float = 0.3,
    top_speed: float = 0.8,
) -> Trajectory:
    """
    Return trajectory T1 for all joints at once.

    At each speed every joint goes through its centre forwards and back again, with S-curve ramps
    between rest and plateau, so that the two directions see the same postures: what differs
    between them is friction. Lasts about
    len(speeds) * 2 * (2 plateau_s + 4 ramp_s + 0.5) seconds.

    :param start: present position of each joint, at rest [rad or m]; its order is the
        trajectory's.
    :param centre: middle of the plateaus of each joint [rad or m].
    :param speeds: plateau speeds, taken as given and then backwards [rad/s or m/s], positive.
    :param plateau_s: length of a plateau [s].
    :param ramp_s: length of a ramp between rest and plateau [s].
    :param top_speed: limit of the moves between plateaus [rad/s or m/s].
    :raises TrajectoryError: if joints differ or a number is not positive.
    """
    if set(start) != set(centre):
        raise TrajectoryError(
            f'the ladder has centres for {", ".join(centre)} where the robot reports '
            f'{", ".join(start)}: name the same joints'
        )
    if not speeds or not all(x > 0.0 for x in (*speeds, plateau_s, ramp_s, top_speed)):
        raise TrajectoryError(
            f'the ladder has speeds {list(speeds)}, plateau {plateau_s} s, ramp {ramp_s} s and '
            f'top speed {top_speed}: all must be positive and there must be a speed'
        )
    names = tuple(start)
    middle = np.array([centre[name] for name in names])
    motion = Motion(names, np.array([start[name] for name in names]))
    for speed in [*speeds, *reversed(speeds)]:
        v = np.full(len(names), float(speed))
        motion.move(middle - 0.5 * v * (plateau_s + ramp_s), top_speed, 0.4)
        for direction in (1.0, -1.0):
            motion.ramp(direction * v, ramp_s).hold(plateau_s).ramp(0.0 * v, ramp_s)
    return motion.move(middle, top_speed, 0.4).build()
