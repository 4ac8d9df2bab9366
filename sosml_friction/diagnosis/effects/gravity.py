# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A first moment of mass that is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Body
from sosml_friction.simulation.forward_terms import BodyTerm

#: Random states at which it is asked what a joint feels.
_STATES = 50


class Gravity(Effect):
    """
    Add Y_mc change: mass times distance of the joint's body is not the nominal one.

    Y_mc are the columns of the torque regressor; the two components across the joint's axis.
    """

    identifier: ClassVar[str] = 'gravity'
    amplitudes: ClassVar[Mapping[str, str]] = {'first_moment_1': 'kg m', 'first_moment_2': 'kg m'}
    parameter_error: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the columns of the regressor."""
        across = first_moments(signals.robot, joint)
        return np.array(signals.regressor[:, :, [10 * joint + 1 + k for k in across]])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> BodyTerm:
        """Return a body whose first moment is larger by the change."""
        across = first_moments(robot, joint)

        def body(body: Body) -> None:
            body.inertias[joint, [1 + k for k in across]] += amplitude

        return BodyTerm(body)

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether gravity acts on a body that turns."""
        return (
            signals.effort_unit(joint) == 'Nm'
            and bool(signals.robot.gravity_acceleration.any())
            and len(first_moments(signals.robot, joint)) == 2
        )


def first_moments(robot: Robot, joint: int) -> list[int]:
    """
    Return which components of the first moment the joint itself feels most: two, or fewer.

    At random states, so that the robot alone says what the amplitudes mean.
    """
    rng = np.random.default_rng(0)
    block = np.array(
        [
            robot.torque_regressor(*rng.uniform(-1.5, 1.5, (3, robot.n)))[joint, 10 * joint + 1 :][
                :3
            ]
            for _ in range(_STATES)
        ]
    )
    felt = np.sqrt(np.mean(block**2, axis=0))
    return sorted(int(k) for k in np.argsort(-felt)[:2] if felt[k] > 1e-9)
