# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What gains are made from: the noise, the friction and how often the motion turns round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot


@dataclass(frozen=True)
class Conditions:
    """
    Hold the conditions under which joints are observed, one value for each joint.

    :param position_noise: standard deviation of a position, quantisation (resolution / sqrt(12))
        included [rad or m].
    :param momentum_noise: of p = M q' as the observers get it, |row of M| times the noise of the
        velocity [Nm s or N s].
    :param integral_noise: of the integral of p, |row of M| times the position noise
        [Nm s2 or N s2].
    :param friction_jump: D, by how much friction changes where it does: twice its level where the
        velocity changes sign, less from one plateau to the next [Nm or N].
    :param reversal_time: T, time between such changes [s].
    :param top_speed: largest velocity of the motion [rad/s or m/s], None if not known.
    :raises ConfigurationError: if a number is not positive and finite, or a length differs.
    """

    joints: tuple[str, ...]
    position_noise: FloatArray
    momentum_noise: FloatArray
    integral_noise: FloatArray
    friction_jump: FloatArray
    reversal_time: FloatArray
    top_speed: FloatArray | None = None

    def __post_init__(self) -> None:
        for name in (
            'position_noise',
            'momentum_noise',
            'integral_noise',
            'friction_jump',
            'reversal_time',
        ):
            object.__setattr__(self, name, _positive(name, getattr(self, name), self.joints))

    @property
    def first_order_cutoff(self) -> FloatArray:
        """Return (D^2 / (4 T s_p^2))^(1/3): noise c0 s_p balanced against a lag of first order."""
        D, T = self.friction_jump, self.reversal_time
        return np.asarray(np.cbrt(D**2 / (4.0 * T * self.momentum_noise**2)))

    @property
    def second_order_frequency(self) -> FloatArray:
        """Return (D^2 / (4 T s_X^2))^(1/5): noise wn^2 s_X against a lag of second order."""
        D, T = self.friction_jump, self.reversal_time
        return np.asarray((D**2 / (4.0 * T * self.integral_noise**2)) ** 0.2)

    @property
    def random_walk(self) -> FloatArray:
        """Return D / sqrt(T): friction that jumps, as a random walk [Nm/sqrt(s) or N/sqrt(s)]."""
        return np.asarray(self.friction_jump / np.sqrt(self.reversal_time))

    @classmethod
    def of(
        cls,
        robot: Robot,
        q: FloatArray,
        position_noise: ArrayLike,
        velocity_noise: ArrayLike,
        friction_jump: ArrayLike,
        reversal_time: ArrayLike,
        top_speed: ArrayLike | None = None,
    ) -> Conditions:
        """
        Return the conditions of a robot at posture ``q``, (n,).

        Noise of all joints enters the momentum of each: s_p,i^2 = sum_j M_ij^2 s_v,j^2.

        :param velocity_noise: standard deviation of a velocity [rad/s or m/s]; backward
            differences over h have sqrt(2) / h times the position noise.
        """
        squares = robot.inertia(q) ** 2
        positions = _positive('position_noise', position_noise, robot.names)
        velocities = _positive('velocity_noise', velocity_noise, robot.names)
        return cls(
            robot.names,
            positions,
            np.sqrt(squares @ velocities**2),
            np.sqrt(squares @ positions**2),
            np.asarray(friction_jump, dtype=float),
            np.asarray(reversal_time, dtype=float),
            None if top_speed is None else np.asarray(top_speed, dtype=float),
        )


def _positive(name: str, values: ArrayLike, joints: Sequence[str]) -> FloatArray:
    column = np.asarray(values, dtype=float)
    if column.shape != (len(joints),) or not np.all((column > 0) & (column < np.inf)):
        raise ConfigurationError(
            f'{name} is {column.tolist()} for the joints {", ".join(joints)}: gains are made from '
            'one positive number for each joint'
        )
    return column
