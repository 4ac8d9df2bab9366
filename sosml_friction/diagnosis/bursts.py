# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Short stretches that nothing explains: somebody, or something, touched the robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

FloatArray = NDArray[np.float64]

_WINDOW_S = 0.24
#: A mean over a window that is so many robust standard deviations off belongs to a burst, if the
#: largest of its neighbours reaches the second number.
_OVER, _CLEAR = 7.0, 14.0
#: More of the time than this, or more bursts, is no touch, but a model that is wrong throughout.
_MOST, _MANY = 0.15, 12


@dataclass(frozen=True)
class Episode:
    """Hold one burst: ``joint``, from ``start_s`` to ``end_s``, ``energy`` in noise variances."""

    joint: int
    start_s: float
    end_s: float
    energy: float


@dataclass(frozen=True)
class Bursts:
    """Hold bursts and the whitened rows (rows, n) they spoil."""

    episodes: tuple[Episode, ...]
    mask: NDArray[np.bool_]


def find_bursts(residual: FloatArray, times: FloatArray, step: float) -> Bursts:
    """
    Return the stretches in which a residual is pushed to one side far beyond its usual size.

    By its mean over 0.24 s, against the median size of such means: a push has a mean, where a
    resonance swings to both sides.

    :param residual: what the whole library leaves (rows, n) [Nm or N].
    :param times: of the rows (rows,) [s].
    :param step: time between rows [s].
    """
    rows, n = residual.shape
    m = max(2, round(_WINDOW_S / step))
    mask = np.zeros((rows, n), dtype=bool)
    episodes: list[Episode] = []
    if rows < 20 * m:
        return Bursts((), mask)
    for i in range(n):
        mean = np.convolve(residual[:, i], np.full(m, 1.0 / m), mode='same')
        usual = max(1.4826 * float(np.median(np.abs(mean))), 1e-300)
        relative = np.abs(mean) / usual
        over = maximum_filter1d((relative > _OVER).astype(np.int8), m) > 0
        edges = np.flatnonzero(np.diff(np.concatenate([[False], over, [False]])))
        kept = [
            (int(a), int(b))
            for a, b in zip(edges[::2], edges[1::2], strict=True)
            if relative[a:b].max() > _CLEAR
        ]
        if not kept or len(kept) > _MANY or sum(b - a for a, b in kept) > _MOST * rows:
            continue
        size = max(1.4826 * float(np.median(np.abs(residual[:, i]))), 1e-300)
        for a, b in kept:
            mask[a:b, i] = True
            total = float((residual[a:b, i] ** 2).sum()) / size**2
            episodes.append(Episode(i, float(times[a]), float(times[b - 1]), total))
    return Bursts(tuple(episodes), mask)
