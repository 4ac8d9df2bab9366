# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms that change the rigid body: inertias, rotors or gravity."""

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.moved_body import between, coarse_rows
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import Body, SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner, Term

#: A change of which all joints together feel less than this share of another change of the same
#: term is felt by none: the angles of a URDF are often rounded to three decimals, an error of at
#: most 5e-4.
FELT = 1e-3


class BodyTerm(Term):
    """State a change of the rigid body, linear in the amplitudes."""

    axis = 'body'
    trusted_as = 'masses'

    @abstractmethod
    def changes(self, robot: Robot, joint: int, inner: Inner) -> tuple[Body, ...]:
        """Return by how much the body changes per unit of each amplitude."""

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """
        Return the effort of each change: regressor, rotors and gravity are linear in it.

        With what the friction by load that the model has takes of it.
        """
        before = np.stack(
            [own.rotors for own in self.changes(signals.robot, joint, inner)], axis=1
        )
        beyond = signals.through_gears(self.carried(signals, joint, inner))
        return np.asarray(signals.a[:, :, None] * before + beyond)

    def carried(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the same of what the gears pass on: rotors are before them."""
        changes = self.changes(signals.robot, joint, inner)
        result = np.stack([_carried(signals, own) for own in changes], axis=2)
        size = np.linalg.norm(result, axis=(0, 1))
        result[:, :, size < FELT * size.max()] = 0.0
        return result

    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """Return the changed body."""
        return ChangedBody(self.changes(robot, joint, inner), amplitude)


def _carried(signals: Recording, change: Body) -> FloatArray:
    """Return the effort (N, n) that a small change of the bodies takes along a recording."""
    used = np.flatnonzero(change.inertias.ravel())
    result = signals.regressor[:, :, used] @ change.inertias.ravel()[used]
    if change.gravity.any():
        key = ('gravity', *change.gravity)
        if key not in signals.cache:
            rows = coarse_rows(signals)
            _, under = signals.robot.statics(signals.q[rows], change.gravity)
            signals.cache[key] = between(signals, rows, under)
        result = result + signals.cache[key]
    return np.asarray(result)


class ChangedBody(SimulatedTerm):
    """Add each change, times its amplitude, to the bodies of the robot."""

    def __init__(self, changes: Sequence[Body], amplitude: Sequence[float] | FloatArray) -> None:
        self._changes = tuple(changes)
        self._amplitude = amplitude

    def change_body(self, body: Body) -> None:
        """Add the changes."""
        for change, size in zip(self._changes, self._amplitude, strict=True):
            body.add(change, float(size))
