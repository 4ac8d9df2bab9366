# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise that is not white, as an autoregression, and the filter that whitens it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from sosml_friction.arrays import FloatArray

#: Order of the autoregression. Halved and doubled, of nine answers of ``python -m
#: validation.sensitivity --seed 1`` two change, and stay right: causes come in another order, and
#: one has a second beside it or not.
ORDER = 7
#: White noise added, as a share of the mean square. Without it the order is spent on the edge of
#: the low-pass, and flat noise seems to have 1.4 times its power where it is slow and 0.73 beside
#: it; with it, 0.9 to 1.09 in all of the band (``python -m validation.flat_noise``).
_WHITE = 1e-2


@dataclass(frozen=True)
class NoiseModel:
    """
    Hold e_k = sum_i a_i e_(k-i) + w_k with w white of standard deviation ``sigma``.

    ``whitening`` is (1, -a_1, ... -a_p) / sigma: filtered by it, noise has power 1 in the band,
    and variance ``power``: less, as the band is a part of what its rows could have.
    """

    coefficients: FloatArray
    sigma: float
    power: float = 1.0

    @property
    def whitening(self) -> FloatArray:
        """Return the coefficients of the whitening filter."""
        return np.concatenate([[1.0], -self.coefficients]) / self.sigma

    def whiten(self, x: FloatArray) -> FloatArray:
        """Return ``x`` (N, ...) whitened, (N - ORDER, ...)."""
        return np.asarray(lfilter(self.whitening, [1.0], x, axis=0)[ORDER:])

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return ``count`` samples of such noise."""
        start = 50 * ORDER
        w = self.sigma * rng.standard_normal(count + start)
        return np.asarray(lfilter([1.0], np.concatenate([[1.0], -self.coefficients]), w)[start:])


def fit_noise(
    residuals: Sequence[FloatArray], smallest: float, added: float = _WHITE
) -> NoiseModel:
    """
    Return the autoregression of pieces of noise, by Burg's method.

    Each reflection coefficient makes the mean square of what is predicted forwards and backwards
    least, over the rows of all pieces with ORDER neighbours: nothing is assumed beyond the ends of
    a piece, and the filter is stable for pieces of any length. White noise is added in
    expectation: without it the filter would amplify the stop band of the low-pass without limit.

    :param residuals: pieces (N,), each without holes.
    :param smallest: least sigma, for a residual that is numerically nothing.
    :param added: the white noise, as a share of the mean square.
    """
    rows = sum(len(x) for x in residuals)
    variance = sum(float(x @ x) for x in residuals) / max(rows, 1)
    white = added * variance
    forward, backward = list(residuals), list(residuals)
    error = np.ones(1)
    for _ in range(ORDER):
        forward, backward = [f[1:] for f in forward], [b[:-1] for b in backward]
        rows = sum(len(f) for f in forward)
        both = sum(float(f @ f + b @ b) for f, b in zip(forward, backward, strict=True))
        power = 0.5 * both + rows * white * float(error @ error)
        if power <= 0.0:
            # Nothing is left to predict, or no row is left.
            break
        across = sum(float(f @ b) for f, b in zip(forward, backward, strict=True))
        k = (across + rows * white * float(error[1:] @ error[:0:-1])) / power
        pairs = list(zip(forward, backward, strict=True))
        forward, backward = [f - k * b for f, b in pairs], [b - k * f for f, b in pairs]
        longer = np.append(error, 0.0)
        error = longer - k * longer[::-1]
        variance = power * (1.0 - k * k) / rows
    coefficients = np.zeros(ORDER)
    coefficients[: len(error) - 1] = -error[1:]
    sigma = max(float(np.sqrt(variance)), smallest)
    inside = variance - white * float(error @ error)
    return NoiseModel(coefficients, sigma, inside / sigma**2 if sigma > 0.0 else 1.0)
