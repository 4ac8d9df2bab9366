# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""By how much a torque that the nominal lacks is reported, where the report is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.known_terms import KnownTerm
from sosml_friction.model.terms.effort_scale import LARGEST
from sosml_friction.model.terms.joint_coupling import JointCoupling
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.term import ROBOT
from sosml_friction.regression.placed import Placed, with_amplitudes
from sosml_friction.regression.whitened import WhitenedRegression

_FRICTION = ('coulomb', 'viscous')
#: A report of less than this share of the torque is refused as a cause: what is made of it is told
#: as it was reported.
_LEAST = 1.0 - LARGEST


@dataclass(frozen=True)
class ReportSlopes:
    """
    Tell torques from what is reported of them, of the parameters x (m,) of a fit.

    The regression makes T_0 + f(T_0) + X x of the nominal torque T_0, with f what is reported
    beyond the torque. A torque T_0 + d is reported as T_0 + f(T_0) + (1 + f') d, so that d is
    X x / (1 + f'), f' the mean over the motion: exact where f is in proportion to the torque.
    Where the regression has friction u that the model does not tell in its torque, it makes
    T_0 + f(T_0 + u) + X x, and X x = d + f' (d - u). A coupling c has the report of the other
    joint as its column, so that c is x (1 + f') with the f' of that one.

    ``constant`` (m,) and ``steepness`` (m, m): f' of the joint of each parameter is constant, as
    the model states it, + steepness x; 0 of what is no torque, and of what acts in several joints
    whose reports differ. ``other_constant`` and ``other_steepness``: those of the joint that a
    coupling comes from. ``untold`` (m,): u.
    """

    constant: FloatArray
    steepness: FloatArray
    other_constant: FloatArray
    other_steepness: FloatArray
    untold: FloatArray

    @classmethod
    def of(cls, laboratory: WhitenedRegression, placed: Sequence[Placed]) -> ReportSlopes:
        """Return that of a fit of the nominal's deviations and the sizes of terms."""
        names, n = laboratory.nominal.names, laboratory.robot.n
        parts = list(with_amplitudes(placed, len(names)))
        m = parts[-1][1].stop if parts else len(names)
        stated, own = np.zeros(n), np.zeros((n, m))
        for known in (each.known for each in laboratory.signals[0].stated):
            if isinstance(known.term, MeasurementTerm):
                where, slope = _slope(laboratory, known.term, known, known.amplitude)
                stated[where] += slope
        for each, part in parts:
            if isinstance(each.term, MeasurementTerm):
                units = np.eye(part.stop - part.start)
                for k, unit in zip(range(part.start, part.stop), units, strict=True):
                    where, slope = _slope(laboratory, each.term, each, unit)
                    own[where, k] += slope
        result = cls(*(np.zeros(shape) for shape in (m, (m, m), m, (m, m), m)))
        friction: dict[tuple[int, str], int] = {}
        for k, i, what in _of_joints(laboratory):
            result.constant[k], result.steepness[k] = stated[i], own[i]
            if what in _FRICTION:
                friction[i, what] = k
        for each, part in parts:
            acted = each.columns.rows
            alike = len({(float(stated[i]), *own[i].tolist()) for i in acted.tolist()}) == 1
            if isinstance(each.term, EffortTerm | BodyTerm) and alike:
                result.constant[part], result.steepness[part] = stated[acted[0]], own[acted[0]]
            if isinstance(each.term, JointCoupling):
                source = int(each.inner['source'])
                result.other_constant[part] = stated[source]
                result.other_steepness[part] = own[source]
            if (each.joint, each.term.identifier) in friction:
                # The term stands for the nominal's number.
                friction[each.joint, each.term.identifier] = part.start
        untold = laboratory.signals[0].untold
        for (i, what), k in friction.items() if untold else ():
            result.untold[k] = untold[i][_FRICTION.index(what)]
        return result

    def slopes(self, x: FloatArray) -> FloatArray:
        """Return 1 + f' (m,) of each parameter; 1 where the report is refused."""
        slopes = 1.0 + self.constant + self.steepness @ x
        return np.where(slopes < _LEAST, 1.0, slopes)

    def torque(self, x: FloatArray) -> FloatArray:
        """Return the parameters (m,) of the torque, where ``x`` are those of the report."""
        return self._own(x) * self._other(x)

    def errors(self, x: FloatArray, errors: FloatArray, covariance: FloatArray) -> FloatArray:
        """
        Return the standard errors (m,) of them: the report is not known exactly either.

        :param errors: those of ``x`` (m,).
        :param covariance: of ``x`` first, which says how they go together.
        """
        m = len(x)
        slopes, own, other = self.slopes(x), self._own(x), self._other(x)
        # What the data do not tell apart has no variance of its own, or one below 0 by rounding.
        variance = np.diag(covariance)[:m]
        size = np.sqrt(np.where(variance > 0.0, variance, np.inf))
        correlation = np.clip(covariance[:m, :m] / np.outer(size, size), -1.0, 1.0)
        np.fill_diagonal(correlation, 1.0)
        together = correlation * np.outer(errors, errors)
        refused = (1.0 + self.constant + self.steepness @ x < _LEAST)[:, None]
        steepness = np.where(refused, 0.0, self.steepness)
        change = np.eye(m) + (self.untold - own)[:, None] * steepness
        change = (other / slopes)[:, None] * change + own[:, None] * self.other_steepness
        square = np.einsum('ki,ij,kj->k', change, together, change)
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))

    def _own(self, x: FloatArray) -> FloatArray:
        slopes = self.slopes(x)
        return np.asarray((x + (slopes - 1.0) * self.untold) / slopes)

    def _other(self, x: FloatArray) -> FloatArray:
        return np.asarray(1.0 + self.other_constant + self.other_steepness @ x)


def _slope(
    laboratory: WhitenedRegression,
    term: MeasurementTerm,
    at: Placed | KnownTerm,
    amplitude: FloatArray,
) -> tuple[slice, FloatArray]:
    """Return the joints whose report a term makes steeper, and by how much, mean over a motion."""
    where = slice(None) if at.joint == ROBOT else slice(at.joint, at.joint + 1)
    torque = np.concatenate([s.whole_torque for s in laboratory.signals])
    slope = term.simulated_slope(torque, at.joint, at.inner, amplitude)
    return where, np.mean(slope, axis=0) - 1.0


def _of_joints(laboratory: WhitenedRegression) -> Iterator[tuple[int, int, str]]:
    """Yield each nominal parameter that is of a joint, the joint, and what it is of it."""
    # The name of one joint may begin with that of another.
    joints = sorted(enumerate(laboratory.robot.names), key=lambda own: -len(own[1]))
    for k, name in enumerate(laboratory.nominal.names):
        for i, joint in joints:
            if name.startswith(f'{joint} '):
                yield k, i, name.removeprefix(f'{joint} ')
                break
