# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One term with its numbers, as a simulation meets it."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.terms.kinds.motion import Motion


@dataclass
class Body:
    """
    Hold what the rigid bodies are made of, or by how much it changes.

    ``inertias`` (n, 10) as :meth:`~sosml_friction.model.robot.Robot.inertial_parameters`;
    ``rotors`` (n,) reflected inertia [kg m2 or kg]; ``gravity`` (3,) [m/s2].
    """

    inertias: FloatArray
    rotors: FloatArray
    gravity: FloatArray

    @classmethod
    def unchanged(cls, n: int) -> Body:
        """Return no change of n bodies."""
        return cls(np.zeros((n, 10)), np.zeros(n), np.zeros(3))

    def add(self, change: Body, size: float) -> None:
        """Add ``size`` times a change."""
        self.inertias += size * change.inertias
        self.rotors += size * change.rotors
        self.gravity += size * change.gravity


@dataclass(frozen=True)
class Gear:
    """
    Hold a gear that gives: torque ``stiffness`` * (motor - body) outside of ``gap`` / 2.

    ``damping``: share of the critical damping of the body on it.
    """

    joint: int
    stiffness: float
    gap: float
    damping: float


class SimulatedTerm(ABC):  # noqa: B024 - a kind of term overrides what it has, mostly one thing
    """
    Say how one term enters a simulation; what is not overridden is nothing.

    :meth:`load` is effort that the actuator spends, positive where friction is. Effort is
    *reported* by the actuator's current and is a *torque* at the joint; a term may map one to the
    other, shift the report in time, or bend the measured position.
    """

    #: How long after the torque it is reported [s], of each joint (n,) or alike.
    delay: FloatArray | float = 0.0

    def change_body(self, body: Body) -> None:
        """Change inertias, rotors or gravity, in place."""
        return

    def gear(self) -> Gear | None:
        """Return the gear that gives, or None."""
        return None

    def start(self, path: FloatArray, at: IndexArray) -> FloatArray:
        """
        Return the term's own states, (W, k), at the samples ``at`` of a measured path (N, n).

        A state with memory is computed along the path up to there.
        """
        return np.zeros((len(at), 0))

    def advance(self, state: FloatArray, dq: FloatArray) -> FloatArray:
        """Return the states after the motors moved by ``dq`` (W, n)."""
        return state

    def load(self, motion: Motion, state: FloatArray) -> FloatArray | None:
        """Return the effort that it takes, (W, n) [Nm or N], or None for none."""
        return None

    def torque(self, reported: FloatArray) -> FloatArray:
        """Return the torque at the joint behind a reported effort, (..., n)."""
        return reported

    def reported(self, torque: FloatArray) -> FloatArray:
        """Return what the actuator reports of a torque, (..., n): the inverse of the former."""
        return torque

    def true_position(self, measured: FloatArray) -> FloatArray:
        """Return where the motors are that the encoders say are at ``measured``, (..., n)."""
        return measured

    def of_windows(self, terms: Sequence[SimulatedTerm], of: IndexArray) -> SimulatedTerm:
        """
        Return one term for W windows, of which window w has ``terms[of[w]]``.

        For :meth:`load` and :meth:`advance` alone, which a simulation calls at every step.

        :param terms: the same term with other numbers; this one is the first.
        """
        if type(self).load is SimulatedTerm.load:
            return self
        return _OfWindows(terms, of)

    def friction_level(self, effort: FloatArray) -> FloatArray | float:
        """Return the most it adds to what the sign of motion is multiplied with, (n,)."""
        return 0.0

    def stiffness(self) -> FloatArray | float:
        """Return the steepest slope of its load over position, (n,)."""
        return 0.0


class _OfWindows(SimulatedTerm):
    """A term with other numbers in each group of windows, one group after the other."""

    def __init__(self, terms: Sequence[SimulatedTerm], of: IndexArray) -> None:
        self._groups = [(term, np.flatnonzero(of == k)) for k, term in enumerate(terms)]

    def advance(self, state: FloatArray, dq: FloatArray) -> FloatArray:
        result = state.copy()
        for term, own in self._groups:
            result[own] = term.advance(state[own], dq[own])
        return result

    def load(self, motion: Motion, state: FloatArray) -> FloatArray:
        result = np.zeros_like(motion.q)
        for term, own in self._groups:
            part = term.load(motion.of(own), state[own])
            if part is not None:
                result[own] = part
        return result
