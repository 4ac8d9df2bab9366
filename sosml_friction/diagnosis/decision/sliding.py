# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where joints slide: what is beside reversals says little of a cause."""

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.regression.chance import NEGLIGIBLE
from sosml_friction.regression.estimate import far_from_reversals
from sosml_friction.regression.evidence import Fit, System
from sosml_friction.regression.kernels import runs
from sosml_friction.regression.noise_model import ORDER
from sosml_friction.regression.rests import still, turning
from sosml_friction.regression.whitened import WhitenedRegression


def sliding(laboratory: WhitenedRegression) -> BoolArray:
    """
    Return the whitened rows (rows, n) in which a joint neither turns around nor sticks as it does.

    A joint may stick for long before and after its velocity changes sign: all of such a run is
    beside the reversal. A motion that is as slow and keeps its direction is a motion.
    """
    parts = []
    for signals in laboratory.signals:
        band, scales = signals.band, signals.scales
        stuck = still(signals.q, band, scales.sign_limit, scales.speed)
        parts.append(band.at_rows(stuck)[ORDER:])
    result = far_from_reversals(laboratory, laboratory.system.Z)
    for own, stuck in zip(result.T, np.concatenate(parts).T, strict=True):
        for begin, end in runs(np.ascontiguousarray(stuck)):
            own[begin:end] &= own[begin:end].all()
    return result


def clear_of_turns(laboratory: WhitenedRegression) -> BoolArray:
    """
    Return the whitened rows (rows, n) that see nothing of where a joint turns around.

    Not as much as the tails of the low-pass: motion that repeats turns around at the same places,
    and what is fast over position acts there alone.
    """
    parts = []
    for s, left in zip(laboratory.signals, laboratory.rows.residual, strict=True):
        clear = np.ones((len(left), s.robot.n), dtype=np.bool_)
        for i, limit in enumerate(s.scales.sign_limit.tolist()):
            q = np.ascontiguousarray(s.q[:, i])
            # One that rings as it creeps on does not turn around.
            most = max(limit, NEGLIGIBLE * float(s.scales.span[i]))
            for begin, end in turning(q, limit):
                before = _side(q[:begin][::-1], q[begin], most)
                after = _side(q[end:], q[begin], most)
                if before * after <= 0:
                    continue
                first = max(0, -((2 * s.band.half - begin) // s.band.factor))
                clear[first : (end - 1) // s.band.factor + 1, i] = False
        parts.append(clear[ORDER:])
    return np.concatenate(parts)


def _side(q: FloatArray, place: float, most: float) -> int:
    """Return to which side of a place a joint first goes further than ``most``; 0: to none."""
    reach = 64
    while reach < 2 * len(q):
        away = np.flatnonzero(np.abs(q[:reach] - place) > most)
        if len(away):
            return 1 if q[away[0]] > place else -1
        reach *= 4
    return 0


def fit_within(system: System, y: FloatArray, rows: BoolArray) -> Fit:
    """
    Return the fit of whitened rows ``y`` (rows, n) that some of them (rows, n) alone would have.

    The others may have pushed parameters of the nominal to a bound.
    """
    own = System.make(rows[:, :, None] * system.Z, system.bound, system.prior, system.blocks)
    return Fit.make(own, rows * y)
