# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""By how much a torque that the nominal lacks is reported, where the report is wrong."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.term import ROBOT
from sosml_friction.regression.estimate import Placed, with_amplitudes
from sosml_friction.regression.whitened import WhitenedRegression


def in_torque(
    laboratory: WhitenedRegression, placed: Sequence[Placed], x: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """
    Return parameters (p + k,) with the nominal's deviations in torque, and what divides these.

    The regression makes T_0 + f(T_0) + X x of the nominal torque T_0, with f what is reported
    beyond the torque. A torque T_0 + d is reported as T_0 + f(T_0) + (1 + f') d, so that d is
    X x / (1 + f'), f' the mean over the motion: exact where f is in proportion to the torque.
    Where f is taken at a torque that has the friction d_0 that the nominal does not know, it is
    reported by d + f' (d - d_0).
    """
    names, joints = laboratory.nominal.names, laboratory.robot.names
    slope, beside = np.ones(len(joints)), np.zeros(len(joints))
    for each, own in with_amplitudes(placed, len(names)):
        term = each.term
        if isinstance(term, MeasurementTerm):
            where = slice(None) if each.joint == ROBOT else each.joint
            torque = np.concatenate([term.effort(s) for s in laboratory.signals])
            steep = term.simulated_slope(torque, each.joint, each.inner, x[own])
            slope[where] += np.mean(steep, axis=0) - 1.0
            if term.of_all_effort:
                beside[where] += np.mean(steep, axis=0) - 1.0
    found = laboratory.signals[0].found_friction
    values, slopes = np.array(x), np.ones(len(x))
    for k, name in enumerate(names):
        joint = name.partition(' ')[0]
        if joint in joints:
            i = joints.index(joint)
            slopes[k] = slope[i]
            values[k] = (x[k] + beside[i] * found.get(name, 0.0)) / slope[i]
    return values, slopes
