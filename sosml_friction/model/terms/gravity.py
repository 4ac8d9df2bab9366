# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A first moment that is not the nominal one."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.terms.kinds.term import Inner

#: Random states at which it is asked what a joint feels.
_STATES = 50


class Gravity(BodyTerm):
    """Change two components of the first moment of the joint's body, across the joint's axis."""

    identifier: ClassVar[str] = 'gravity'
    amplitudes: ClassVar[Mapping[str, str]] = {'first_moment_1': 'kg m', 'first_moment_2': 'kg m'}
    parameter_error: ClassVar[bool] = True
    axis: ClassVar[str] = 'position'
    free_axis: ClassVar[str] = 'position'
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'spring': (
            'not_worn',
            'record without the person or the cable (not worn) and compare: gravity stays, a '
            'spring goes',
        )
    }

    def changes(self, robot: Robot, joint: int, inner: Inner) -> tuple[Body, ...]:
        """Return one first moment more, of each component."""
        result = []
        for k in first_moments(robot, joint):
            body = Body.unchanged(robot.n)
            body.inertias[joint, 1 + k] = 1.0
            result.append(body)
        return tuple(result)

    def applies(self, signals: Recording, joint: int) -> bool:
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
    own = slice(10 * joint + 1, 10 * joint + 4)
    states = rng.uniform(-1.5, 1.5, (_STATES, 3, robot.n))
    block = np.array([robot.torque_regressor(*state)[joint, own] for state in states])
    felt = np.sqrt(np.mean(block**2, axis=0))
    return sorted(int(k) for k in np.argsort(-felt)[:2] if felt[k] > 1e-9)
