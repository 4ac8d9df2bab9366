# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One low-pass for both sides of the model, and smooth derivatives of position."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray
from scipy.signal import firwin, kaiserord

from sosml_friction.arrays import ColumnArray, Entry, FloatArray
from sosml_friction.model.finite_differences import convolved

#: Samples kept per cycle of the cut-off: Nyquist's 2, and room for the filter's transition.
_OVERSAMPLING = 10.0 / 3.0
#: Position is low-passed at this multiple of the band before anything non-linear is made of it:
#: the product of two signals of the band reaches twice as far.
_WIDER = 2.0
#: Largest ripple of that low-pass [dB], 1e-4: position passes it and effort does not, and a
#: model's equations may be wrong by the square of its tolerance, 1.2e-3.
_RIPPLE_DB = 80.0
#: Filtered samples of one matrix product. More of them share less of the samples they see, fewer
#: are slower for their calls. A size of time, not of the answer.
_BLOCK = 16


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
        # A band of a tenth of the rate has three samples for one, whatever rounding makes of it.
        return max(1, int(1.0 / (self.step * self.cutoff * _OVERSAMPLING) + 1e-6))

    @property
    def half(self) -> int:
        """Return the samples to each side that a filtered one depends on."""
        return max(1, round(2.0 / (self.cutoff * self.step)))

    @property
    def first(self) -> int:
        """Return the sample to which the first filtered one belongs."""
        return self.half

    @property
    def reach(self) -> int:
        """Return how many rows of the output the low-pass spreads a sample over, to one side."""
        return -(-self.half // self.factor)

    @property
    def output_step(self) -> float:
        """Return the time between filtered samples [s]."""
        return self.factor * self.step

    def count(self, samples: int) -> int:
        """Return the number of filtered samples that ``samples`` give."""
        return max(0, (samples - 2 * self.half - 1) // self.factor + 1)

    def at_rows(self, x: NDArray[Entry]) -> NDArray[Entry]:
        """Return the samples of ``x`` (N, ...) that filtered ones belong to, (count(N), ...)."""
        return x[self.first :: self.factor][: self.count(len(x))]

    def apply(self, x: ColumnArray) -> ColumnArray:
        """Return ``x`` (N, ...) filtered and decimated, (count(N), ...), in its precision."""
        kind: type = np.float32 if x.dtype == np.float32 else np.float64
        x = np.ascontiguousarray(x, dtype=kind)
        count, shape = self.count(len(x)), x.shape[1:]
        flat = x.reshape(len(x), math.prod(shape))
        result: ColumnArray = np.empty((count, flat.shape[1]), kind)
        # A block of outputs is one matrix times the samples that the block sees.
        whole = count // _BLOCK
        matrix: ColumnArray = _decimator(self, _BLOCK).astype(kind, copy=False)
        row = flat.strides[0]
        seen = as_strided(
            flat,
            (whole, matrix.shape[1], flat.shape[1]),
            (_BLOCK * self.factor * row, row, flat.strides[1]),
            writeable=False,
        )
        np.matmul(matrix, seen, out=result[: whole * _BLOCK].reshape(whole, _BLOCK, flat.shape[1]))
        left = count - whole * _BLOCK
        if left:
            matrix = _decimator(self, left).astype(kind, copy=False)
            first = whole * _BLOCK * self.factor
            np.matmul(matrix, flat[first : first + matrix.shape[1]], out=result[-left:])
        return result.reshape(count, *shape)

    def seen(self, rows: slice) -> slice:
        """Return the samples that filtered ones see."""
        first = rows.start * self.factor
        return slice(first, (rows.stop - 1) * self.factor + 2 * self.half + 1)

    def smooth(self, x: FloatArray, wider: float = _WIDER) -> FloatArray:
        """
        Return ``x`` (N, ...) low-passed at ``wider`` times the cut-off, (N, ...).

        By a Kaiser window, flat up to half of that and stopping from one and a half times it on.
        """
        cutoff = wider * self.cutoff
        if cutoff * self.step >= 0.4:
            return np.array(x)
        return convolved(x, _smoother(cutoff, self.step))


@lru_cache(maxsize=64)
def _smoother(cutoff: float, step: float) -> FloatArray:
    """Return the weights of the low-pass of position, an odd number."""
    count, beta = kaiserord(_RIPPLE_DB, 2.0 * cutoff * step)
    return np.asarray(firwin(count | 1, cutoff, window=('kaiser', beta), fs=1.0 / step))


@lru_cache(maxsize=64)
def _decimator(band: Band, outputs: int) -> FloatArray:
    """Return the matrix (outputs, samples) of the filter for consecutive outputs."""
    taps = firwin(2 * band.half + 1, band.cutoff, fs=1.0 / band.step)
    matrix = np.zeros((outputs, (outputs - 1) * band.factor + len(taps)))
    for k in range(outputs):
        matrix[k, k * band.factor : k * band.factor + len(taps)] = taps
    return matrix
