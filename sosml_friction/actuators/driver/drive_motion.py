# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the joints should be, and the effort that takes them there."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.soft_stop import SoftStop
from sosml_friction.actuators.joint_configuration import HostLoop
from sosml_friction.actuators.measurement import Setpoint
from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory import Trajectory, prepare_trajectory
from sosml_friction.motion.trajectory_follower import TrajectoryFollower


class DriveMotion:
    """
    Follow trajectories, brake and hold, within the joints' limits.

    Effort is M(q_r) q_r'' + C q_r' + g(q_r) + kp (q_r - q) + kd (q_r' - q'), what the soft stop
    lets through of it. The feed-forward is the nominal model's inverse dynamics at the reference;
    friction is not in it: it is what is to be found. Where q' is not known yet (NaN) its term is
    left out. A joint whose loop is the actuator's own has gains of zero here.

    :param robot: the nominal model, joints in the order of the configuration.
    """

    def __init__(self, configuration: DriverConfiguration, robot: Robot) -> None:
        self._names = configuration.names
        self._limits = robot.limits
        self._lower = np.array([limits.lower for limits in robot.limits])
        self._upper = np.array([limits.upper for limits in robot.limits])
        self._deceleration = configuration.stop_deceleration
        self._tolerance = np.full(len(self._names), configuration.start_tolerance)
        loops = [
            joint.loop(limits)
            for joint, limits in zip(configuration.joints, robot.limits, strict=True)
        ]
        gains = [(own.kp, own.kd) if isinstance(own, HostLoop) else (0.0, 0.0) for own in loops]
        self._kp, self._kd = np.array(gains).T.copy()
        self._robot = robot
        self._soft_stop = SoftStop(
            robot.limits,
            np.array([limits.effort for limits in robot.limits]),
            self._kd,
            configuration.stop_deceleration,
            configuration.limit_margin,
        )
        self.follower = TrajectoryFollower(np.zeros(len(self._names)))

    def prepare(self, trajectory: Trajectory, q: FloatArray) -> Trajectory:
        """
        Check a trajectory as a whole, to be started at ``q``.

        :raises TrajectoryError: if it does not fit.
        """
        return prepare_trajectory(trajectory, self._names, self._limits, q, self._tolerance)

    def brake(self, q: FloatArray, v: FloatArray) -> None:
        """Bring the reference from ``q`` at ``v`` to rest within the limits, then hold."""
        self.follower.brake(q, v, self._deceleration, self._lower, self._upper)

    def setpoints(self, q: FloatArray, v: FloatArray) -> Sequence[Setpoint]:
        """Return what each joint is to do, measured at ``q`` and ``v``, to meet the reference."""
        reference = self.follower.last
        damping = np.where(np.isnan(v), 0.0, reference.v - v)
        tau = self._robot.inverse_dynamics(*reference) + self._kp * (reference.q - q)
        effort = self._soft_stop.limit(tau + self._kd * damping, q, v)
        columns = (effort.tolist(), reference.q.tolist(), reference.v.tolist())
        return [Setpoint(*row) for row in zip(*columns, strict=True)]
