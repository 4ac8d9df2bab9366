# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Derivatives of even samples, and convolution that goes on beyond the ends."""

import numpy as np
from scipy.ndimage import convolve1d
from scipy.signal import oaconvolve

from sosml_friction.arrays import FloatArray

#: From this many weights on, products of spectra are faster than sums: 2 times and more
#: at 121, 12 and more at 801 (benchmarks/convolution.py).
_LONG = 100


def first_derivative(x: FloatArray, step: float) -> FloatArray:
    """Return dx/dt by the five-point rule, its error of order step^4, (N, ...)."""
    return convolved(x, np.array([-1.0, 8.0, 0.0, -8.0, 1.0]) / (12.0 * step))


def second_derivative(x: FloatArray, step: float) -> FloatArray:
    """Return d2x/dt2 by the five-point rule, its error of order step^4, (N, ...)."""
    return convolved(x, np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / (12.0 * step**2))


def convolved(x: FloatArray, weights: FloatArray) -> FloatArray:
    """
    Return ``x`` (N, ...) convolved with an odd number of weights, (N, ...).

    Beyond an end, x is continued by its point reflection there, which keeps the slope. Held
    constant, it would seem to stop.
    """
    pad = min(len(weights) // 2, len(x) - 1)
    ends = [(pad, pad)] + [(0, 0)] * (x.ndim - 1)
    longer = np.pad(x, ends, mode='reflect', reflect_type='odd')
    # Where the weights reach beyond what is reflected, the last value is repeated; a product of
    # spectra would have zeros there.
    if len(weights) < _LONG or pad < len(weights) // 2:
        result = convolve1d(longer, weights, axis=0, mode='nearest')
    else:
        column = weights.reshape(-1, *(1,) * (x.ndim - 1))
        result = oaconvolve(longer, column, mode='same', axes=0)
    return np.asarray(result[pad : pad + len(x)])
