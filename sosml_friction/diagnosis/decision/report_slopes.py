# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""By how much a torque that the nominal lacks is reported, where the report is wrong."""

from collections.abc import Iterator, Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.term import ROBOT
from sosml_friction.regression.estimate import with_amplitudes
from sosml_friction.regression.whitened import WhitenedRegression

_FRICTION = ('coulomb', 'viscous')


def report_slopes(
    laboratory: WhitenedRegression, findings: Sequence[Finding], x: FloatArray
) -> FloatArray:
    """
    Return what the nominal's deviations in ``x`` (p + k,) are reported by; 1 for amplitudes.

    The regression makes T_0 + f(T_0) + X x of the nominal torque T_0, with f what is reported
    beyond the torque. A torque T_0 + d is reported as T_0 + f(T_0) + (1 + f') d, so that d is
    X x / (1 + f'), f' the mean over the motion: exact where f is in proportion to the torque.
    """
    names, joints = laboratory.nominal.names, laboratory.robot.names
    slope = np.ones(len(joints))
    for finding, own in with_amplitudes(findings, len(names)):
        if isinstance(finding.effect, MeasurementTerm):
            where = slice(None) if finding.joint == ROBOT else finding.joint
            torque = np.concatenate([s.whole_torque for s in laboratory.signals])
            steep = finding.effect.simulated_slope(torque, finding.joint, finding.inner, x[own])
            slope[where] += np.mean(steep, axis=0) - 1.0
    result = np.ones(len(x))
    for k, i in _joints(laboratory):
        result[k] = slope[i]
    return result


def in_torque(
    laboratory: WhitenedRegression, findings: Sequence[Finding], x: FloatArray
) -> FloatArray:
    """
    Return the nominal's deviations (p + k,) of the torque, where ``x`` are those of the report.

    Where the regression has friction u that the model does not tell in its torque, it makes
    T_0 + f(T_0 + u) + X x: of d, u and f' as above, X x = d + f' (d - u).
    """
    slopes = report_slopes(laboratory, findings, x)
    untold, names = laboratory.signals[0].untold, laboratory.nominal.names
    told = np.zeros(len(x))
    for k, i in _joints(laboratory) if untold else ():
        what = names[k].removeprefix(f'{laboratory.robot.names[i]} ')
        if what in _FRICTION:
            told[k] = untold[i][_FRICTION.index(what)]
    return np.asarray((x + (slopes - 1.0) * told) / slopes)


def _joints(laboratory: WhitenedRegression) -> Iterator[tuple[int, int]]:
    """Yield each nominal parameter that is of a joint, and the joint."""
    for k, name in enumerate(laboratory.nominal.names):
        for i, joint in enumerate(laboratory.robot.names):
            if name.startswith(f'{joint} '):
                yield k, i
