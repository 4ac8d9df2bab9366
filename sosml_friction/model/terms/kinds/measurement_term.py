# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms of the way from torque to reported effort."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import ROBOT, Inner, Term

#: Newton's rule doubles the number of right digits in each round: 8 are more than enough where
#: what is added is at most as steep as the torque itself.
_ROUNDS = 8
#: Step of the complex-step derivative, exact to rounding however small.
_TINY = 1e-30
#: Torques at which a report has to rise with the torque [Nm or N].
_TORQUES = np.concatenate([-np.geomspace(1e3, 1e-3, 13), [0.0], np.geomspace(1e-3, 1e3, 13)])


class MeasurementTerm(Term):
    """State how much more than the torque is reported, linear in the amplitudes."""

    axis = 'effort'

    @abstractmethod
    def excess(
        self, torque: NDArray[np.inexact], joint: int | slice, inner: Inner
    ) -> tuple[NDArray[np.inexact], ...]:
        """
        Return what is reported beyond the torque, per unit of each amplitude, (...,).

        :param torque: of all joints, (..., n) [Nm or N]; may be complex, so write an analytic
            function of it.
        :param joint: the joint whose report it is; a slice for all.
        """

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the excess over the torque of a recording, (N, n, k)."""
        where = slice(None) if joint == ROBOT else joint
        parts = [np.real(part) for part in self.excess(signals.whole_torque, where, inner)]
        return np.stack(parts, axis=2) if joint == ROBOT else signals.in_joint(joint, *parts)

    def simulated(
        self, robot: Robot | None, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedReport:
        """Return the report with its numbers."""
        return SimulatedReport(self, joint, inner, amplitude)

    def not_undone(self, n: int, joint: int, inner: Inner, amplitude: FloatArray) -> bool:
        """Tell whether there is no one torque behind each report."""
        torque = np.tile(_TORQUES[:, None], (1, n))
        with np.errstate(all='ignore'):
            slope = self.simulated_slope(torque, joint, inner, amplitude)
        return not bool((slope > 0.0).all() and np.isfinite(slope).all())

    def simulated_slope(
        self, torque: FloatArray, joint: int, inner: Inner, amplitude: FloatArray
    ) -> FloatArray:
        """Return the slope of the report of ``joint`` over its own torque, by the complex step."""
        where = slice(None) if joint == ROBOT else joint
        turned = torque.astype(complex)
        turned[..., where] += 1j * _TINY
        parts = self.excess(turned, where, inner)
        total = sum(float(x) * part for x, part in zip(amplitude, parts, strict=True))
        return np.asarray(1.0 + np.imag(total) / _TINY)


class SimulatedReport(SimulatedTerm):
    """A report with its numbers, and the torque behind it by Newton's rule."""

    def __init__(
        self, term: MeasurementTerm, joint: int, inner: Inner, amplitude: FloatArray
    ) -> None:
        self._term, self._joint, self._inner = term, joint, inner
        self._where: int | slice = slice(None) if joint == ROBOT else joint
        self._amplitude = [float(x) for x in amplitude]

    def _excess(self, torque: FloatArray) -> FloatArray:
        parts = self._term.excess(torque, self._where, self._inner)
        return np.asarray(sum(x * part for x, part in zip(self._amplitude, parts, strict=True)))

    def reported(self, torque: FloatArray) -> FloatArray:
        """Return torque plus excess."""
        result = np.array(torque, dtype=float)
        result[..., self._where] += self._excess(torque)
        return result

    def torque(self, reported: FloatArray) -> FloatArray:
        """Return the torque whose report it is; what is not known stays so."""
        result = np.array(reported, dtype=float)
        wanted = result[..., self._where].copy()
        amplitude = np.array(self._amplitude)
        for _ in range(_ROUNDS):
            own = result[..., self._where]
            slope = self._term.simulated_slope(result, self._joint, self._inner, amplitude)
            change = (own + self._excess(result) - wanted) / slope
            result[..., self._where] = own - change
            size = np.abs(own) * np.finfo(float).eps
            if not (np.abs(change) > size).any():
                break
        return result
