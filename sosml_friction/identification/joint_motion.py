# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How a joint moved in a recording, and what a law says of that motion."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.law_curve import fitted_law
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.segments import Segment, centred_difference
from sosml_friction.observers.signal_noise import signal_noise

#: Over what a position difference gives the velocity [s], as in the fit.
WINDOW_S = 0.05


def position_difference(time: FloatArray, q: FloatArray) -> FloatArray:
    """Return the centred difference over :data:`WINDOW_S`, (N,); NaN at ends and across holes."""
    step = float(np.median(np.diff(time))) if len(q) > 1 else 0.0
    half = max(1, round(0.5 * WINDOW_S / step)) if step > 0.0 else len(q)
    return centred_difference(time, q, half)


def standstill(q: FloatArray, zero_band: float) -> float:
    """Return the speed that is not told from standstill: the zero band, or two counts' worth."""
    return max(zero_band, 2.0 * signal_noise(q)[0] / WINDOW_S)


def law_in_motion(
    fit: LawFit, q: FloatArray, speed: FloatArray, zero_band: float
) -> FloatArray | None:
    """
    Return what the law says at each sample, (N,) [Nm or N]; None where there is no law.

    NaN at rest, where friction is what holds the joint, and where the joint is slower than all
    data that the law was fitted to.
    """
    law = fitted_law(fit)
    if law is None:
        return None
    slowest = max(standstill(q, zero_band), 0.5 * np.nan_to_num(fit.slowest))
    return np.where(np.abs(np.nan_to_num(speed)) > slowest, law.torque(speed), np.nan)


def level_spreads(segments: Sequence[Segment], tau_f: FloatArray) -> FloatArray:
    """Return the standard deviation of an estimate within each window, (K,) [Nm or N]."""
    spreads = np.full(len(segments), np.nan)
    for k, segment in enumerate(segments):
        inside = tau_f[segment.first : segment.last + 1]
        known = inside[np.isfinite(inside)]
        if len(known) > 1:
            spreads[k] = np.std(known)
    return spreads
