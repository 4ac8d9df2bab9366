# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that wrap, as they come."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.sampling import HOLE
from sosml_friction.bags.wrap import (
    BESIDE,
    HALF,
    LEAST,
    SAME,
    named_period,
    near_turn,
    seen_period,
)
from sosml_friction.compiled import compiled


class RunningUnwrap:
    """
    Make positions continuous as they come; of a recording :func:`unwrapped` does it.

    The first wrap is told by two things: the steps before it, as many as a recording has on both
    sides of a wrap, and a period that is a turn or a round number of at least 1 rad or m. Later
    wraps are told by that period.

    :param n: number of positions in a sample.
    :param periods: what is known of each (n,), NaN for nothing.
    """

    def __init__(self, n: int, periods: FloatArray | None = None) -> None:
        self.periods = np.full(n, np.nan) if periods is None else periods
        self._turned = np.zeros(n)
        self._time: deque[int] = deque(maxlen=2 * BESIDE + 1)
        self._raw: deque[FloatArray] = deque(maxlen=2 * BESIDE + 1)
        # Compile now: at the first sample it would stall the node.
        self._range = np.zeros(n), np.zeros(n)
        _goes_on(self._turned, self._turned, self.periods, *self._range)
        self._range = np.full(n, np.inf), np.full(n, -np.inf)

    def __call__(self, t_ns: int, q: FloatArray) -> FloatArray:
        """Return the positions (n,) of the next sample, continuous; NaN stays NaN."""
        if self._time and t_ns <= self._time[-1]:
            self._time.clear()
            self._raw.clear()
        known = np.array(q, dtype=float)
        last = self._raw[-1] if self._raw else known
        if not _goes_on(known, last, self.periods, *self._range):
            self._take(t_ns, known, last)
        self._time.append(t_ns)
        self._raw.append(known)
        return np.asarray(q + self._turned)

    def _take(self, t_ns: int, known: FloatArray, last: FloatArray) -> None:
        """Take a position that is not known everywhere, that leaps, or of a known period."""
        low, high = self._range
        for i, now in enumerate(known.tolist()):
            if not math.isfinite(now):
                known[i] = now = last[i]
            low[i] = now if now < low[i] else low[i]
            high[i] = now if now > high[i] else high[i]
            if abs(now - last[i]) > HALF * (high[i] - low[i]):
                self._look(i, t_ns, now)
        wraps = np.isfinite(self.periods)
        if wraps.any():
            back = near_turn(known, last, np.where(wraps, self.periods, 1.0)) - known
            self._turned += np.where(wraps & np.isfinite(back), back, 0.0)

    def _look(self, i: int, t_ns: int, position: float) -> None:
        """Take the period that the step to a position shows, if it shows one."""
        if len(self._time) <= 2 * BESIDE or np.isfinite(self.periods[i]):
            return
        before = np.diff(np.array(self._time)) * 1e-9
        dt = (t_ns - self._time[-1]) * 1e-9
        if dt > HOLE * float(np.median(before)):
            return
        raw = np.array([sample[i] for sample in self._raw])
        seen = seen_period(position - raw[-1], dt, np.diff(raw) / before)
        if seen is None or self._range[1][i] - self._range[0][i] > (1.0 + SAME) * seen[0]:
            return
        period, error = seen
        if error <= SAME * period and period >= LEAST:
            name = named_period(period, max(error, 1e-4 * period))
            self.periods[i] = np.nan if name is None else name


@compiled
def _goes_on(
    position: FloatArray, last: FloatArray, periods: FloatArray, low: FloatArray, high: FloatArray
) -> bool:
    """
    Remember a sample in which nothing wraps or could, as nearly all are; tell if it is one.

    Nothing is changed if it is not.

    :param low: the least of each position until now (n,); written, as is ``high``.
    """
    for i in range(len(position)):
        now = position[i]
        if not math.isfinite(now) or math.isfinite(periods[i]):
            return False
        if abs(now - last[i]) > HALF * (max(now, high[i]) - min(now, low[i])):
            return False
    for i in range(len(position)):
        low[i], high[i] = min(position[i], low[i]), max(position[i], high[i])
    return True
