# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A mass on the last body."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import FELT, BodyTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.terms.kinds.term import Inner

#: Positions at which weight is looked for: robots have no more than a few at which it is none.
_STATES = 10


class Payload(BodyTerm):
    """
    Add m Y (1, r, r r'): a point mass m at r from the last joint, towards the body's own centre.

    ``distance`` = |r| [m]. On a slide it is any mass that is not the model's, less of it too:
    nothing else of the catalogue changes what a slide has to lift.
    """

    identifier: ClassVar[str] = 'payload'
    amplitudes: ClassVar[Mapping[str, str]] = {'mass': 'kg'}
    inner: ClassVar[Mapping[str, str]] = {'distance': 'm'}
    refined: ClassVar[tuple[str, ...]] = ('distance',)
    of_robot: ClassVar[bool] = True

    def changes(self, robot: Robot, joint: int, inner: Inner) -> tuple[Body, ...]:
        """Return 1 kg at the distance."""
        body = Body.unchanged(robot.n)
        body.inertias[-1] = point_mass(robot, inner['distance'])
        return (body,)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        centre = body_centre(signals.robot)
        shares = (1.0, 1.5, 2.0, 2.5) if self._felt(signals) else (1.0,)
        return [{'distance': centre * share} for share in shares]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range; nothing where no joint feels the distance."""
        if not self._felt(signals):
            return {}
        centre = body_centre(signals.robot)
        return {'distance': (0.7 * centre, 3.0 * centre)}

    def applies(self, signals: Recording, joint: int) -> bool:
        """
        Tell whether the last body turns and has a centre off its axis, or slides and has weight.

        A mass that gravity does not pull along its slide is an inertia.
        """
        last = signals.robot.n - 1
        if signals.effort_unit(last) == 'Nm':
            return body_centre(signals.robot) > 1e-6
        return lifts(signals.robot)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        robot = fit.signals.robot
        if fit.signals.effort_unit(robot.n - 1) == 'N':
            mass = float(robot.inertial_parameters()[-1][0])
            return '' if mass + fit.amplitude[0] > 0.0 else 'the body would have no mass'
        return '' if fit.amplitude[0] > 0.0 else 'a payload has a positive mass'

    @staticmethod
    def _felt(signals: Recording) -> bool:
        """Tell whether the motion's effort changes with the distance of the mass."""
        centre = body_centre(signals.robot)
        if centre <= 1e-6:
            return False
        own = signals.regressor[:, :, -10:]
        near, far = (own @ point_mass(signals.robot, share * centre) for share in (1.0, 1.5))
        return float(np.linalg.norm(far - near)) > FELT * float(np.linalg.norm(near))


def point_mass(robot: Robot, distance: float) -> FloatArray:
    """Return the ten numbers (10,) of 1 kg at a distance from the last joint [m]."""
    pi = robot.inertial_parameters()[-1]
    r = pi[1:4] / max(float(np.linalg.norm(pi[1:4])), 1e-300) * distance
    tensor = float(r @ r) * np.eye(3) - np.outer(r, r)
    entries = tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
    return np.concatenate([[1.0], r, entries])


def body_centre(robot: Robot) -> float:
    """Return how far the last body's centre of mass is from its joint [m]."""
    pi = robot.inertial_parameters()[-1]
    return float(np.linalg.norm(pi[1:4])) / float(pi[0]) if pi[0] > 0.0 else 0.0


def lifts(robot: Robot) -> bool:
    """Tell whether the last joint feels the weight of its body somewhere: at random positions."""
    rng, still = np.random.default_rng(0), np.zeros(robot.n)
    states = rng.uniform(-1.5, 1.5, (_STATES, robot.n))
    mass = [robot.torque_regressor(q, still, still)[-1, -10] for q in states]
    return float(np.max(np.abs(mass))) > 1e-6
