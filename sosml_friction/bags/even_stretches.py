# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording cut where it has holes, at even steps in between."""

from functools import partial

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE


def even_stretches(log: JointLog) -> list[JointLog]:
    """
    Return the log's stretches without holes, each interpolated to even samples.

    A sample is known if it has all positions, and the effort of each joint that has any. A hole
    is more than five median intervals between known samples, or a step backwards; shorter gaps
    are interpolated linearly. Repeated stamps are left out.
    """
    time = log.time
    effort = np.isfinite(log.tau)
    # A joint that never has effort is no hole.
    has = effort.any(axis=0)
    known = np.isfinite(log.q).all(axis=1) & effort[:, has].all(axis=1) & has.any()
    rows = np.flatnonzero(known)
    if len(rows) < 2:
        return []
    rows = rows[np.append(True, np.diff(time[rows]) != 0.0)]
    steps = np.diff(time[rows])
    forwards = steps[steps > 0.0]
    if not len(forwards):
        return []
    step = float(np.median(forwards))
    cuts = np.flatnonzero((steps < 0.0) | (steps > HOLE * step)) + 1
    stretches = []
    for run in np.split(rows, cuts):
        count = round(float(time[run[-1]] - time[run[0]]) / step) + 1
        if count < 3:
            continue
        even = np.linspace(time[run[0]], time[run[-1]], count)
        t_ns = log.t_ns[0] + np.rint(even * 1e9).astype(np.int64)
        part = log.rows(run)
        stretches.append(part.mapped(partial(on_lines, even, time[run]), t_ns=t_ns))
    return stretches


def on_lines(when: FloatArray, time: FloatArray, x: FloatArray) -> FloatArray:
    """Return columns (N, n) interpolated linearly at other times."""
    return np.column_stack([np.interp(when, time, column) for column in x.T])
