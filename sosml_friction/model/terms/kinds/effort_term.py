# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms that are an effort of one joint: a function of its motion, linear in the amplitudes."""

from abc import abstractmethod
from collections.abc import Sequence
from copy import copy
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner, Term

#: Postures at which the steepest slopes are looked for, and the step of position [rad or m].
_POSTURES, _STEP = 720, 1e-6
#: No gear gets warmer than this [K]: how much friction a simulation has to be ready for.
WARMEST = 50.0


class EffortTerm(Term):
    """State an effort that the actuator spends in one joint, positive where friction is."""

    trusted_as: ClassVar[str] = 'friction'

    @abstractmethod
    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """
        Return the effort per unit of each amplitude, (N,) each [Nm or N].

        :param joint: which column of the motion; a slice where ``inner`` holds arrays (n,), one
            entry for each joint, and the result is (N, n).
        :param state: the term's own states (N, k), see :meth:`path_state`; (N, 0) for none.
        """

    def path_state(self, path: FloatArray, inner: Inner) -> FloatArray:
        """Return the term's own states (N, k) along the joint's positions (N,), from rest."""
        return np.zeros((len(path), 0))

    def next_state(self, state: FloatArray, dq: FloatArray, inner: Inner) -> FloatArray:
        """Return the states (N, k) after the joint moved by ``dq`` (N,)."""
        return state

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the effort along a recording per unit of each amplitude, (N, n, k)."""
        state = self.path_state(np.ascontiguousarray(signals.q[:, joint]), inner)
        return signals.in_joint(joint, *self.effort(signals.motion, joint, inner, state))

    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """Return the effort with its numbers."""
        return _SimulatedEffort(self, joint, inner, amplitude)


class _SimulatedEffort(SimulatedTerm):
    def __init__(self, term: EffortTerm, joint: int, inner: Inner, amplitude: FloatArray) -> None:
        self._term, self._joint, self._inner = term, joint, dict(inner)
        self._amplitude: Sequence[FloatArray | float] = [float(x) for x in amplitude]

    def start(self, path: FloatArray, at: IndexArray) -> FloatArray:
        own = np.ascontiguousarray(path[:, self._joint])
        return self._term.path_state(own, self._inner)[at]

    def advance(self, state: FloatArray, dq: FloatArray) -> FloatArray:
        return self._term.next_state(state, dq[:, self._joint], self._inner)

    @property
    def _kind(self) -> tuple[type, int, Inner]:
        return type(self._term), self._joint, self._inner

    def of_windows(self, terms: Sequence[SimulatedTerm], of: IndexArray) -> SimulatedTerm:
        """Return the term with an amplitude of each window, where all else is the same."""
        own = [term for term in terms if isinstance(term, _SimulatedEffort)]
        if len(own) < len(terms) or any(term._kind != self._kind for term in own):
            return super().of_windows(terms, of)
        amplitudes = [term._amplitude for term in own]
        result = copy(self)
        result._amplitude = [np.array(each)[of] for each in zip(*amplitudes, strict=True)]
        return result

    def load(self, motion: Motion, state: FloatArray) -> FloatArray:
        result = np.zeros_like(motion.q)
        result[:, self._joint] = self._own(motion, self._joint, state)
        return result

    def _own(self, motion: Motion, joint: int, state: FloatArray) -> FloatArray:
        parts = self._term.effort(motion, joint, self._inner, state)
        return np.asarray(sum(x * part for x, part in zip(self._amplitude, parts, strict=True)))

    def _at(self, q: FloatArray, sign: float, load: float, side: float = 0.0) -> FloatArray:
        """Return the effort at rest, warm, at positions (P,); own states all at ``side``."""
        one = np.ones((len(q), 1))
        motion = Motion(
            np.full(len(q), np.inf), q[:, None], 0.0 * one, sign * one, load * one, WARMEST * one
        )
        state = self._term.path_state(np.zeros(1), self._inner)
        return self._own(motion, 0, np.full((len(q), state.shape[1]), side))

    def friction_level(self, effort: FloatArray) -> FloatArray:
        """
        Return the most it adds to the level of friction, in its joint.

        The largest step of effort between rest and a sign of motion, over postures.
        """
        q = np.linspace(0.0, 2.0 * np.pi, _POSTURES)
        load = float(effort[self._joint])
        still = self._at(q, 0.0, load)
        steps = [np.abs(self._at(q, sign, load) - still).max() for sign in (-1.0, 1.0)]
        result = np.zeros(len(effort))
        result[self._joint] = max(steps)
        return result

    def stiffness(self) -> float:
        """
        Return the steepest slope over position; it counts in every joint, on the safe side.

        Of position itself, and of the states, which change as the joint moves.
        """
        q = np.linspace(0.0, 2.0 * np.pi, _POSTURES)
        ahead, behind = self._at(q + _STEP, 0.0, 0.0), self._at(q - _STEP, 0.0, 0.0)
        slope = float(np.abs(ahead - behind).max()) / (2.0 * _STEP)
        state = self._term.path_state(np.zeros(1), self._inner)
        if state.shape[1]:
            moved = self._term.next_state(0.0 * state, np.array([_STEP]), self._inner)
            per_state = self._at(q[:1], 0.0, 0.0, 1.0) - self._at(q[:1], 0.0, 0.0, 0.0)
            slope += float(np.abs(per_state).max()) * float(np.abs(moved).max()) / _STEP
        return slope
