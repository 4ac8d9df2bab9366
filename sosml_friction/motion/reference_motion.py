# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The reference that the driver followed, at any times at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, PPoly

from sosml_friction.bags.bag import WantedMotion
from sosml_friction.motion.trajectory_follower import BLEND

FloatArray = NDArray[np.float64]


class ReferenceMotion:
    """
    Sample a recorded trajectory as the driver did, times before its start included.

    As :class:`~sosml_friction.motion.trajectory_follower.TrajectoryFollower`: cubic Hermite
    between points with velocities, else straight lines; held before and after; and for 0.5 s from
    the start on beside it by share (hold - q_0), share = 1 - s^2 (3 - 2 s), s = t / 0.5.

    :param wanted: the trajectory; joints in its order.
    :param here: where the joints are when it begins (n,) [rad or m]: it starts there where its
        first point has a time above 0.
    """

    def __init__(self, wanted: WantedMotion, here: FloatArray) -> None:
        times, q, v = wanted.times, wanted.positions, wanted.velocities
        if times[0] > 0.0:
            times = np.concatenate([[0.0], times])
            q = np.vstack([here, q])
            v = None if v is None else np.vstack([np.zeros(len(here)), v])
        self._first, self._last, self._end = q[0], q[-1], float(times[-1])
        if len(times) == 1:
            # One point at time 0 is a place to be held.
            self._curve = PPoly(q[None], np.array([0.0, 1.0]))
        elif v is None:
            slope = np.diff(q, axis=0) / np.diff(times)[:, None]
            self._curve = PPoly(np.stack([slope, q[:-1]]), times)
        else:
            self._curve = CubicHermiteSpline(times, q, v)

    @property
    def duration(self) -> float:
        """Return the time of the last point [s]."""
        return self._end

    @property
    def first(self) -> FloatArray:
        """Return the position at its start (n,) [rad or m]."""
        return np.asarray(self._first)

    def at(self, t: FloatArray, hold: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Return position, velocity and acceleration, (N, n) each, at times since the start (N,) [s].

        :param hold: reference before the start (n,) [rad or m].
        """
        offset = hold - self._first
        along = (t >= 0.0) & (t < self._end)
        inside = np.where(along, t, 0.0)
        q = np.where(along[:, None], self._curve(inside), self._last)
        v, a = (np.where(along[:, None], self._curve(inside, order), 0.0) for order in (1, 2))
        q[t < 0.0] = hold
        share, rate, bend = blend(t)
        moving = t >= 0.0
        q[moving] += share[moving, None] * offset
        v += rate[:, None] * offset
        a += bend[:, None] * offset
        return q, v, a


def blend(t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the share of the place held before, 1 to 0, and its two derivatives, (N,) each."""
    s = np.clip(t / BLEND, 0.0, 1.0)
    inside = (t >= 0.0) & (t < BLEND)
    return (
        1.0 - s * s * (3.0 - 2.0 * s),
        np.where(inside, -6.0 * s * (1.0 - s) / BLEND, 0.0),
        np.where(inside, -6.0 * (1.0 - 2.0 * s) / BLEND**2, 0.0),
    )
