# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""By how much a torque that the nominal lacks is reported, where the report is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.term import ROBOT
from sosml_friction.regression.placed import Placed, with_amplitudes
from sosml_friction.regression.whitened import WhitenedRegression

_FRICTION = ('coulomb', 'viscous')


@dataclass(frozen=True)
class ReportSlopes:
    """
    Tell torques from what is reported of them, of the parameters x (m,) of a fit.

    The regression makes T_0 + f(T_0) + X x of the nominal torque T_0, with f what is reported
    beyond the torque. A torque T_0 + d is reported as T_0 + f(T_0) + (1 + f') d, so that d is
    X x / (1 + f'), f' the mean over the motion: exact where f is in proportion to the torque.
    Where the regression has friction u that the model does not tell in its torque, it makes
    T_0 + f(T_0 + u) + X x, and X x = d + f' (d - u).

    ``steepness`` (m, m): f' of the joint of each parameter, per unit of every parameter; 0 of
    what is no torque, and of what acts in several joints whose reports differ. ``told`` (m,): u.
    """

    steepness: FloatArray
    told: FloatArray

    @classmethod
    def of(cls, laboratory: WhitenedRegression, placed: Sequence[Placed]) -> ReportSlopes:
        """Return that of a fit of the nominal's deviations and the sizes of terms."""
        names, joints = laboratory.nominal.names, laboratory.robot.names
        parts = list(with_amplitudes(placed, len(names)))
        m = parts[-1][1].stop if parts else len(names)
        own = np.zeros((len(joints), m))
        torque = np.concatenate([s.whole_torque for s in laboratory.signals]) if parts else None
        for each, part in parts:
            if torque is None or not isinstance(each.term, MeasurementTerm):
                continue
            where = slice(None) if each.joint == ROBOT else each.joint
            units = np.eye(part.stop - part.start)
            for k, unit in zip(range(part.start, part.stop), units, strict=True):
                steep = each.term.simulated_slope(torque, each.joint, each.inner, unit)
                own[where, k] += np.mean(steep, axis=0) - 1.0
        steepness, told = np.zeros((m, m)), np.zeros(m)
        untold = laboratory.signals[0].untold
        for k, i, what in _of_joints(laboratory):
            steepness[k] = own[i]
            if untold and what in _FRICTION:
                told[k] = untold[i][_FRICTION.index(what)]
        for each, part in parts:
            acted = own[each.columns.rows]
            if isinstance(each.term, EffortTerm | BodyTerm) and (acted == acted[0]).all():
                steepness[part] = acted[0]
        return cls(steepness, told)

    def slopes(self, x: FloatArray) -> FloatArray:
        """Return 1 + f' (m,) of each parameter."""
        return np.asarray(1.0 + self.steepness @ x)

    def torque(self, x: FloatArray) -> FloatArray:
        """Return the parameters (m,) of the torque, where ``x`` are those of the report."""
        slopes = self.slopes(x)
        return np.asarray((x + (slopes - 1.0) * self.told) / slopes)

    def errors(self, x: FloatArray, errors: FloatArray, covariance: FloatArray) -> FloatArray:
        """
        Return the standard errors (m,) of them: the report is not known exactly either.

        :param errors: those of ``x`` (m,).
        :param covariance: of ``x`` first, which says how they go together.
        """
        m = len(x)
        slopes, d = self.slopes(x), self.torque(x)
        own = np.sqrt(np.maximum(np.diag(covariance)[:m], np.finfo(float).tiny))
        together = covariance[:m, :m] / np.outer(own, own) * np.outer(errors, errors)
        change = np.eye(m) / slopes[:, None] + ((self.told - d) / slopes)[:, None] * self.steepness
        square = np.einsum('ki,ij,kj->k', change, together, change)
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))


def _of_joints(laboratory: WhitenedRegression) -> Iterator[tuple[int, int, str]]:
    """Yield each nominal parameter that is of a joint, the joint, and what it is of it."""
    # The name of one joint may begin with that of another.
    joints = sorted(enumerate(laboratory.robot.names), key=lambda own: -len(own[1]))
    for k, name in enumerate(laboratory.nominal.names):
        for i, joint in joints:
            if name.startswith(f'{joint} '):
                yield k, i, name.removeprefix(f'{joint} ')
                break
