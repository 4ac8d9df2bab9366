# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One low-pass for both sides of the model, and smooth derivatives of position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d
from scipy.signal import firwin, upfirdn

FloatArray = NDArray[np.float64]

#: Samples kept per cycle of the band's edge.
_OVERSAMPLING = 10.0 / 3.0
#: Position is smoothed at so many times the band before anything non-linear is made of it.
_WIDER = 2.0


@dataclass(frozen=True)
class Band:
    """
    Filter at ``cutoff`` [Hz] and keep one of ``factor`` samples of step ``step`` [s].

    The filter is a linear-phase FIR (Hamming window, -6 dB at the cut-off) without its delay: row
    k of the result belongs to sample ``first + k factor`` of the input.
    """

    cutoff: float
    step: float

    @property
    def factor(self) -> int:
        """Return how many samples make one."""
        return max(1, int(1.0 / (self.step * self.cutoff * _OVERSAMPLING)))

    @property
    def half(self) -> int:
        """Return the samples to each side that a filtered one depends on."""
        return max(1, round(2.0 / (self.cutoff * self.step)))

    @property
    def first(self) -> int:
        """Return the sample to which the first filtered one belongs."""
        return self.half

    @property
    def output_step(self) -> float:
        """Return the time between filtered samples [s]."""
        return self.factor * self.step

    def count(self, samples: int) -> int:
        """Return how many filtered samples so many samples make."""
        return max(0, (samples - 2 * self.half - 1) // self.factor + 1)

    def apply(self, x: FloatArray) -> FloatArray:
        """Return ``x`` (N, ...) filtered and decimated, (count(N), ...)."""
        taps = self._taps(self.cutoff, self.half)
        full = upfirdn(taps, x[: len(x)], up=1, down=1, axis=0) if self.factor == 1 else None
        if full is not None:
            return np.asarray(full[2 * self.half : len(x)])
        # The first whole window ends at sample 2 half: shift it onto the grid of the decimation.
        lead = -(2 * self.half) % self.factor
        padded = np.concatenate([np.zeros((lead, *x.shape[1:])), x])
        result = upfirdn(taps, padded, up=1, down=self.factor, axis=0)
        begin = (2 * self.half + lead) // self.factor
        return np.asarray(result[begin : begin + self.count(len(x))])

    def smooth(self, x: FloatArray, wider: float = _WIDER) -> FloatArray:
        """Return ``x`` (N, ...) low-passed at ``wider`` times the cut-off, ends held, (N, ...)."""
        cutoff = wider * self.cutoff
        if cutoff * self.step >= 0.4:
            return np.array(x)
        half = max(1, round(2.0 / (cutoff * self.step)))
        return np.asarray(convolve1d(x, self._taps(cutoff, half), axis=0, mode='nearest'))

    def _taps(self, cutoff: float, half: int) -> FloatArray:
        return np.asarray(firwin(2 * half + 1, cutoff, fs=1.0 / self.step))


def first_derivative(x: FloatArray, step: float) -> FloatArray:
    """Return dx/dt by the five-point rule, its error of order step^4, (N, ...)."""
    return np.asarray(
        convolve1d(
            x, np.array([-1.0, 8.0, 0.0, -8.0, 1.0]) / (12.0 * step), axis=0, mode='nearest'
        )
    )


def second_derivative(x: FloatArray, step: float) -> FloatArray:
    """Return d2x/dt2 by the five-point rule, its error of order step^4, (N, ...)."""
    weights = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / (12.0 * step**2)
    return np.asarray(convolve1d(x, weights, axis=0, mode='nearest'))
