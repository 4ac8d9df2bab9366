# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A mass on the last body that the model does not have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Body
from sosml_friction.simulation.forward_terms import BodyTerm


class Payload(Effect):
    """
    Add m Y (1, r, r r'): a point mass m at r from the last joint, towards the body's own centre.

    ``distance`` = |r| [m].
    """

    identifier: ClassVar[str] = 'payload'
    amplitudes: ClassVar[Mapping[str, str]] = {'mass': 'kg'}
    inner: ClassVar[Mapping[str, str]] = {'distance': 'm'}
    refined: ClassVar[tuple[str, ...]] = ('distance',)
    of_robot: ClassVar[bool] = True

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the effort of a point mass of 1 kg."""
        point = point_mass(signals.robot, inner['distance'])
        return np.asarray(signals.regressor[:, :, -10:] @ point)[:, :, None]

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> BodyTerm:
        """Return a last body with the point mass in it."""
        point = float(amplitude[0]) * point_mass(robot, inner['distance'])

        def body(body: Body) -> None:
            body.inertias[-1] += point

        return BodyTerm(body)

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        centre = body_centre(signals)
        return [{'distance': centre * share} for share in (1.0, 1.5, 2.0, 2.5)]

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        centre = body_centre(signals)
        return {'distance': (0.7 * centre, 3.0 * centre)}

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the last body turns and has a centre off its axis."""
        return signals.effort_unit(signals.robot.n - 1) == 'Nm' and body_centre(signals) > 1e-6

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.amplitude[0] <= 0.0:
            return 'a payload has a positive mass'
        return ''


def point_mass(robot: Robot, distance: float) -> FloatArray:
    """Return the ten numbers (10,) of 1 kg at a distance from the last joint [m]."""
    pi = robot.inertial_parameters()[-1]
    r = pi[1:4] / np.linalg.norm(pi[1:4]) * distance
    tensor = float(r @ r) * np.eye(3) - np.outer(r, r)
    entries = tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
    return np.concatenate([[1.0], r, entries])


def body_centre(signals: Signals) -> float:
    """Return how far the last body's centre of mass is from its joint [m]."""
    pi = signals.robot.inertial_parameters()[-1]
    return float(np.linalg.norm(pi[1:4])) / float(pi[0]) if pi[0] > 0.0 else 0.0
