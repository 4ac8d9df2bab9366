# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Building blocks of identification trajectories: smooth ramps, plateaus and moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.robot import Robot
from sosml_friction.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]


class Motion:
    """
    String together pieces of motion of n joints, with knots every ``dt`` where they bend.

    :param q: where the motion begins, at rest (n,) [rad or m].
    """

    def __init__(self, names: tuple[str, ...], q: FloatArray, dt: float = 0.02) -> None:
        self.names = names
        self._dt = dt
        self._t = [np.zeros(1)]
        self._q = [np.atleast_2d(np.array(q, dtype=float))]
        self._v = [np.zeros((1, len(names)))]

    @property
    def q(self) -> FloatArray:
        """Return where the motion is now (n,)."""
        return self._q[-1][-1]

    @property
    def v(self) -> FloatArray:
        """Return how fast the motion is now (n,)."""
        return self._v[-1][-1]

    def ramp(self, v: FloatArray, duration: float) -> Motion:
        """
        Go over to velocity ``v`` (n,) along 10 u^3 - 15 u^4 + 6 u^5, u = t / duration.

        Acceleration and jerk begin and end at zero and are bounded; the largest acceleration is
        15/8 of the mean one. The way covered is the mean velocity times ``duration``.
        """
        u = self._grid(duration) / duration
        shape = (u**3 * (10.0 + u * (6.0 * u - 15.0)))[:, None]
        way = (u**4 * (2.5 + u * (u - 3.0)))[:, None]
        change = v - self.v
        q = self.q + duration * (self.v * u[:, None] + change * way)
        return self._append(u * duration, q, self.v + change * shape)

    def hold(self, duration: float) -> Motion:
        """Keep the present velocity for ``duration`` [s]."""
        self._grid(duration)  # refuses what is not a duration
        # A cubic between two knots is exact here, and a message of few points is quickly read.
        return self._append(
            np.array([duration]), (self.q + self.v * duration)[None], self.v[None].copy()
        )

    def move(self, q: FloatArray, top_speed: float, shortest: float = 0.2) -> Motion:
        """
        Move from rest to rest at ``q`` (n,) along the same quintic, in position.

        :param top_speed: no joint is faster [rad/s or m/s]; it peaks at 15/8 of the mean.
        :param shortest: least duration [s].
        :raises TrajectoryError: if the motion is not at rest now.
        """
        if np.any(self.v != 0.0):
            raise TrajectoryError(
                f'a move begins at a speed of {np.max(np.abs(self.v)):.3g}: ramp to rest first'
            )
        way = np.asarray(q, dtype=float) - self.q
        duration = max(shortest, 15.0 / 8.0 * float(np.max(np.abs(way))) / top_speed)
        u = self._grid(duration) / duration
        shape = (u**3 * (10.0 + u * (6.0 * u - 15.0)))[:, None]
        rate = (30.0 * u**2 * (1.0 - u) ** 2)[:, None] / duration
        return self._append(u * duration, self.q + way * shape, way * rate)

    def build(self) -> Trajectory:
        """Return the motion so far."""
        return Trajectory(
            self.names, np.concatenate(self._t), np.concatenate(self._q), np.concatenate(self._v)
        )

    def _grid(self, duration: float) -> FloatArray:
        if not duration > 0.0:
            raise TrajectoryError(f'a piece of motion lasts {duration} s: give it a positive time')
        count = max(1, int(np.ceil(duration / self._dt - 1e-9)))
        return np.linspace(0.0, duration, count + 1)[1:]

    def _append(self, t: FloatArray, q: FloatArray, v: FloatArray) -> Motion:
        self._t.append(self._t[-1][-1] + t)
        self._q.append(q)
        self._v.append(np.array(v))
        return self


def check_limits(trajectory: Trajectory, robot: Robot, effort_margin: float = 1.0) -> None:
    """
    Refuse a trajectory that leaves the URDF's limits of position, velocity or effort.

    Effort is that of the rigid body alone: friction is not known yet, so leave a margin.

    :param effort_margin: share of the effort limit the rigid body may take, 0..1.
    :raises TrajectoryError: naming joint, time, value and how far it is beyond the limit; or the
        joint that the trajectory lacks.
    """
    missing = [name for name in robot.names if name not in trajectory.names]
    if missing:
        raise TrajectoryError(
            f'the trajectory does not move joint {", ".join(missing)}: give every joint of the '
            'robot its positions'
        )
    spline = trajectory.spline()
    t = np.append(np.arange(trajectory.t[0], trajectory.duration, 0.01), trajectory.duration)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    order = [trajectory.names.index(name) for name in robot.names]
    q, v, a = q[:, order], v[:, order], a[:, order]
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    for i, (name, limit) in enumerate(zip(robot.names, robot.limits, strict=True)):
        excess = (
            ('position', np.maximum(limit.lower - q[:, i], q[:, i] - limit.upper), q),
            ('speed', np.abs(v[:, i]) - limit.velocity, v),
            ('rigid-body effort', np.abs(tau[:, i]) - effort_margin * limit.effort, tau),
        )
        for what, over, value in excess:
            k = int(np.argmax(over))
            if over[k] > 0.0:
                raise TrajectoryError(
                    f'the trajectory takes joint {name} to a {what} of {value[k, i]:.3g} at '
                    f'{t[k]:.2f} s, {over[k]:.3g} beyond its limit: change its centre or speeds'
                )
