# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A first moment that is not the nominal one."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.terms.kinds.term import Inner

#: Random states at which it is asked what a joint feels.
_STATES = 50
#: Bodies weigh this many times what the model says at most, and have as many times its inertia: a
#: limb or a load of twice their own weight may hang there. Chosen, no measurement.
HEAVIER = 3.0


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

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        robot = fit.signals.robot
        body = Body(robot.inertial_parameters(), np.array(robot.armature), np.zeros(3))
        for change, size in zip(
            self.changes(robot, fit.joint, fit.inner), fit.amplitude, strict=True
        ):
            body.add(change, float(size))
        changed = robot.changed(body.inertias, body.rotors, body.gravity)
        q = np.median(fit.signals.q, axis=0)
        most = HEAVIER * _most(robot, fit.joint, q)
        # A model without masses says nothing of them.
        if 0.0 < most < _moment(changed, fit.joint, q):
            return f'what hangs on the joint would weigh over {HEAVIER:g} times as much'
        return ''


def _moment(robot: Robot, joint: int, q: FloatArray) -> float:
    """
    Return the first moment of all that a joint carries, across its axis [kg m].

    The largest that its effort against gravity becomes, gravity of 1 m/s2 in any direction.
    """
    under = [robot.gravity_under(q, way)[joint] for way in np.eye(3)]
    return float(np.linalg.norm(under))


def _most(robot: Robot, joint: int, q: FloatArray) -> float:
    """
    Return the largest first moment that bodies of that mass and inertia have, sqrt(m I) [kg m].

    Each part of mass dm at r across the axis adds r dm to the first moment and r^2 dm to the
    inertia: by Cauchy and Schwarz |sum r dm|^2 <= sum dm sum r^2 dm. A pseudo-inertia that is
    positive says the same. Rotors are in none of them.
    """
    rng = np.random.default_rng(0)
    state = rng.uniform(-1.5, 1.5, (3, robot.n))
    blocks = robot.torque_regressor(*state)[joint].reshape(robot.n, 10)
    carried = np.any(np.abs(blocks) > 1e-9, axis=1)
    mass = float(robot.inertial_parameters()[carried, 0].sum())
    inertia = float(robot.inertia(q)[joint, joint]) - robot.armature[joint]
    return float(np.sqrt(max(mass * inertia, 0.0)))


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
