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
    longer, own, _ = _to_its_turns(x)
    return np.asarray(_path(longer, displacement, np.ones(len(longer)))[own])


def following_path(x: FloatArray, displacement: float, level: FloatArray) -> FloatArray:
    """
    Return y (N,) along a path: what friction has more for a Stribeck term, per unit of it.

    Bristles of stiffness s_0 have F' = s_0 (q' - F |q'| / g). With f = F / C, g = C (1 + r l) and
    x_0 = C / s_0 that is df/d|x| = (sgn(q') - f / (1 + r l)) / x_0: z of :func:`dahl_path` for
    r = 0, and y = (f - z) / r. Where l changes little within x_0, y is l times the sign. It hardly
    depends on r = S / C, for which :data:`SHARE` stands.

    :param level: l at the samples (N,), 1 where the path turns around.
    """
    longer, own, after = _to_its_turns(x)
    levels = 1.0 + SHARE * np.insert(level, after + 1, 1.0)
    f, z = (_path(longer, displacement, own) for own in (levels, np.ones(len(longer))))
    return np.asarray((f - z)[own] / SHARE)


def _to_its_turns(x: FloatArray) -> tuple[FloatArray, IndexArray, IndexArray]:
    """Return a path with where it turns around, its own samples there, and after which it does."""
    turning, after = _turning_points(x)
    longer = np.insert(x, after + 1, turning)
    own = np.arange(len(x)) + np.searchsorted(after + 1, np.arange(len(x)), side='right')
    return longer, own, after


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
def _path(x: FloatArray, displacement: float, level: FloatArray) -> FloatArray:
    """
    Return f (N,) along a path that turns around at samples.

    It approaches the sign times the level, a line between samples, over a displacement that goes
    with the level.
    """
    f = np.zeros(len(x))
    now = 0.0
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        if dx != 0.0:
            sign = 1.0 if dx > 0.0 else -1.0
            begin, end = sign * level[k - 1], sign * level[k]
            way = 2.0 * abs(dx) / (displacement * (level[k] + level[k - 1]))
            # Towards the level, and after its change but for what follows a line behind it.
            moved = -math.expm1(-way)
            now += (begin - now) * moved + (end - begin) * (1.0 - moved / way)
        f[k] = now
    return f
