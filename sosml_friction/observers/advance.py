# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From samples to the intervals between them, compiled: the same code for one and for many."""

import math

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.compiled import compiled
from sosml_friction.model.rigid_terms import rigid_terms, work_space

#: What became of a sample: with the stamp of the one before; nothing usable, no start; a start;
#: the end of an interval.
REPEATED, UNUSABLE, START, INTERVAL = range(4)
#: Added to that where the past was forgotten, and why.
GAP, BACKWARDS = 8, 16
#: What became of it, without what was added.
OUTCOME = 7
#: Of ``kept``: whether there is a stamp, it, and whether the observers run.
BEGUN, STAMP, RUNNING = range(3)


@compiled
def advance(
    tree: FloatArray,
    weights: FloatArray,
    maximum_gap_s: float,
    differentiated: bool,
    stamps: IndexArray,
    motion: FloatArray,
    kept: IndexArray,
    memory: FloatArray,
    h: FloatArray,
    driven: FloatArray,
    inertia: FloatArray,
) -> int:
    """
    Take N samples of n joints, write the intervals that end at them, return the last's status.

    The rows of ``driven`` and ``inertia`` of a sample that ends no interval hold anything, but for
    the momentum of a start.

    :param tree: of :func:`~sosml_friction.model.rigid_constants.rigid_constants`.
    :param weights: (n,) of the effort at the end of an interval; that at its start has the rest.
    :param differentiated: whether velocities are the backward differences of positions.
    :param stamps: (2, N) int64: the stamps [ns]; written: the status, an outcome and flags.
    :param motion: q, v and tau, (3, N, n); v is overwritten if it is ``differentiated``.
    :param kept: from sample to sample, (3,), as said there.
    :param memory: likewise (4 + n, n): q, v, C^T q' - g, tau and M at the last usable sample.
    :param h: (N,), written [s].
    :param driven: (3, N, n), written: p, integral and forcing as in
        :class:`~sosml_friction.observers.momentum_samples.MomentumSamples`.
    :param inertia: (N, n, n), written.
    """
    n = len(weights)
    work = work_space(tree)
    drift, difference = np.empty(n), np.empty(n)
    for k in range(len(h)):
        forgotten = 0
        h[k] = np.nan
        if kept[BEGUN]:
            if stamps[0, k] == kept[STAMP]:
                stamps[1, k] = REPEATED
                continue
            h[k] = (stamps[0, k] - kept[STAMP]) * 1e-9
            if h[k] < 0.0 or h[k] > maximum_gap_s:
                forgotten = BACKWARDS if h[k] < 0.0 else GAP
                kept[RUNNING] = 0
                memory[:] = np.nan
        kept[BEGUN], kept[STAMP] = 1, stamps[0, k]
        measured = usable = True
        for i in range(n):
            difference[i] = motion[0, k, i] - memory[0, i]
            if differentiated:
                # NaN on a first sample: there is no velocity yet, and so no momentum to start
                # from.
                motion[1, k, i] = difference[i] / h[k]
            memory[0, i], memory[1, i] = motion[0, k, i], motion[1, k, i]
            measured &= math.isfinite(memory[0, i])
            usable &= math.isfinite(memory[1, i])
        if not (measured and usable):
            kept[RUNNING] = 0
            stamps[1, k] = UNUSABLE | forgotten
            continue
        rigid_terms(tree, motion[0, k], motion[1, k], work, driven[0, k], drift, inertia[k])
        stamps[1, k] = (INTERVAL if kept[RUNNING] else START) | forgotten
        for i in range(n):
            integral = 0.0
            for j in range(n):
                integral += (memory[4 + i, j] + inertia[k, i, j]) * difference[j]
                memory[4 + i, j] = inertia[k, i, j]
            driven[1, k, i] = 0.5 * integral
            # A joint whose effort counts from one end only is not lost with the other end's NaN.
            held, w = 0.0, weights[i]
            if w < 1.0:
                held = (1.0 - w) * memory[3, i]
            if w > 0.0:
                held += w * motion[2, k, i]
            driven[2, k, i] = held + 0.5 * (memory[2, i] + drift[i])
            memory[2, i], memory[3, i] = drift[i], motion[2, k, i]
        kept[RUNNING] = 1
    return stamps[1, len(h) - 1]
