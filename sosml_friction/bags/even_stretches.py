# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording cut where it has holes, at even steps in between."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.polynomial import Polynomial

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE, held_share

#: Effort that holds for each of steps h is late by half of it, E[h^2] / 2 E[h] on average. Steps
#: are uneven where that is by this share of the median step more than half of it. What differs
#: less is scatter of stamps: of a tenth of a step (standard deviation) it is 0.005.
UNEVEN = 0.1


@dataclass(frozen=True, kw_only=True)
class EvenStretch(JointLog):
    """
    Hold even samples, and ``held`` (N,): how long the effort about each holds, in steps.

    At a recorded sample it is the mean of the steps before and behind it, and between two on the
    line, as effort is.
    """

    held: FloatArray


def even_stretches(log: JointLog, cutoff: float = np.inf) -> list[EvenStretch]:
    """
    Return the log's stretches without holes, each interpolated to even samples.

    A sample is known if it has all positions, and the effort of each joint that has any. A hole
    is more than five median intervals between known samples and more than half a period of
    ``cutoff``, or a step backwards. Shorter gaps are bridged by straight lines, but position
    where it is more than five intervals: by a cubic through what is half a period around.
    Repeated stamps are left out.

    :param cutoff: highest frequency that is asked for [Hz]: samples half a period of it apart
        tell what is slower (Nyquist).
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
    # Stamps are whole nanoseconds, and the median may be between two.
    usual = HOLE * step + 2e-9
    longest = max(usual, 0.5 / cutoff)
    cuts = np.flatnonzero((steps < 0.0) | (steps > longest)) + 1
    held = np.append(step, steps * held_share(time[rows])) / step
    stretches = []
    for run, lasting in zip(np.split(rows, cuts), np.split(held, cuts), strict=True):
        count = round(float(time[run[-1]] - time[run[0]]) / step) + 1
        if count < 3:
            continue
        own = time[run]
        even = np.linspace(own[0], own[-1], count)
        t_ns = log.t_ns[0] + np.rint(even * 1e9).astype(np.int64)
        part = log.rows(run).mapped(partial(on_lines, even, own), t_ns=t_ns)
        for k in np.flatnonzero(np.diff(own) > usual):
            near = slice(*np.searchsorted(own, [own[k] - longest, own[k + 1] + longest]))
            degree = min(3, near.stop - near.start - 1)
            inside = (even > own[k]) & (even < own[k + 1])
            for q, joint in zip(part.q.T, log.q[run].T, strict=True):
                q[inside] = Polynomial.fit(own[near], joint[near], degree)(even[inside])
        between = lasting[1:]
        if 0.5 * (float(between @ between) / float(between.sum()) - 1.0) <= UNEVEN:
            between = np.ones_like(between)
        # A mean since the sample before is of the step before it, a command of the one behind.
        beside = 0.5 * (np.append(between[0], between) + np.append(between, between[-1]))
        stretches.append(EvenStretch(**vars(part), held=np.interp(even, own, beside)))
    return stretches


def on_lines(when: FloatArray, time: FloatArray, x: FloatArray) -> FloatArray:
    """Return columns (N, n) interpolated linearly at other times."""
    return np.column_stack([np.interp(when, time, column) for column in x.T])
