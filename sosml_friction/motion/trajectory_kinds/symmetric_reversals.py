# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""T2, symmetric reversals: trains of short half-cycles at low speeds."""

from collections.abc import Mapping, Sequence

from sosml_friction.motion.building_blocks import begin_motion, move_speeds
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_option import PLATEAU, SPEED, SPEEDS, TOP, TURN, options_of


def symmetric_reversals(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    speeds: Sequence[float] = (0.02, 0.04, 0.08),
    plateau_s: float = 0.65,
    turn_s: float = 0.3,
    cycles: int = 3,
    top_speed: float = 0.2,
    scale: Sequence[float] = (1.0,),
) -> Trajectory:
    """
    Return trajectory T2 for all joints at once.

    At each speed a train of half-cycles, to and fro through the centre, turns through zero
    velocity without a rest. From a start at the centre the velocity is odd in time about the
    middle of the trajectory, v(T - t) = -v(t): what is even in velocity is drift or an offset, not
    friction.

    :param plateau_s: with an encoder of 16 bit the evaluation needs 0.55 s of it.
    :raises TrajectoryError: if joints differ.
    """
    motion, middle, factor = begin_motion('the train of reversals', start, centre, scale)
    top = move_speeds(top_speed, factor)
    for speed in [*speeds, *reversed(speeds)]:
        motion.to_and_fro(middle, speed * factor, plateau_s, turn_s, cycles, top)
    return motion.move(middle, top, 0.4).build()


class SymmetricReversals(TrajectoryKind):
    """T2, by :func:`symmetric_reversals`."""

    name = 'symmetric_reversals'
    role = 'T2'
    label = 'T2'
    description = 'T2: trains of short half-cycles at low speeds, to and fro without a rest'
    options = options_of(
        symmetric_reversals,
        ('speeds', 'speeds', 'of the half-cycles, up and then down', SPEED, SPEEDS),
        PLATEAU, TURN,
        ('cycles', 'cycles', 'pairs of half-cycles at each speed', '', (1, 100)),
        TOP,
    )  # fmt: skip
    build = staticmethod(symmetric_reversals)
