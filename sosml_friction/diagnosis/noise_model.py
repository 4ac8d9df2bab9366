# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise that is not white, as an autoregression, and the filter that whitens it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz, toeplitz
from scipy.signal import lfilter

FloatArray = NDArray[np.float64]

ORDER = 6


@dataclass(frozen=True)
class NoiseModel:
    """
    Hold e_k = sum_i a_i e_(k-i) + w_k with w white of standard deviation ``sigma``.

    ``whitening`` is (1, -a_1, ... -a_p) / sigma: filtered by it, noise has variance 1.
    """

    coefficients: FloatArray
    sigma: float

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
    residuals: Sequence[FloatArray], smallest: float, pieces: bool = False
) -> NoiseModel:
    """
    Return the autoregression of stretches of noise, by Yule-Walker.

    :param residuals: stretches (N,), each without holes.
    :param pieces: whether they are so short that a lag has notably fewer products than samples:
        then its mean is over those.
    :param smallest: least sigma, for a residual that is numerically nothing.
    """
    lags = np.zeros(ORDER + 1)
    count = np.zeros(ORDER + 1)
    for x in residuals:
        for k in range(ORDER + 1):
            lags[k] += float(x[: len(x) - k] @ x[k:])
            count[k] += max(len(x) - k, 0) if pieces else len(x)
    if count[-1] == 0 or lags[0] <= 0.0:
        return NoiseModel(np.zeros(ORDER), smallest)
    lags /= count
    if pieces:
        # A spectrum is nowhere negative; counted so, it may be.
        lags[0] += max(-float(np.linalg.eigvalsh(toeplitz(lags))[0]), 0.0)
    # A little white noise: the filter's stop band would be amplified without end.
    lags[0] *= 1.0 + 1e-4
    a = solve_toeplitz(lags[:-1], lags[1:])
    sigma = float(np.sqrt(max(lags[0] - a @ lags[1:], 0.0)))
    return NoiseModel(np.asarray(a), max(sigma, smallest))
