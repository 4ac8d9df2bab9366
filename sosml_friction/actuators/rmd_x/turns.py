# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which whole turns an encoder lost while it was off."""

import math

from sosml_friction.model.robot import JointLimits

# No motor winds up further than this before it is looked at.
_MOST_TURNS = 1000


def lost_turns(q: float, limits: JointLimits, margin: float, turn: float) -> list[int]:
    """
    Return every k, by size, for which q + k * turn is inside the joint's band.

    The band is lower - margin to upper + margin. One k: that many turns were lost. None: the
    encoder's zero is wrong. Several: the band is wider than a turn, and nobody can tell.

    :param q: the angle by the encoder [rad or m].
    :param turn: the angle of one turn at the joint [rad or m], > 0.
    """
    low, high = limits.lower - margin, limits.upper + margin
    if not math.isfinite(q):
        return []
    first, last = math.ceil((low - q) / turn), math.floor((high - q) / turn)
    if max(abs(first), abs(last)) > _MOST_TURNS:
        return []
    return sorted(range(first, last + 1), key=abs)
