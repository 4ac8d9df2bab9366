# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A mass on the last body."""

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import FELT, BodyTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.moved_body import coarse_rows
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.terms.kinds.term import Inner

#: Positions at which weight is looked for: robots have no more than a few at which it is none.
_STATES = 10
#: A mass is no farther from the last joint than the robot's longest link is long, or than this
#: many times the body's own centre: tools are as long as links at most. Chosen, no measurement.
_FARTHEST = 3.0
#: How far from the body's own centre a place is looked for first along each coordinate, as a share
#: of the farthest: effort is linear in them but for the moment of inertia, so that sides will do.
_ASIDE = 0.5
_AXES = ('x', 'y', 'z')


class Payload(BodyTerm):
    """
    Add m Y (1, r, r'r E - r r'): a point mass m at r = (x, y, z) on the last body.

    In the frame of the last link, from its joint [m]; Y is the body's regressor. A coordinate
    that no joint feels is that of the body's own centre. On a slide it is any mass that is not the
    model's, less of it too: nothing else of the catalogue changes what a slide has to lift.
    """

    identifier: ClassVar[str] = 'payload'
    amplitudes: ClassVar[Mapping[str, str]] = {'mass': 'kg'}
    inner: ClassVar[Mapping[str, str]] = dict.fromkeys(_AXES, 'm')
    refined: ClassVar[tuple[str, ...]] = _AXES
    of_robot: ClassVar[bool] = True

    def changes(self, robot: Robot, joint: int, inner: Inner) -> tuple[Body, ...]:
        """Return 1 kg at the place."""
        body = Body.unchanged(robot.n)
        body.inertias[-1] = point_mass(np.array([inner[axis] for axis in _AXES]))
        return (body,)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the places to try."""
        centre = dict(zip(_AXES, body_centre(signals.robot).tolist(), strict=True))
        aside = _ASIDE * farthest(signals.robot)
        sides = [
            {**centre, axis: centre[axis] + way * aside}
            for axis in self._felt(signals)
            for way in (1.0, -1.0)
        ]
        return [centre, *sides]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range of the coordinates that a joint feels."""
        far = farthest(signals.robot)
        return dict.fromkeys(self._felt(signals), (-far, far))

    def applies(self, signals: Recording, joint: int) -> bool:
        """
        Tell whether the last body turns, or slides and has weight.

        A mass that gravity does not pull along its slide is an inertia.
        """
        robot = signals.robot
        if signals.effort_unit(robot.n - 1) == 'Nm':
            return farthest(robot) > 0.0
        return lifts(robot)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        robot = fit.signals.robot
        if fit.signals.effort_unit(robot.n - 1) == 'N':
            mass = float(robot.inertial_parameters()[-1][0])
            return '' if mass + fit.amplitude[0] > 0.0 else 'the body would have no mass'
        return '' if fit.amplitude[0] > 0.0 else 'a payload has a positive mass'

    def of_older(
        self, parameters: Mapping[str, Parameter], robot: Callable[[], Robot]
    ) -> Mapping[str, Parameter]:
        """Return the place of a mass on the line to the body's own centre, by its distance."""
        if 'distance' not in parameters:
            return parameters
        own = dict(parameters)
        distance, centre = own.pop('distance'), body_centre(robot())
        way = centre / max(float(np.linalg.norm(centre)), np.finfo(float).tiny)
        for axis, share in zip(_AXES, way.tolist(), strict=True):
            error = distance.std_error * abs(share)
            own[axis] = Parameter(distance.value * share, distance.unit, error)
        return own

    @staticmethod
    def _felt(signals: Recording) -> tuple[str, ...]:
        """
        Return the coordinates of the place that change the effort in more than proportion.

        Not so of one that another mass would do as well.
        """
        key = ('payload felt', 0)
        if key not in signals.cache:
            rows = coarse_rows(signals)
            own, robot = signals.regressor[rows][:, :, -10:], signals.robot
            centre, step = body_centre(robot), 0.5 * farthest(robot)
            places = [centre, *(centre + step * np.eye(3))]
            there, *moved = (own @ point_mass(place) for place in places)
            unit = there / max(float(np.linalg.norm(there)), np.finfo(float).tiny)
            beside = [float(np.linalg.norm(x - np.vdot(x, unit) * unit)) for x in moved]
            most = max(float(np.linalg.norm(x)) for x in (there, *moved))
            signals.cache[key] = np.array(beside) / max(most, np.finfo(float).tiny)
        shares = signals.cache[key].tolist()
        return tuple(axis for axis, own in zip(_AXES, shares, strict=True) if own > FELT)


def point_mass(r: FloatArray) -> FloatArray:
    """Return the ten numbers (10,) of 1 kg at r (3,) [m]."""
    tensor = float(r @ r) * np.eye(3) - np.outer(r, r)
    entries = tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
    return np.concatenate([[1.0], r, entries])


def body_centre(robot: Robot) -> FloatArray:
    """Return the last body's centre of mass from its joint (3,) [m]; 0 without a mass."""
    pi = robot.inertial_parameters()[-1]
    return np.asarray(pi[1:4] / pi[0] if pi[0] > 0.0 else np.zeros(3))


def farthest(robot: Robot) -> float:
    """Return how far from the last joint a mass may be [m]."""
    return max(robot.longest_link, _FARTHEST * float(np.linalg.norm(body_centre(robot))))


def lifts(robot: Robot) -> bool:
    """Tell whether the last joint feels the weight of its body somewhere: at random positions."""
    rng, still = np.random.default_rng(0), np.zeros(robot.n)
    states = rng.uniform(-1.5, 1.5, (_STATES, robot.n))
    mass = [robot.torque_regressor(q, still, still)[-1, -10] for q in states]
    return float(np.max(np.abs(mass))) > 1e-6
