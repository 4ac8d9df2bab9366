# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the rigid body does where its position is not quite the measured one."""

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.terms.kinds.recording import Recording

#: Step of position for slopes over it [rad or m].
STEP = 1e-4


def coarse_rows(signals: Recording) -> IndexArray:
    """Return samples close enough for what changes as slowly as posture does."""
    rows = np.arange(0, len(signals.q), max(1, signals.band.factor))
    return np.unique(np.append(rows, len(signals.q) - 1))


def between(signals: Recording, rows: IndexArray, coarse: FloatArray) -> FloatArray:
    """Return ``coarse`` (len(rows), ...) at every sample, by lines."""
    flat = coarse.reshape(len(rows), -1)
    samples = np.arange(len(signals.q))
    lines = np.column_stack([np.interp(samples, rows, x) for x in flat.T])
    return lines.reshape(len(signals.q), *coarse.shape[1:])


def mass_and_slope(signals: Recording) -> tuple[FloatArray, FloatArray]:
    """
    Return M without the rotors, and dg/dq, along a recording, each (N, n, n).

    Where body j is d beside its motor, effort is M e_j d'' + dg/dq e_j d more: the first order in
    d of M q'' + g; that of C q' is left out. The rotor is not moved.
    """
    if ('mass', 0) not in signals.cache:
        rows = coarse_rows(signals)
        robot = signals.robot
        n = robot.n
        q = signals.q[rows]
        M = robot.statics(q)[0] - np.diag(robot.armature)
        slope = np.empty((len(rows), n, n))
        for j, e in enumerate(STEP * np.eye(n)):
            slope[:, :, j] = (robot.statics(q + e)[1] - robot.statics(q - e)[1]) / (2.0 * STEP)
        signals.cache[('mass', 0)] = between(signals, rows, M)
        signals.cache[('slope', 0)] = between(signals, rows, slope)
    return signals.cache[('mass', 0)], signals.cache[('slope', 0)]
