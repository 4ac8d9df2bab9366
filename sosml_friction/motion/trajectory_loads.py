# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a trajectory asks of a robot, and how much of its limits that is."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory import Trajectory


@dataclass(frozen=True)
class TrajectoryLoads:
    """
    Hold a trajectory in samples, joints in the robot's order.

    ``t`` (k,) [s]; ``q``, ``v``, ``a`` (k, n) [rad or m, per s, per s^2]; ``tau`` (k, n)
    [Nm or N] = M q'' + C q' + g, without friction.
    """

    t: FloatArray
    q: FloatArray
    v: FloatArray
    a: FloatArray
    tau: FloatArray


@dataclass(frozen=True)
class LimitUse:
    """
    Hold the instant ``time`` [s] at which ``quantity`` of ``joint`` is closest to its limit.

    ``value`` and ``limit`` are in the joint's units (rad or m, per s, per s^2, Nm or N);
    ``excess`` is positive beyond the limit and negative within it.
    """

    joint: str
    quantity: str
    value: float
    time: float
    limit: float
    excess: float

    def sentence(self) -> str:
        """Return what is beyond the limit, without a full stop."""
        article = 'an' if self.quantity[0] in 'aeiou' else 'a'
        return (
            f'the trajectory takes joint {self.joint} to {article} {self.quantity} of '
            f'{self.value:.3g} at {self.time:.2f} s, {self.excess:.3g} beyond its limit '
            f'of {self.limit:.3g}'
        )


def trajectory_loads(trajectory: Trajectory, robot: Robot, step: float = 0.01) -> TrajectoryLoads:
    """
    Sample a trajectory every ``step`` [s], its last instant included.

    :raises TrajectoryError: if it lacks a joint of the robot.
    """
    missing = [name for name in robot.names if name not in trajectory.names]
    if missing:
        raise TrajectoryError(
            f'the trajectory does not move joint {", ".join(missing)}: give every joint of the '
            'robot its positions'
        )
    spline = trajectory.ordered(robot.names).spline()
    t = np.append(np.arange(trajectory.t[0], trajectory.duration, step), trajectory.duration)
    q, v, a = (np.asarray(spline(t, k)) for k in range(3))
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    return TrajectoryLoads(t, q, v, a, tau)


def limit_uses(
    loads: TrajectoryLoads,
    robot: Robot,
    effort_margin: float = 1.0,
    acceleration: FloatArray | None = None,
) -> list[LimitUse]:
    """
    Return, for each joint, where it comes closest to, or goes farthest beyond, each limit.

    :param effort_margin: share of the effort limit the rigid body alone may take.
    :param acceleration: limits (n,) [rad/s2 or m/s2]; None: there are none.
    :raises TrajectoryError: if the URDF states no limit of a speed or an effort.
    """
    uses = []
    for i, (name, limit) in enumerate(zip(robot.names, robot.limits, strict=True)):
        q, v, a, tau = loads.q[:, i], loads.v[:, i], loads.a[:, i], loads.tau[:, i]
        for what in ('velocity', 'effort'):
            if np.isnan(getattr(limit, what)):
                raise TrajectoryError(
                    f'the URDF gives joint {name} no {what} limit: write it into its <limit>, a '
                    'trajectory is checked against it'
                )
        low = limit.lower - q > q - limit.upper
        effort = effort_margin * limit.effort
        rows = [
            ('position', q, np.where(low, limit.lower - q, q - limit.upper), None),
            ('speed', v, np.abs(v) - limit.velocity, limit.velocity),
        ]
        if acceleration is not None:
            rows.append(('acceleration', a, np.abs(a) - acceleration[i], float(acceleration[i])))
        rows.append(('rigid-body effort', tau, np.abs(tau) - effort, effort))
        for quantity, value, excess, bound in rows:
            k = int(np.argmax(excess))
            if bound is None:
                bound = limit.lower if low[k] else limit.upper
            uses.append(
                LimitUse(
                    name, quantity, float(value[k]), float(loads.t[k]), bound, float(excess[k])
                )
            )
    return uses
