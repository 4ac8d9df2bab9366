# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Building blocks of identification trajectories: smooth ramps, plateaus and moves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_loads import limit_uses, trajectory_loads


def quintic(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return 10 u^3 - 15 u^4 + 6 u^5, from 0 to 1 over 0 <= u <= 1, and its two derivatives."""
    return (
        u**3 * (10.0 + u * (6.0 * u - 15.0)),
        30.0 * u**2 * (1.0 - u) ** 2,
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )


class TrajectoryBuilder:
    """String together pieces of motion of n joints, with knots every ``dt`` where they bend."""

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

    def ramp(self, v: FloatArray, duration: float) -> TrajectoryBuilder:
        """
        Go over to velocity ``v`` (n,) along 10 u^3 - 15 u^4 + 6 u^5, u = t / duration.

        Acceleration and jerk begin and end at zero and are bounded; the largest acceleration is
        15/8 of the mean one. The way covered is the mean velocity times ``duration``.
        """
        u = self._grid(duration) / duration
        shape = quintic(u)[0][:, None]
        way = (u**4 * (2.5 + u * (u - 3.0)))[:, None]
        change = v - self.v
        q = self.q + duration * (self.v * u[:, None] + change * way)
        return self._append(u * duration, q, self.v + change * shape)

    def hold(self, duration: float) -> TrajectoryBuilder:
        """Keep the present velocity for ``duration`` [s]."""
        self._grid(duration)  # refuses what is not a duration
        # A cubic between two knots is exact here, and a message of few points is quickly read.
        return self._append(
            np.array([duration]), (self.q + self.v * duration)[None], self.v[None].copy()
        )

    def move(
        self, q: FloatArray, top_speed: float | FloatArray, shortest: float = 0.2
    ) -> TrajectoryBuilder:
        """
        Move from rest to rest at ``q`` (n,) along the same quintic, in position.

        :param top_speed: no joint is faster, one for all or (n,) [rad/s or m/s]; the speed
            peaks at 15/8 of the mean.
        :raises TrajectoryError: if the motion is not at rest now.
        """
        self._require_rest('a move')
        way = np.asarray(q, dtype=float) - self.q
        duration = max(shortest, 15.0 / 8.0 * float(np.max(np.abs(way) / top_speed)))
        u = self._grid(duration) / duration
        shape, rate, _ = quintic(u[:, None])
        return self._append(u * duration, self.q + way * shape, way * (rate / duration))

    def there_and_back(
        self,
        middle: FloatArray,
        v: FloatArray,
        plateau_s: float,
        ramp_s: float,
        top_speed: float | FloatArray,
    ) -> TrajectoryBuilder:
        """
        Go through ``middle`` (n,) at velocity ``v`` (n,) for ``plateau_s``, rest, and come back.

        Both plateaus have their middle there. Lasts 2 plateau_s + 4 ramp_s and the move before it.
        """
        self.move(middle - 0.5 * v * (plateau_s + ramp_s), top_speed, 0.4)
        for direction in (1.0, -1.0):
            self.ramp(direction * v, ramp_s).hold(plateau_s).ramp(0.0 * v, ramp_s)
        return self

    def to_and_fro(
        self,
        middle: FloatArray,
        v: FloatArray,
        plateau_s: float,
        turn_s: float,
        cycles: int,
        top_speed: float | FloatArray,
    ) -> TrajectoryBuilder:
        """
        Go through ``middle`` at +v and -v in turn, without a rest where the motion turns.

        All plateaus have their middle there. Velocity is odd in time about the middle of the
        ``2 cycles`` half-cycles: each direction is held as long, in the same postures.

        :raises TrajectoryError: if ``cycles`` is no whole number.
        """
        self.move(middle - v * (0.5 * plateau_s + 0.25 * turn_s), top_speed, 0.4)
        # From rest in half the time: as much acceleration as in a turn.
        self.ramp(v, 0.5 * turn_s)
        for half_cycle in range(2 * int(cycles)):
            if half_cycle:
                self.ramp(-self.v, turn_s)
            self.hold(plateau_s)
        return self.ramp(0.0 * v, 0.5 * turn_s)

    def wave(
        self, duration: float, shape: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    ) -> TrajectoryBuilder:
        """
        Add a motion about where the joints are now, which ends where it begins.

        :param shape: from times (k,) [s] to displacement and velocity, each (k, n); both are zero
            at 0 and at ``duration``.
        :raises TrajectoryError: if the motion is not at rest now.
        """
        self._require_rest('a wave')
        t = self._grid(duration)
        displacement, velocity = shape(t)
        return self._append(t, self.q + displacement, velocity)

    def build(self) -> Trajectory:
        """Return the motion that was put together."""
        return Trajectory(
            self.names, np.concatenate(self._t), np.concatenate(self._q), np.concatenate(self._v)
        )

    def _require_rest(self, what: str) -> None:
        if np.any(self.v != 0.0):
            raise TrajectoryError(
                f'{what} begins at a speed of {np.max(np.abs(self.v)):.3g}: ramp to rest first'
            )

    def _grid(self, duration: float) -> FloatArray:
        if not duration > 0.0:
            raise TrajectoryError(f'a piece of motion lasts {duration} s: give it a positive time')
        count = max(1, int(np.ceil(duration / self._dt - 1e-9)))
        return np.linspace(0.0, duration, count + 1)[1:]

    def _append(self, t: FloatArray, q: FloatArray, v: FloatArray) -> TrajectoryBuilder:
        self._t.append(self._t[-1][-1] + t)
        self._q.append(q)
        self._v.append(np.array(v))
        return self


def begin_motion(
    what: str,
    start: Mapping[str, float],
    centre: Mapping[str, float],
    scale: Sequence[float],
) -> tuple[TrajectoryBuilder, FloatArray, FloatArray]:
    """
    Return the motion at its start, the centre (n,) and the scale (n,) of each joint.

    :param start: present position of each joint, at rest [rad or m]; its order is kept.
    :param scale: one for all joints or one for each; a joint with 0 stays at its centre.
    :raises TrajectoryError: if joints differ or the scale is none.
    """
    if set(start) != set(centre):
        raise TrajectoryError(
            f'{what} has centres for {", ".join(centre)} where the robot reports '
            f'{", ".join(start)}: name the same joints'
        )
    names = tuple(start)
    factor = per_joint('scale', scale, len(names))
    if not (np.isfinite(factor).all() and (factor >= 0.0).all() and factor.any()):
        raise TrajectoryError(
            f'the scale of the joints is {list(scale)}: give 0 to a joint that rests and a '
            'positive number to one that moves'
        )
    middle = np.array([centre[name] for name in names], dtype=float)
    return TrajectoryBuilder(names, np.array([start[name] for name in names])), middle, factor


def per_joint(what: str, values: Sequence[float], n: int) -> FloatArray:
    """
    Return ``values`` for each of n joints, where one value stands for all.

    :raises TrajectoryError: if there are neither one nor n.
    """
    if len(values) not in (1, n):
        raise TrajectoryError(
            f'{what} has {len(values)} values for {n} joints: give one for all or one for each'
        )
    return np.array(np.broadcast_to(np.asarray(values, dtype=float), (n,)))


def move_speeds(top_speed: float, scale: FloatArray) -> FloatArray:
    """Return the largest speed (n,) of the moves between pieces; a resting joint has no scale."""
    return np.asarray(top_speed * np.where(scale > 0.0, scale, 1.0))


def check_limits(
    trajectory: Trajectory,
    robot: Robot,
    effort_margin: float = 1.0,
    acceleration: Sequence[float] = (),
) -> None:
    """
    Refuse a trajectory that leaves the URDF's limits of position, velocity or effort.

    Effort is that of the rigid body alone: friction is not known yet, so leave a margin.

    :param effort_margin: share of the effort limit the rigid body may take, 0..1; the rest is the
        allowance for friction.
    :param acceleration: limit of each joint, one for all or one for each [rad/s2 or m/s2]; empty:
        only effort limits it.
    :raises TrajectoryError: naming joint, time, value, limit and how far it is beyond; or the
        joint that the trajectory lacks.
    """
    loads = trajectory_loads(trajectory, robot)
    limits = per_joint('the acceleration limit', acceleration, robot.n) if acceleration else None
    for use in limit_uses(loads, robot, effort_margin, limits):
        if use.excess > 0.0:
            raise TrajectoryError(f'{use.sentence()}: change its centre or speeds')


class Signal(NamedTuple):
    """Hold a function of time and its first two derivatives, arrays of one shape."""

    x: FloatArray
    rate: FloatArray
    curvature: FloatArray


def fade(t: FloatArray, duration: float, ramp_s: float) -> Signal:
    """
    Return an envelope (k, 1): from 0 to 1 within ``ramp_s``, 1, and back to 0 at the end.

    Each ramp is 10 u^3 - 15 u^4 + 6 u^5: what it multiplies begins and ends at zero position,
    velocity and acceleration, whatever its phase.
    """
    up = np.clip(t / ramp_s, 0.0, 1.0)[:, None]
    down = np.clip((duration - t) / ramp_s, 0.0, 1.0)[:, None]
    x = rate = curvature = np.zeros_like(up)
    for u, sign in ((up, 1.0), (down, -1.0)):
        shape, slope, bend = quintic(u)
        x, rate, curvature = x + shape, rate + sign * slope / ramp_s, curvature + bend / ramp_s**2
    return Signal(x - 1.0, rate, curvature)


def product(a: Signal, b: Signal) -> Signal:
    """Return a b by the rule of Leibniz."""
    return Signal(
        a.x * b.x,
        a.rate * b.x + a.x * b.rate,
        a.curvature * b.x + 2.0 * a.rate * b.rate + a.x * b.curvature,
    )
