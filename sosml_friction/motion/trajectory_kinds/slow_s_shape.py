# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The slow S-shape: one low speed to and fro with turns as long as the plateaus."""

from collections.abc import Mapping, Sequence

from sosml_friction.motion.building_blocks import begin_motion, move_speeds
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_option import PLATEAU, SPEED, SPEEDS, TOP, TURN, options_of


def slow_s_shape(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    speed: float = 0.052,
    plateau_s: float = 3.0,
    turn_s: float = 3.0,
    cycles: int = 4,
    top_speed: float = 0.2,
    scale: Sequence[float] = (1.0,),
) -> Trajectory:
    """
    Return the slow S-shape for all joints at once.

    Plateaus at +speed and -speed joined by turns of ``turn_s``: the whole range between the two
    speeds is passed slowly, and friction against velocity draws its S. The defaults are the speed
    and times of the paper's simulation study.

    :raises TrajectoryError: if joints differ.
    """
    motion, middle, factor = begin_motion('the slow S-shape', start, centre, scale)
    top = move_speeds(top_speed, factor)
    motion.to_and_fro(middle, speed * factor, plateau_s, turn_s, cycles, top)
    return motion.move(middle, top, 0.4).build()


class SlowSShape(TrajectoryKind):
    """The slow S-shape, by :func:`slow_s_shape`."""

    name = 'slow_s_shape'
    label = 'the slow S-shape'
    description = 'one low speed to and fro, with turns as long as the plateaus'
    options = options_of(
        slow_s_shape,
        ('speed', 'speed', 'of the plateaus', SPEED, SPEEDS),
        PLATEAU, TURN,
        ('cycles', 'cycles', 'pairs of half-cycles', '', (1, 100)),
        TOP,
    )  # fmt: skip
    build = staticmethod(slow_s_shape)
