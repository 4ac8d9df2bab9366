# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Knots of free curves, and their hat functions side by side."""

from collections.abc import Callable, Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.regression.chance import SIGMAS
from sosml_friction.regression.kernels import hats
from sosml_friction.regression.signals import Signals

#: Least distance of two things on an axis, in standard deviations of the noise there, to be told
#: from each other: there their bounds meet.
APART = 2.0 * SIGMAS


def knots_of(
    stretches: Sequence[Signals],
    signal: Callable[[Signals], FloatArray],
    count: int,
    noise: FloatArray | None = None,
) -> list[FloatArray]:
    """
    Return the knots of each joint, quantiles of its signal (N, n) over all stretches.

    A curve is one over all of them: knots of each stretch would make it another in each. It does
    not bend within the noise of its axis: where a loop feeds the noise of position back, effort
    follows that, and not the motion.

    :param noise: standard deviation of what is no motion in the signal (n,); None for nothing.
    """
    x = np.concatenate([signal(s) for s in stretches])
    # Fewer than ``count`` where quantiles are equal.
    knots = [np.unique(np.quantile(own, np.linspace(0.01, 0.99, count))) for own in x.T]
    least = np.zeros(len(knots)) if noise is None else APART * noise
    return [_apart(own, distance) for own, distance in zip(knots, least, strict=True)]


def _apart(knots: FloatArray, least: float) -> FloatArray:
    """Return the first and the last knot, and those between that are ``least`` from others."""
    kept = knots[:1].tolist()
    for knot in knots[1:].tolist():
        if knot - kept[-1] >= least:
            kept.append(knot)
    # The last stands for what is too near to it.
    return np.array([*kept[: max(len(kept) - 1, 1)], *knots[1:][-1:]])


def padded_hats(
    x: FloatArray, knots: FloatArray, count: int, factors: Sequence[FloatArray | float] = (1.0,)
) -> FloatArray:
    """Return hats of x (N,) times each factor (N,), (N, factors count), 0 for missing knots."""
    hat = hats(x, knots)
    result = np.zeros((len(x), len(factors), count))
    for k, factor in enumerate(factors):
        result[:, k, : len(knots)] = hat * np.reshape(factor, (-1, 1))
    return result.reshape(len(x), -1)
