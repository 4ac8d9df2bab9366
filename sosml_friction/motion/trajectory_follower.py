# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the joints should be now: along a trajectory, braking, or where they hold."""

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.motion.reference import BLEND, Reference, blend
from sosml_friction.motion.trajectory import Trajectory, hermite


class TrajectoryFollower:
    """
    Sample a prepared trajectory, and hold a position when there is none.

    The reference never jumps: a trajectory that starts a little beside it is met within 0.5 s
    along a cubic, and :meth:`brake` ends a motion with bounded deceleration. A trajectory starts
    at the first sample after :meth:`follow`; its last position is held when it has ended.
    """

    def __init__(self, q: FloatArray) -> None:
        self._zeros = np.zeros(len(q))
        #: The reference sampled last.
        self.last = Reference(np.array(q, dtype=float), self._zeros, self._zeros)
        self._trajectory: Trajectory | None = None
        self._braking = False
        self._offset = self._zeros
        self._start_ns: int | None = None
        self._index = 0

    @property
    def running(self) -> bool:
        """Tell whether a trajectory is being executed; braking is not."""
        return self._trajectory is not None and not self._braking

    def follow(self, trajectory: Trajectory) -> None:
        """Start ``trajectory``, which begins at time 0, at the next sample."""
        self._begin(trajectory)
        self._offset = self.last.q - trajectory.q[0]

    def hold(self, q: FloatArray) -> None:
        """Drop any trajectory and hold ``q`` from now on, wherever the reference was."""
        self._trajectory = None
        self.last = Reference(np.array(q, dtype=float), self._zeros, self._zeros)

    def brake(
        self,
        q: FloatArray,
        v: FloatArray,
        deceleration: float,
        lower: FloatArray,
        upper: FloatArray,
    ) -> None:
        """
        Bring the reference from ``q`` at ``v`` to rest, then hold.

        :param deceleration: of the fastest joint [per s^2]; the others stop at the same time.
        :param lower: where the joints must not go beyond, with ``upper``, (n,) [rad or m].
        """
        time = float(np.max(np.abs(v))) / deceleration
        if time == 0.0:
            self.hold(q)
            return
        end = np.clip(q + 0.5 * time * v, np.minimum(lower, q), np.maximum(upper, q))
        # At constant deceleration the cubic through both ends is the parabola itself.
        names = tuple(str(i) for i in range(len(q)))
        velocities = np.array([v, self._zeros])
        self._begin(Trajectory(names, np.array([0.0, time]), np.array([q, end]), velocities))
        self._braking = True
        self._offset = self._zeros
        self.last = Reference(np.array(q, dtype=float), np.array(v, dtype=float), self._zeros)

    def _begin(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        self._braking = False
        self._start_ns = None
        self._index = 0

    def sample(self, now_ns: int) -> Reference:
        """Return the reference at ``now_ns``; times must not decrease between calls."""
        trajectory = self._trajectory
        if trajectory is None:
            return self.last
        if self._start_ns is None:
            self._start_ns = now_ns
        t = (now_ns - self._start_ns) * 1e-9
        blending = t < BLEND and bool(self._offset.any())
        if t >= trajectory.t[-1] and not blending:
            self.hold(trajectory.q[-1])
            return self.last
        reference = self._along(trajectory, t)
        if blending:
            share, rate, bend = blend(t)
            reference = Reference(
                reference.q + share * self._offset,
                reference.v + rate * self._offset,
                reference.a + bend * self._offset,
            )
        self.last = reference
        return reference

    def _along(self, trajectory: Trajectory, t: float) -> Reference:
        times = trajectory.t
        if t >= times[-1]:
            return Reference(trajectory.q[-1], self._zeros, self._zeros)
        i = self._index
        while t >= times[i + 1]:
            i += 1
        self._index = i
        s, h = t - times[i], times[i + 1] - times[i]
        q0, q1 = trajectory.q[i], trajectory.q[i + 1]
        if trajectory.v is None:
            v = (q1 - q0) / h
            return Reference(q0 + s * v, v, self._zeros)
        v0, v1 = trajectory.v[i], trajectory.v[i + 1]
        a0, a1, a2, a3 = hermite(q0, v0, q1, v1, h)
        return Reference(
            a0 + s * (a1 + s * (a2 + s * a3)),
            a1 + s * (2.0 * a2 + 3.0 * s * a3),
            2.0 * a2 + 6.0 * s * a3,
        )
