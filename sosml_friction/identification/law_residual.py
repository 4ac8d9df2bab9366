# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a law says of a motion, what it leaves of an estimate, and whether that is noise."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.identification.law.law_curve import fitted_law
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.segments import Segment, centred_difference
from sosml_friction.model.parameter import Z_95
from sosml_friction.observers.signal_noise import signal_noise

#: Over what a position difference gives the velocity [s], as in the fit.
WINDOW_S = 0.05
_BINS = 40
#: A mean of fewer samples is not given.
_FEWEST_IN_BIN = 5
#: Longest lag of the autocorrelation [s], and as a share of the longest window; the smaller
#: holds. Chosen, no measurement.
_LONGEST_LAG_S, _LAG_SHARE = 1.0, 0.5


class Residual(NamedTuple):
    """
    Hold what the law of one observer leaves of its estimate.

    ``samples`` (M,) are the samples, inside the windows used, or in motion where there are none;
    ``value`` (M,) [Nm or N] is estimate - law. ``runs`` (M,) numbers the windows.
    """

    samples: IndexArray
    value: FloatArray
    runs: IndexArray

    def windows(self) -> list[IndexArray]:
        """Return the places of each window's samples in ``samples``, in the order of time."""
        ends = np.flatnonzero(np.diff(self.runs)) + 1
        return np.split(np.arange(len(self.samples)), ends)


def law_residual(
    fit: JointFit, estimate: FloatArray, speed: FloatArray, zero_band: float
) -> Residual | None:
    """Return what the law leaves of an observer's estimate, None where there is no law."""
    law = fitted_law(fit.fit)
    if law is None:
        return None
    residual = estimate - law.torque(np.nan_to_num(speed))
    known = np.isfinite(residual) & np.isfinite(speed)
    runs = np.full(len(residual), -1)
    for k, segment in enumerate(fit.segments):
        if not segment.rejected:
            runs[segment.first : segment.last + 1] = k
    if not (known & (runs >= 0)).any():
        moving = np.abs(np.nan_to_num(speed)) > zero_band
        runs = np.where(moving, np.cumsum(np.append(0, np.diff(moving.astype(int)) != 0)), -1)
    index = np.flatnonzero(known & (runs >= 0))
    return Residual(index, residual[index], runs[index])


def level_residual(fit: JointFit) -> tuple[FloatArray, FloatArray] | None:
    """Return velocity and level - law of the windows used, (K,) each; None without a law."""
    law = fitted_law(fit.fit)
    if law is None:
        return None
    used = [k for k, segment in enumerate(fit.segments) if not segment.rejected]
    velocity = np.array([fit.segments[k].velocity for k in used], dtype=float)
    return velocity, fit.levels[used] - law.torque(velocity)


def binned_mean(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the middles of equal bins of x, and the mean of y in each, NaN where it has few."""
    edges = np.linspace(float(x.min()), float(x.max()), _BINS + 1)
    where = np.clip(np.digitize(x, edges) - 1, 0, _BINS - 1)
    count = np.bincount(where, minlength=_BINS)
    total = np.bincount(where, weights=y, minlength=_BINS)
    mean = np.where(count >= _FEWEST_IN_BIN, total / np.maximum(count, 1), np.nan)
    return 0.5 * (edges[1:] + edges[:-1]), mean


def lags_of(residual: Residual, step: float) -> int:
    """Return how many lags of a residual sampled every ``step`` [s] can be told."""
    _, sizes = np.unique(residual.runs, return_counts=True)
    return int(min(_LONGEST_LAG_S / step, _LAG_SHARE * sizes.max())) if step > 0.0 else 0


def autocorrelation(residual: Residual, lags: int) -> tuple[FloatArray, IndexArray]:
    """
    Return the autocorrelation of a residual within its windows, lags 0 to ``lags``, and its pairs.

    At lag k: sum e_i e_(i+k) / sqrt(sum e_i^2 sum e_(i+k)^2), over all pairs within a window. It
    is never above 1, and NaN where there is no pair. The mean is not subtracted: what the law
    leaves on average in a window is structure too.
    """
    product, before, after = (np.zeros(lags + 1) for _ in range(3))
    pairs = np.zeros(lags + 1, dtype=np.int64)
    for window in residual.windows():
        part = residual.value[window]
        count = min(lags + 1, len(part))
        lag = np.arange(count)
        size = 1 << (2 * len(part) - 1).bit_length()
        product[:count] += np.fft.irfft(np.abs(np.fft.rfft(part, size)) ** 2, size)[:count]
        energy = np.append(0.0, np.cumsum(part**2))
        before[:count] += energy[len(part) - lag]
        after[:count] += energy[-1] - energy[lag]
        pairs[:count] += len(part) - lag
    scale = np.sqrt(before * after)
    result = np.full(lags + 1, np.nan)
    result[scale > 0.0] = product[scale > 0.0] / scale[scale > 0.0]
    return result, pairs


def white_band(pairs: IndexArray) -> FloatArray:
    """Return what the autocorrelation of white noise stays below at 95 % of the lags."""
    return np.asarray(Z_95 / np.sqrt(np.maximum(pairs, 1)))


def position_difference(time: FloatArray, q: FloatArray) -> FloatArray:
    """Return the centred difference over :data:`WINDOW_S`; NaN at ends and across holes."""
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
