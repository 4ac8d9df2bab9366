# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory: what a planner makes, a message says and a driver follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.robot import JointLimits


@dataclass(frozen=True)
class Trajectory:
    """
    Hold N points of n joints.

    ``t`` (N,) [s] from the start, increasing; ``q`` (N, n) [rad or m]; ``v`` (N, n) [rad/s or m/s]
    or None. Between points: cubic Hermite with velocities, straight lines without. Where the first
    time is positive the motion begins at rest at the present position at time 0.

    :raises TrajectoryError: with the point that cannot be followed.
    """

    names: tuple[str, ...]
    t: FloatArray
    q: FloatArray
    v: FloatArray | None = None

    def __post_init__(self) -> None:
        t, count = np.asarray(self.t, dtype=float), len(self.t)
        if count == 0:
            raise TrajectoryError('the trajectory has no points: give at least one')
        shape = (count, len(self.names))
        for what, array in (('positions', self.q), ('velocities', self.v)):
            if array is None:
                continue
            if np.shape(array) != shape:
                raise TrajectoryError(
                    f'the {what} of the trajectory have shape {np.shape(array)}: {count} points '
                    f'of {len(self.names)} joints need {shape}'
                )
            bad = np.argwhere(~np.isfinite(np.asarray(array, dtype=float)))
            if len(bad):
                raise TrajectoryError(
                    f'point {bad[0][0]} of the trajectory has {what} that are not finite'
                )
        if not np.isfinite(t).all() or t[0] < 0.0:
            raise TrajectoryError('the times of the trajectory must be finite and not negative')
        late = np.flatnonzero(np.diff(t) <= 0.0)
        if len(late):
            i = int(late[0]) + 1
            raise TrajectoryError(
                f'point {i} of the trajectory is at {t[i]:g} s, not after {t[i - 1]:g} s of the '
                'point before: let the times increase'
            )

    @property
    def duration(self) -> float:
        """Return the time of the last point [s]."""
        return float(self.t[-1])

    def ordered(self, names: Sequence[str]) -> Trajectory:
        """Return the same with the joints in another order, or with less of them."""
        order = [self.names.index(name) for name in names]
        v = None if self.v is None else self.v[:, order]
        return Trajectory(tuple(names), self.t, self.q[:, order], v)

    def from_rest(self, here: FloatArray) -> Trajectory:
        """Return it from time 0 on: where it begins later, at rest at ``here`` (n,)."""
        if not self.t[0] > 0.0:
            return self
        v = None if self.v is None else np.vstack([np.zeros(len(here)), self.v])
        return replace(self, t=np.append(0.0, self.t), q=np.vstack([here, self.q]), v=v)

    def spline(self) -> PPoly:
        """Return the position as a function of time; its derivative is the velocity."""
        if len(self.t) == 1:
            # One point is a place to be held.
            return PPoly(self.q[None], np.array([0.0, 1.0]))
        if self.v is not None:
            return CubicHermiteSpline(self.t, self.q, self.v)
        slope = np.diff(self.q, axis=0) / np.diff(self.t)[:, None]
        return PPoly(np.stack([slope, self.q[:-1]]), self.t)

    def extremes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Return least position, greatest position and greatest speed of each joint, each (n,).

        They are NaN where the numbers are too large to compute with.
        """
        curve = self.spline()
        found = np.full((3, len(self.names)), np.nan)
        with np.errstate(over='ignore'):
            # Its roots need squares of the coefficients.
            known = np.isfinite(np.square(4.0 * curve.c)).all(axis=(0, 1))
        for joint in np.flatnonzero(known):
            way = PPoly(curve.c[..., joint], curve.x)
            speed = way.derivative()
            # Between points a position is extreme where its slope is 0, and so is a speed.
            turns, tops = (
                np.append(self.t, x.roots(discontinuity=False, extrapolate=False))
                for x in (speed, speed.derivative())
            )
            places = way(turns)
            found[:, joint] = (
                np.nanmin(places), np.nanmax(places), np.nanmax(np.abs(speed(tops))),
            )  # fmt: skip
        return found[0], found[1], found[2]


def hermite(
    q0: FloatArray, v0: FloatArray, q1: FloatArray, v1: FloatArray, h: FloatArray | float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return a0..a3 of the cubic a0 + a1 s + a2 s^2 + a3 s^3, 0 <= s <= h, through both ends."""
    slope = (q1 - q0) / h
    return q0, v0, (3.0 * slope - 2.0 * v0 - v1) / h, (v0 + v1 - 2.0 * slope) / (h * h)


# A velocity left over at the last point, where the joint then holds [rad/s or m/s].
_END_VELOCITY = 0.01


def prepare_trajectory(
    trajectory: Trajectory,
    names: Sequence[str],
    limits: Sequence[JointLimits],
    position: FloatArray,
    tolerance: FloatArray,
) -> Trajectory:
    """
    Check a trajectory as a whole; return it in the order of ``names`` and starting at time 0.

    :param limits: position and velocity limits of each; extremes between points count too.
    :param position: where the joints are (n,) [rad or m].
    :param tolerance: how far from there the trajectory may start, per joint (n,) [rad or m].
    :raises TrajectoryError: with what is wrong, where, and the numbers.
    """
    names = tuple(names)
    if sorted(trajectory.names) != sorted(names):
        raise TrajectoryError(
            f'the trajectory moves {", ".join(trajectory.names) or "no joint"}: it must name '
            f'{", ".join(names)}, each once'
        )
    wanted = trajectory.ordered(names)
    if wanted.v is not None and np.any(np.abs(wanted.v[-1]) > _END_VELOCITY):
        joint = int(np.argmax(np.abs(wanted.v[-1])))
        raise TrajectoryError(
            f'the trajectory ends with joint {names[joint]} at {wanted.v[-1, joint]:.3g} per '
            'second: let it end at rest'
        )
    distance = np.abs(wanted.q[0] - position)
    for joint, name in enumerate(names):
        if not wanted.t[0] > 0.0 and not distance[joint] <= tolerance[joint]:
            raise TrajectoryError(
                f'the trajectory starts with joint {name} at {wanted.q[0, joint]:.4f}, '
                f'{distance[joint]:.4f} from where it is ({position[joint]:.4f}): start within '
                f'{tolerance[joint]:g}, or give the first point a time above 0 to go there'
            )
    prepared = wanted.from_rest(position)
    _check_limits(prepared, limits)
    return prepared


def _check_limits(trajectory: Trajectory, limits: Sequence[JointLimits]) -> None:
    low, high, fastest = trajectory.extremes()
    for joint, (name, limit) in enumerate(zip(trajectory.names, limits, strict=True)):
        extremes = (low[joint], high[joint], fastest[joint])
        if not np.isfinite(extremes).all():
            raise TrajectoryError(
                f'the trajectory of joint {name} has numbers that are too large to be followed: '
                'correct its positions, velocities and times'
            )
        # Written so that a limit that is NaN allows nothing.
        for value, right in (
            (low[joint], low[joint] >= limit.lower),
            (high[joint], high[joint] <= limit.upper),
        ):
            if not right:
                raise TrajectoryError(
                    f'the trajectory takes joint {name} to {value:.4f}, outside its limits '
                    f'{limit.lower:g} to {limit.upper:g}'
                )
        if not fastest[joint] <= limit.velocity:
            raise TrajectoryError(
                f'the trajectory moves joint {name} at {fastest[joint]:.4f} per second where its '
                f'limit is {limit.velocity:g}: make it slower'
            )
