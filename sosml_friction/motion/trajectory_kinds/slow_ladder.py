# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""T3, the slow ladder: long plateaus at low speeds, each in both directions."""

from collections.abc import Mapping, Sequence

from sosml_friction.motion.building_blocks import begin_motion, move_speeds
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_kinds.speed_ladder import add_ladder
from sosml_friction.motion.trajectory_option import RAMP, SPEED, SPEEDS, TOP, WAY, options_of


def slow_ladder(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    speeds: Sequence[float] = (0.01, 0.015, 0.02, 0.03, 0.05, 0.08),
    plateau_s: float = 1.2,
    way: float = 0.025,
    ramp_s: float = 0.3,
    top_speed: float = 0.2,
    scale: Sequence[float] = (1.0,),
) -> Trajectory:
    """
    Return trajectory T3 for all joints at once.

    A speed ladder whose slow plateaus last longer: at speed w for max(plateau_s, way / w), because
    the velocity of a window is known no better than the encoder's resolution over its way.

    :raises TrajectoryError: if joints differ.
    """
    motion, middle, factor = begin_motion('the slow ladder', start, centre, scale)
    top = move_speeds(top_speed, factor)
    plateaus = [max(plateau_s, way / speed) for speed in speeds]
    add_ladder(motion, middle, speeds, plateaus, ramp_s, top, factor)
    return motion.move(middle, top, 0.4).build()


class SlowLadder(TrajectoryKind):
    """T3, by :func:`slow_ladder`."""

    name = 'slow_ladder'
    role = 'T3'
    label = 'T3'
    description = 'T3: long plateaus at low speeds, each in both directions'
    options = options_of(
        slow_ladder,
        ('speeds', 'speeds', 'plateau speeds, taken up and then down', SPEED, SPEEDS),
        ('plateau', 'plateau_s', 'least length of a plateau', 's', (0.1, 60.0)),
        ('way', 'way', 'least way of a plateau', WAY, (1e-6, 10.0)),
        RAMP, TOP,
    )  # fmt: skip
    build = staticmethod(slow_ladder)
