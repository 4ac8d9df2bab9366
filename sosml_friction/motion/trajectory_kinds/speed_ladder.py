# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""T1, the speed ladder: plateaus of rising then falling speed, each in both directions."""

from collections.abc import Mapping, Sequence

from sosml_friction.arrays import FloatArray
from sosml_friction.motion.building_blocks import TrajectoryBuilder, begin_motion, move_speeds
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_option import PLATEAU, RAMP, SPEED, SPEEDS, TOP, options_of


def speed_ladder(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    speeds: Sequence[float] = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7),
    plateau_s: float = 0.8,
    ramp_s: float = 0.3,
    top_speed: float = 0.8,
    scale: Sequence[float] = (1.0,),
) -> Trajectory:
    """
    Return trajectory T1 for all joints at once.

    At each speed every joint goes through its centre forwards and back again, with S-curve ramps
    between rest and plateau, so that the two directions see the same postures: what differs
    between them is friction. Lasts about
    len(speeds) * 2 * (2 plateau_s + 4 ramp_s + 0.5) seconds.

    :param start: present position of each joint, at rest [rad or m]; its order is kept.
    :param centre: middle of the plateaus of each joint [rad or m].
    :raises TrajectoryError: if joints differ.
    """
    motion, middle, factor = begin_motion('the ladder', start, centre, scale)
    top = move_speeds(top_speed, factor)
    add_ladder(motion, middle, speeds, [plateau_s] * len(speeds), ramp_s, top, factor)
    return motion.move(middle, top, 0.4).build()


def add_ladder(
    motion: TrajectoryBuilder,
    middle: FloatArray,
    speeds: Sequence[float],
    plateaus_s: Sequence[float],
    ramp_s: float,
    top_speed: FloatArray,
    scale: FloatArray,
) -> TrajectoryBuilder:
    """Add the ladder, up and then down, each speed with the length of its plateau [s]."""
    steps = list(zip(speeds, plateaus_s, strict=True))
    for speed, plateau_s in [*steps, *reversed(steps)]:
        motion.there_and_back(middle, speed * scale, plateau_s, ramp_s, top_speed)
    return motion


class SpeedLadder(TrajectoryKind):
    """T1, by :func:`speed_ladder`."""

    name = 'speed_ladder'
    role = 'T1'
    label = 'T1'
    description = 'T1: plateaus of rising then falling speed, each in both directions'
    options = options_of(
        speed_ladder,
        ('speeds', 'speeds', 'plateau speeds, taken up and then down', SPEED, SPEEDS),
        PLATEAU, RAMP, TOP,
    )  # fmt: skip
    build = staticmethod(speed_ladder)
