# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A position that begins anew at the end of its range: recognise the period, and unwrap."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import FloatArray

#: A turn in rad, deg and turns, and the ranges of counters; the usual encoder is one of them.
_TURNS = (2.0 * math.pi, math.pi, 360.0, 180.0, 1.0, *(2.0**k for k in range(8, 33)))
#: Samples that a stay between two jumps needs: fewer are a glitch or a flicker at the end.
_STAY = 3


def recognise_wrap(position: NDArray[np.generic]) -> float | None:
    """
    Return the period at which a position (N,) jumps back, None if it does not.

    A wrap shows itself by jumps that are all of one and the same size, which is the whole range of
    the values, against the motion beside them, and that leave no trace once they are undone: every
    step is then less than a quarter of the period. The period is the mean
    jump, with the motion through it taken from the steps beside, or the round number (a turn,
    a power of two, three digits) that it cannot be told from.
    """
    values = np.asarray(position, dtype=np.float64)
    values = values[np.isfinite(values)]
    if len(values) < 2 * _STAY:
        return None
    steps = np.diff(values)
    span = float(np.ptp(values))
    jumps = np.flatnonzero(np.abs(steps) > 0.5 * span)
    stays = np.diff([-1, *jumps, len(steps)])
    if not len(jumps) or span == 0.0 or stays.max(initial=0) < _STAY:
        return None
    if not ((stays[:-1] >= _STAY) & (stays[1:] >= _STAY)).any():
        return None
    ordinary = np.delete(steps, jumps)
    # What the joint moved during a jump, from the steps on both sides of it.
    through, doubt = np.zeros(len(jumps)), np.zeros(len(jumps))
    for k, jump in enumerate(jumps):
        beside = [i for i in (jump - 1, jump + 1) if 0 <= i < len(steps) and i not in jumps]
        if beside:
            through[k] = np.mean(steps[beside])
            doubt[k] = 0.5 * np.ptp(steps[beside]) if len(beside) == 2 else abs(through[k])
    # It goes on the way it went: pulses and values that come and go do not.
    if np.mean(np.sign(through) == -np.sign(steps[jumps])) <= 0.5:
        return None
    sizes = np.sign(steps[jumps]) * (steps[jumps] - through)
    period = float(np.mean(sizes))
    largest = float(np.abs(ordinary).max(initial=0.0))
    # The values beside a jump are its two ends, up to a step or two.
    if (
        np.abs(sizes - period).max() > 2.0 * largest
        or span > period + largest
        or max(largest, np.abs(steps[jumps] - np.sign(steps[jumps]) * period).max()) > period / 4
    ):
        return None
    scatter = float(np.std(sizes)) / math.sqrt(len(sizes))
    within = max(2.0 * scatter, float(np.mean(doubt)), 1e-9 * period)
    for known in (*_TURNS, float(f'{period:.2g}'), float(f'{period:.3g}')):
        if abs(known - period) <= within and known >= span:
            return known
    return max(period, span)


def unwrap(position: FloatArray, period: float) -> FloatArray:
    """Return a position (N,) with every jump of more than half a period undone; NaN stays."""
    unwrapped = position.copy()
    known = np.isfinite(position)
    unwrapped[known] = np.unwrap(position[known], period=period)
    return unwrapped
