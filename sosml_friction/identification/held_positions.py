# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that an encoder goes on reporting while its joint moves."""

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.glitches import step_speeds
from sosml_friction.identification.marked_samples import without_marked
from sosml_friction.regression.kernels import runs

#: Fewest positions in a row that are the same. Fewer are samples that were lost, which leave less
#: of a hole than is bridged. Chosen, no measurement.
_FEWEST = 5
#: Most times that a position is held. A joint that is held more often sticks, and slips faster
#: than it ever moves. Chosen, no measurement.
_MOST = 5


def held_positions(time: FloatArray, q: FloatArray) -> BoolArray:
    """
    Return which positions (N,) of a joint repeat an older one: then it leaps, too fast.

    It is farther then than it ever goes in a step, as of
    :func:`~sosml_friction.identification.glitches.step_speeds`. Few times only: a joint that
    sticks and slips does so as well.

    :param time: stamps (N,) [s].
    :param q: positions (N,) [rad or m], NaN where not known.
    """
    found = np.zeros(len(q), dtype=bool)
    rows = np.flatnonzero(np.isfinite(q))
    speed, limit = step_speeds(time[rows], q[rows])
    held = [
        (begin, end)
        for begin, end in runs(speed == 0.0)
        if end - begin + 1 >= _FEWEST and end < len(speed) and abs(speed[end]) > limit
    ]
    for begin, end in held if len(held) <= _MOST else ():
        found[rows[begin + 1 : end + 1]] = True
    return found


def without_held(log: JointLog) -> tuple[JointLog, dict[str, str]]:
    """Return the samples without positions that are held, and what is said of them by joint."""
    return without_marked(log, held_positions, _told)


def _told(time: FloatArray, q: FloatArray, found: BoolArray) -> str:
    parts = runs(found)
    begin, end = max(parts, key=lambda part: part[1] - part[0])
    leap = max(abs(float(q[stop] - q[stop - 1])) for _, stop in parts)
    return (
        f'is held {len(parts)} time{"s" if len(parts) > 1 else ""} and then leaps, by up to '
        f'{leap:.3g}, faster than it ever goes; the longest, of '
        f'{time[end - 1] - time[begin]:.3g} s, begins at {time[begin]:.4g} s: these samples are '
        'left out'
    )
