# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Dahl's state of friction: a sign of motion that sticks.

dz/dx = (1 - z sgn(dx)) / displacement, integrated exactly over each displacement: stable however
stiff, and it does not creep under a constant load as a smooth sign does. Friction of another level
than 1 follows it alike.
"""

import math

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.compiled import compiled

#: S / C for which what follows is computed. S is right to a few percent from 0.2 C to 0.8 C
#: (``python -m validation.bristles``).
SHARE = 0.5


def dahl_step(z: FloatArray, dx: FloatArray, displacement: FloatArray | float) -> FloatArray:
    """
    Return z after a displacement ``dx``, same shape.

    :param displacement: over which z approaches the sign of motion, positive [rad or m].
    """
    target = np.sign(dx)
    return np.asarray(target + (z - target) * np.exp(-np.abs(dx) / displacement))


def dahl_path(x: FloatArray, displacement: float) -> FloatArray:
    """
    Return z (N,), between -1 and 1, along a path x (N,) from z = 0.

    After a reversal it approaches the new sign over a few ``displacement``, at rest it stays, and
    how fast the path is run through does not matter. A path that turns around between samples is
    followed to where it does: turned around at a sample, z would be half an interval late.

    :param displacement: over which z approaches the sign of motion, positive [rad or m].
    """
    return np.asarray(_path(x, *_turning_points(x), displacement, np.ones(len(x)), 0.0))


def following_path(x: FloatArray, displacement: float, level: FloatArray) -> FloatArray:
    """
    Return y (N,) along a path: what friction has more for a Stribeck term, per unit of it.

    Bristles of stiffness s_0 have F' = s_0 (q' - F |q'| / g). With f = F / C, g = C (1 + r l) and
    x_0 = C / s_0 that is df/d|x| = (sgn(q') - f / (1 + r l)) / x_0: z of :func:`dahl_path` for
    r = 0, and y = (f - z) / r. Where l changes little within x_0, y is l times the sign. It hardly
    depends on r = S / C, for which :data:`SHARE` stands.

    :param level: l at the samples (N,), 1 where the path turns around.
    """
    turns = _turning_points(x)
    f, z = (_path(x, *turns, displacement, level, share) for share in (SHARE, 0.0))
    return np.asarray((f - z) / SHARE)


def _turning_points(x: FloatArray) -> tuple[FloatArray, IndexArray]:
    """
    Return where a path turns around, and after which sample each is.

    By the parabola through three samples, of which the middle one is furthest: exact while the
    acceleration stays.
    """
    rise, fall = np.diff(x)[:-1], np.diff(x)[1:]
    k = np.flatnonzero(rise * fall < 0.0)
    rise, fall = rise[k], fall[k]
    turning = x[k + 1] + (rise + fall) ** 2 / (8.0 * (rise - fall))
    # After the middle sample if the way to it is the longer one.
    return turning, np.where(np.abs(rise) > np.abs(fall), k + 1, k)


@compiled
def _path(
    x: FloatArray,
    turning: FloatArray,
    after: IndexArray,
    displacement: float,
    level: FloatArray,
    share: float,
) -> FloatArray:
    """
    Return f (N,) along a path that turns around at ``turning``, ``after`` these samples.

    It approaches the sign times g = 1 + share l, a line between samples and 1 + share where the
    path turns around, over a displacement that goes with g.
    """
    f = np.zeros(len(x))
    now, turn = 0.0, 0
    for k in range(1, len(x)):
        place, here = x[k - 1], 1.0 + share * level[k - 1]
        on_the_way = True
        while on_the_way:
            on_the_way = turn < len(after) and after[turn] < k
            if on_the_way:
                ahead, there = turning[turn], 1.0 + share
                turn += 1
            else:
                ahead, there = x[k], 1.0 + share * level[k]
            dx = ahead - place
            if dx != 0.0:
                sign = 1.0 if dx > 0.0 else -1.0
                way = 2.0 * abs(dx) / (displacement * (here + there))
                # Towards the level, and after its change but for what follows a line behind it.
                moved = -math.expm1(-way)
                now += (sign * here - now) * moved
                now += sign * (there - here) * (1.0 - moved / way)
            place, here = ahead, there
        f[k] = now
    return f
