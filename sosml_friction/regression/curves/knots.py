# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Knots of free curves, and their hat functions side by side."""

from collections.abc import Callable, Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.regression.kernels import hats, quantile_knots
from sosml_friction.regression.signals import Signals


def knots_of(
    stretches: Sequence[Signals], signal: Callable[[Signals], FloatArray], count: int
) -> list[FloatArray]:
    """
    Return the knots of each joint, quantiles of its signal (N, n) over all stretches.

    A curve is one over all of them: knots of each stretch would make it another in each.
    """
    x = np.concatenate([signal(s) for s in stretches])
    return [quantile_knots(x[:, i], count) for i in range(x.shape[1])]


def padded_hats(
    x: FloatArray, knots: FloatArray, count: int, factors: Sequence[FloatArray | float] = (1.0,)
) -> FloatArray:
    """
    Return hat functions of x (N,) times each factor (N,), (N, factors count).

    Zeros stand for knots that are less than ``count``.
    """
    hat = hats(np.ascontiguousarray(x), knots)
    result = np.zeros((len(x), len(factors), count))
    for k, factor in enumerate(factors):
        result[:, k, : len(knots)] = hat * np.reshape(factor, (-1, 1))
    return result.reshape(len(x), -1)
