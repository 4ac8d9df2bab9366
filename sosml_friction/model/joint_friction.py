# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction laws of all joints at once, with a state in the place of the sign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.laws import FrictionLaw
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import TERMS


@dataclass(frozen=True)
class _Part:
    """One term in all joints: its inner parameters and amplitudes by name, (n,) each."""

    term: EffortTerm
    inner: Mapping[str, FloatArray]
    amplitudes: Mapping[str, FloatArray]

    def effort(self, motion: Motion) -> list[FloatArray]:
        state = np.zeros((len(motion.v), 0))
        # Inner parameters as arrays, one entry for each joint: see EffortTerm.effort.
        inner = cast(Mapping[str, float], self.inner)
        return list(self.term.effort(motion, slice(None), inner, state))


class JointFriction:
    """
    Hold the friction of n joints: the terms of their laws, each for all joints at once.

    :param laws: one for each joint, None for a joint without friction.
    """

    def __init__(self, laws: Sequence[FrictionLaw | None]) -> None:
        self.n = len(laws)
        kinds = dict.fromkeys(kind for law in laws if law for kind in law.definition.kinds)
        parts = []
        for kind in kinds:
            inner = {name: np.ones(self.n) for name in kind.inner}
            amplitudes = {name: np.zeros(self.n) for name in kind.amplitudes}
            for i, law in enumerate(laws):
                if law is None or kind not in law.definition.kinds:
                    continue
                values = {**law.definition.fixed, **law.parameters}
                for target in (inner, amplitudes):
                    for name, array in target.items():
                        array[i] = values[name]
            parts.append(_Part(kind(), inner, amplitudes))
        self._parts = tuple(parts)

    def changed(self, changes: Mapping[str, FloatArray]) -> JointFriction:
        """
        Return the same with other amplitudes.

        :param changes: by name of an amplitude, what is added to it in each joint (n,); a term
            that no joint had is added.
        """
        result = JointFriction([None] * self.n)
        parts = {part.term.identifier: part for part in self._parts}
        left = {name: change for name, change in changes.items() if change.any()}
        for identifier, part in parts.items():
            amplitudes = {
                name: array + left.pop(name, np.zeros(self.n))
                for name, array in part.amplitudes.items()
            }
            parts[identifier] = _Part(part.term, part.inner, amplitudes)
        for name, change in left.items():
            kind = next(
                k
                for k in TERMS.values()
                if issubclass(k, EffortTerm) and k.of_law and name in k.amplitudes and not k.inner
            )
            parts[kind.identifier] = _Part(kind(), {}, {name: change})
        result._parts = tuple(parts.values())
        return result

    @classmethod
    def of_windows(cls, frictions: Sequence[JointFriction], of: IndexArray) -> JointFriction:
        """
        Return the friction of W windows, of which window w has ``frictions[of[w]]``.

        For :meth:`torque` alone. What is not an amplitude is the same in all.
        """
        result = cls([None] * frictions[0].n)
        parts: dict[str, _Part] = {}
        for friction in frictions:
            parts |= {part.term.identifier: part for part in friction._parts}
        for identifier, part in parts.items():
            amplitudes = {}
            for name, array in part.amplitudes.items():
                own = [friction._amplitude(identifier, name, array) for friction in frictions]
                amplitudes[name] = np.array(own)[of]
            parts[identifier] = _Part(part.term, part.inner, amplitudes)
        result._parts = tuple(parts.values())
        return result

    def _amplitude(self, identifier: str, name: str, like: FloatArray) -> FloatArray:
        for part in self._parts:
            if part.term.identifier == identifier:
                return part.amplitudes[name]
        return np.zeros_like(like)

    def torque(self, v: FloatArray, sign: FloatArray) -> FloatArray:
        """Return tau_f (N, n) [Nm or N] at velocities and signs (N, n)."""
        motion = Motion.steady(v, sign)
        total = np.zeros_like(v)
        for part in self._parts:
            for size, column in zip(part.amplitudes.values(), part.effort(motion), strict=True):
                if size.any():
                    total = total + size * column
        return total

    def _steps(self, before: tuple[float, float], after: tuple[float, float]) -> FloatArray:
        """Return the sum (n,) of what each term changes by, in size, between two (v, sign)."""
        total = np.zeros(self.n)
        first, second = (
            Motion.steady(np.full((1, self.n), v), np.full((1, self.n), s))
            for v, s in (before, after)
        )
        for part in self._parts:
            pairs = zip(part.effort(first), part.effort(second), strict=True)
            for size, (one, other) in zip(part.amplitudes.values(), pairs, strict=True):
                total = total + np.abs(size * (other[0] - one[0]))
        return total

    @property
    def level(self) -> FloatArray:
        """Return the most that the sign is multiplied with, (n,): that at standstill."""
        return self._steps((0.0, 0.0), (0.0, 1.0))

    @property
    def damping(self) -> FloatArray:
        """Return the slope over velocity, (n,) [Nm s/rad or N s/m], where Stribeck has faded."""
        return self._steps((1e3, 1.0), (1e3 + 1.0, 1.0))
