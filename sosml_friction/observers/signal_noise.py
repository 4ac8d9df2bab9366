# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Resolution and white noise of a sampled signal, from its differences."""

import math

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled

#: A third difference above this multiple of the 90 % quantile is a gross error. Chosen, no
#: measurement.
_GROSS = 3.0
#: Largest distance from a multiple of a count, in counts, that is one: a difference of two values
#: is as far off as one in their last decimal. Chosen, no measurement.
_OFF_COUNT = 0.125
#: Share of the steps that are multiples of a count; by chance 2 of 8 are. Chosen, no measurement.
_IN_COUNTS = 0.95
#: The smallest step that is seen is the quantile of this: some are no steps of the signal. Chosen,
#: no measurement.
_SMALLEST = 0.01


def difference_noise(difference: FloatArray, order: int) -> FloatArray:
    """
    Return the standard deviation of the white noise whose differences are given, per column.

    Robustly, by the median: that of the differences over sqrt(comb(2 order, order)), which white
    noise passes and motion hardly does.

    :param difference: of ``order``, (N, ...), all finite.
    """
    gain = math.sqrt(math.comb(2 * order, order))
    return np.asarray(1.4826 * np.median(np.abs(difference), axis=0) / gain)


@compiled
def seen_noise(signals: FloatArray) -> FloatArray:
    """
    Return the quantum and the standard deviation of white noise of each column, (2, n).

    The smallest step that is seen, as of :func:`signal_noise`, and :func:`difference_noise` of
    order 2, compiled: on line it is done again and again. The quantum is infinite where there is
    none, the noise NaN where no difference is finite; then there is no quantum either.

    :param signals: (N, n), N > 2.
    """
    count, n = signals.shape
    found = np.empty((2, n))
    for i in range(n):
        moved, bent, low, high = np.empty(count), np.empty(count), np.inf, -np.inf
        moves = bends = 0
        for k in range(count):
            x = signals[k, i]
            if np.isfinite(x):
                low, high = min(low, x), max(high, x)
        for k in range(1, count):
            step = abs(signals[k, i] - signals[k - 1, i])
            # Multiples of a resolution differ by rounding, which is no step.
            if np.isfinite(step) and step > 1e-9 * max(high - low, 1e-300):
                moved[moves] = step
                moves += 1
            bend = signals[k, i] - 2.0 * signals[k - 1, i] + signals[k - 2, i] if k > 1 else np.nan
            if np.isfinite(bend):
                bent[bends] = abs(bend)
                bends += 1
        found[0, i] = np.quantile(moved[:moves], _SMALLEST) if moves and bends else np.inf
        found[1, i] = 1.4826 * np.median(bent[:bends]) / np.sqrt(6.0) if bends else np.nan
    return found


def counts_of(x: FloatArray) -> float:
    """
    Return the count of which all steps of a signal are multiples, in its unit; 0 if there is none.

    Counts that a file has in a few decimals are off by as much: the smallest step is not one of
    them, and many of it are not many counts. So the count is that of least squares, sum(m d) /
    sum(m^2) of steps d and whole numbers m = d / count, first of one and then of up to twice as
    many each time.

    :param x: (N,); samples that are not finite are left out.
    """
    moved = _steps(x)
    if not len(moved):
        return 0.0
    count, most = float(np.quantile(moved, _SMALLEST)), 1.0
    # Less than half of a count is none.
    moved = moved[moved > 0.5 * count]
    near = moved[:0]
    while len(near) < len(moved):
        near = moved[moved < (most + 0.5) * count]
        if not len(near):
            return 0.0
        multiples = np.rint(near / count)
        count = float(near @ multiples / (multiples @ multiples))
        most *= 2.0
    off = np.abs(near / count - np.rint(near / count))
    # Differences of positions are no surer than twelve digits: so any part says the same count.
    return float(f'{count:.12g}') if float(np.mean(off < _OFF_COUNT)) > _IN_COUNTS else 0.0


def signal_noise(x: FloatArray, order: int = 3) -> tuple[float, float]:
    """
    Return the quantum of a signal and the standard deviation of its white noise, in its unit.

    The quantum is that of :func:`counts_of`, else the smallest step that is seen; 0 if there is
    none. The noise is that of the difference of ``order``, :func:`difference_noise`; 0 if there is
    too little of the signal.

    :param x: (N,); samples that are not finite are left out.
    """
    moved = _steps(x)
    difference = np.diff(x, order)
    difference = difference[np.isfinite(difference)]
    return (
        counts_of(x) or (float(np.quantile(moved, _SMALLEST)) if len(moved) else 0.0),
        float(difference_noise(difference, order)) if len(difference) else 0.0,
    )


def _steps(x: FloatArray) -> FloatArray:
    """Return the sizes of the steps of a signal between samples that differ, (K,)."""
    moved = np.abs(np.diff(x))
    moved = moved[np.isfinite(moved)]
    if not len(moved):
        return moved
    # Multiples of a resolution differ by rounding, which is no step.
    return np.asarray(moved[moved > 1e-9 * max(np.ptp(x[np.isfinite(x)]), 1e-300)])


def white_noise(q: FloatArray) -> float:
    """
    Return the standard deviation of the white noise of a signal, rounding included.

    From its third difference, without gross errors. A mean of squares, because the median of a
    rounded position's differences is a multiple of the quantum.
    """
    return white_noise_of(np.diff(q, 3))


def white_noise_of(difference: FloatArray) -> float:
    """Return the same of third differences (K,) of some samples."""
    difference = difference[np.isfinite(difference)]
    if not len(difference):
        return 0.0
    size = np.abs(difference)
    size = size[size <= _GROSS * np.quantile(size, 0.9)]
    # The sum of the squares of 1, 3, 3, 1.
    return float(np.sqrt(np.mean(size**2) / 20.0))
