# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Resolution and white noise of a sampled signal, from its differences."""

import numpy as np
from scipy.special import comb

from sosml_friction.arrays import FloatArray


def difference_noise(difference: FloatArray, order: int) -> FloatArray:
    """
    Return the standard deviation of the white noise whose differences are given, per column.

    Robustly, by the median: that of the differences over sqrt(comb(2 order, order)), which white
    noise passes and motion hardly does.

    :param difference: of ``order``, (N, ...), all finite.
    """
    gain = np.sqrt(float(comb(2 * order, order, exact=True)))
    return np.asarray(1.4826 * np.median(np.abs(difference), axis=0) / gain)


def signal_noise(x: FloatArray, order: int = 3) -> tuple[float, float]:
    """
    Return the quantum of a signal and the standard deviation of its white noise, in its unit.

    The quantum is the smallest step that is seen; 0 if there is none. The noise is that of the
    difference of ``order``, :func:`difference_noise`; 0 if there is too little of the signal.

    :param x: (N,); samples that are not finite are left out.
    """
    moved = np.abs(np.diff(x))
    moved = moved[np.isfinite(moved)]
    # Multiples of a resolution differ by rounding, which is no step.
    moved = moved[moved > 1e-9 * max(np.ptp(x[np.isfinite(x)]), 1e-300)] if len(moved) else moved
    difference = np.diff(x, order)
    difference = difference[np.isfinite(difference)]
    return (
        float(np.quantile(moved, 0.01)) if len(moved) else 0.0,
        float(difference_noise(difference, order)) if len(difference) else 0.0,
    )
