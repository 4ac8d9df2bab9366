# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Acceleration without the noise of position in it."""

import math
from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.regression.band import Band

#: Cycles of a cut-off that its low-pass is long, (80 - 7.95) / 4.57 pi by Kaiser's formula: a
#: shorter recording has none of it.
_CYCLES = 5.0


def largest_of(count: int) -> float:
    """Return how many standard deviations off the largest of so many normal deviates is."""
    return math.sqrt(2.0 * math.log(max(count, 2)))


def steady_accelerations(
    a: FloatArray, noise: FloatArray, scale: FloatArray, band: Band, sigmas: Sequence[float]
) -> list[FloatArray]:
    """
    Return accelerations (N, n), each sample low-passed as far as the motion there allows.

    The cut-off is halved while the intervals x +- k sigma of what the low-passes give have a
    point in common, sigma that of the noise each leaves: the rule of intersecting confidence
    intervals (Goldenshluger and Nemirovski, 1997). A jump keeps its edge; where the motion is
    smooth, noise that is faster than it is gone.

    :param a: second derivative of measured positions; ``noise`` times ``scale`` (N, n): a draw of
        the noise in it, and how it grows and falls along the motion, but at turns slower than the
        band.
    :param sigmas: k of each that is returned. 3 loses little of the motion, and
        :func:`largest_of` all samples has no noise: the line that an encoder's steps make at some
        speeds passes three.
    """
    results = [a.copy() for _ in sigmas]
    for i in range(a.shape[1]):
        bounds = np.full((len(sigmas), 2, len(a)), np.inf) * np.array([[-1.0], [1.0]])
        x, own, cutoff = a[:, i], noise[:, i], band.cutoff
        while cutoff * band.step * len(a) > _CYCLES:
            sigma = float(np.std(own)) * scale[:, i]
            common = np.zeros(len(a), dtype=np.bool_)
            for result, (low, high), k in zip(results, bounds, sigmas, strict=True):
                np.maximum(low, x - k * sigma, out=low)
                np.minimum(high, x + k * sigma, out=high)
                alike = low <= high
                result[alike, i] = x[alike]
                common |= alike
            if not common.any():
                break
            narrower = Band(cutoff, band.step)
            x, own = (narrower.smooth(y[:, i], 1.0) for y in (a, noise))
            cutoff /= 2.0
    return results
