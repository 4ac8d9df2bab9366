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

#: A shorter way, in displacements, changes nothing but by rounding.
_SHORTEST = 1e-12


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
    return np.asarray(_path(longer, displacement)[own])


def following_path(x: FloatArray, displacement: float, level: FloatArray) -> FloatArray:
    """
    Return y (N,) along a path: by how much friction grows with what is added at ``level``.

    Bristles of stiffness s_0 have F' = s_0 (q' - F |q'| / g). With g = C + S l their slope over S
    at S = 0 is dy/d|x| = (z l - y) / x_0, with z = F / C of :func:`dahl_path` and x_0 = C / s_0.
    Where l changes little within x_0, y is l times the sign.

    :param level: l at the samples (N,), 1 where the path turns around.
    """
    longer, own, after = _to_its_turns(x)
    z = _path(longer, displacement)
    return np.asarray(_following(longer, z, np.insert(level, after + 1, 1.0), displacement)[own])


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
def _path(x: FloatArray, displacement: float) -> FloatArray:
    """Return z (N,) along a path that turns around at samples."""
    z = np.zeros(len(x))
    now = 0.0
    for k in range(1, len(x)):
        dx = x[k] - x[k - 1]
        if dx != 0.0:
            target = 1.0 if dx > 0.0 else -1.0
            now = target + (now - target) * math.exp(-abs(dx) / displacement)
        z[k] = now
    return z


@compiled
def _following(x: FloatArray, z: FloatArray, level: FloatArray, displacement: float) -> FloatArray:
    """Return y (N,) along such a path; z times level is a line between its samples."""
    y = np.zeros(len(x))
    now = 0.0
    for k in range(1, len(x)):
        way = abs(x[k] - x[k - 1]) / displacement
        if way > 0.0:
            begin, end = z[k - 1] * level[k - 1], z[k] * level[k]
            # What follows a line stays behind it by its slope.
            behind = (end - begin) / max(way, _SHORTEST)
            now = end - behind + (now - begin + behind) * math.exp(-way)
        y[k] = now
    return y
