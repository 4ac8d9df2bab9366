# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The reference that the driver followed, at any times at once."""

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.motion.reference import Reference, blend
from sosml_friction.motion.trajectory import Trajectory


class ReferenceMotion:
    """
    Sample a recorded trajectory as the driver did, times before its start included.

    As :class:`~sosml_friction.motion.trajectory_follower.TrajectoryFollower`: cubic Hermite
    between points with velocities, else straight lines; held before and after; and for 0.5 s from
    the start on beside it by share (hold - q_0), share = 1 - s^2 (3 - 2 s), s = t / 0.5. ``first``
    (n,) [rad or m] is where it starts; ``duration`` [s] the time of its last point.

    :param wanted: the trajectory; joints in its order.
    :param here: where the joints are when it begins (n,) [rad or m]: it starts there where its
        first point has a time above 0.
    """

    def __init__(self, wanted: Trajectory, here: FloatArray) -> None:
        wanted = wanted.from_rest(here)
        self.first, self._last, self.duration = wanted.q[0], wanted.q[-1], wanted.duration
        self._curve = wanted.spline()

    def at(self, t: FloatArray, hold: FloatArray) -> Reference:
        """
        Return the reference, (N, n) each, at times since the start (N,) [s].

        :param hold: reference before the start (n,) [rad or m].
        """
        offset = hold - self.first
        along = (t >= 0.0) & (t < self.duration)
        inside = np.where(along, t, 0.0)
        q = np.where(along[:, None], self._curve(inside), self._last)
        v, a = (np.where(along[:, None], self._curve(inside, order), 0.0) for order in (1, 2))
        q[t < 0.0] = hold
        share, rate, bend = blend(t)
        moving = t >= 0.0
        q[moving] += share[moving, None] * offset
        v += rate[:, None] * offset
        a += bend[:, None] * offset
        return Reference(q, v, a)
