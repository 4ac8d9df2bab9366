# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How much noise there is where a slow curve is."""

import numpy as np
from scipy.fft import next_fast_len, rfft

from sosml_friction.arrays import FloatArray


def noise_where(hats: FloatArray, left: FloatArray) -> float:
    """
    Return the power of noise where a curve is, in that of all noise, at least 1.

    The periodogram of what is left (rows,), in the mean over those of the hats (rows, h): a model
    of few coefficients does not whiten what is slower than these reach, and slow noise, as curves
    are slow, has more of its energy in them than white noise would.
    """
    length = next_fast_len(len(left), real=True)
    # One after the other: the spectra of all are as large as the recording.
    own = sum(np.abs(rfft(hat, length)) ** 2 for hat in hats.T)
    power = np.abs(rfft(left, length)) ** 2
    if not own.any() or not power.any():
        return 1.0
    return max(1.0, float(own @ power / own.sum() / power.mean()))
