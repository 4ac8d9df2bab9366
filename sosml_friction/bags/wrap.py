# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that wrap: an encoder's register that begins anew at the end of its range."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sosml_friction.arrays import FloatArray

if TYPE_CHECKING:
    from sosml_friction.bags.joint_log import JointLog

#: A register wraps by its whole range: a step of less than half of it is told from none by nobody.
_HALF = 0.5
#: Wraps are of one period; the motion within a step is known by its neighbours, to this share.
_SAME = 0.02
#: Steps before and after a wrap that must go the same way: one sample beside the others is none.
_BESIDE = 2
#: A period that is a turn, or a round number of rad, deg or m, within its error is that one.
_TURNS = (2.0 * np.pi, 4.0 * np.pi, np.pi, 360.0, 180.0)
_DIGITS = (1, 2)
#: Fewest wraps by another period: one or two may be recordings that were joined.
_FEWEST = 3
#: A longer step than this [median steps] is a hole, and no wrap.
_HOLE = 5.0
#: Share of a period that steps of motion are within, but for one of a hundred, which may be a bad
#: sample, and fewest such steps: normal noise jumps by four times the largest of twenty steps in
#: two samples of 10^7 (integral of its distribution).
_FOLLOWED, _WITHIN, _STEPS = 0.25, 0.99, 20
#: Least period [rad or m] that is told on line, by one wrap: noise and its steps are smaller.
_LEAST = 1.0


def wrap_period(time: FloatArray, position: FloatArray) -> float | None:
    """
    Return the period by which a position wraps [its unit], None if it does not.

    A wrap is a step of a whole range of motion against the motion before and after it, and all of
    them are one period, which no two positions are further apart than. The steps of motion are
    small beside it: those of a standing encoder's noise are not.

    :param time: stamps (N,) [s]; ``position`` (N,), NaN where it is not known.
    """
    known = np.isfinite(position)
    t, q = time[known], position[known]
    with np.errstate(all='ignore'):
        return _period(t, q)


def _period(t: FloatArray, q: FloatArray) -> float | None:
    """Return the period by which a known position (N,) wraps, None if it does not."""
    forwards = np.append(True, np.diff(t) > 0.0) if len(t) else np.zeros(0, dtype=bool)
    t, q = t[forwards], q[forwards]
    if len(q) < 2 * _BESIDE + 2:
        return None
    span = float(np.ptp(q))
    steps = np.diff(q)
    jumps = np.flatnonzero(np.abs(steps) > _HALF * span)
    if not len(jumps) or span == 0.0:
        return None
    dt = np.diff(t)
    speed = steps / dt
    sizes, errors = [], []
    whole_steps = dt <= _HOLE * float(np.median(dt))
    followed = whole_steps & (steps != 0.0)
    followed[jumps] = False
    for k in jumps[whole_steps[jumps]]:
        near = np.r_[max(0, k - _BESIDE) : k, k + 1 : min(k + 1 + _BESIDE, len(steps))]
        seen = _seen(float(steps[k]), float(dt[k]), speed[near])
        if len(near) == 2 * _BESIDE and seen is not None and not np.isin(near, jumps).any():
            sizes.append(seen[0])
            errors.append(seen[1])
    if not sizes:
        return None
    period = float(np.median(sizes))
    off = np.abs(np.array(sizes) - period)
    error = float(np.median(errors)) / np.sqrt(len(sizes))
    alike = (off <= _SAME * period + np.array(errors)).all() and error <= _SAME * period
    whole = (np.abs(np.abs(steps[jumps]) - period) <= _HALF * period).all()
    if not (alike and whole and span <= (1.0 + _SAME) * period):
        return None
    name = _named(period, max(error, 1e-4 * period))
    several = len(sizes) >= _FEWEST
    small = np.abs(steps[followed]) < _FOLLOWED * period
    # Noise does not jump by a turn several times: then a wheel may be as fast as it is.
    if small.sum() < max(_STEPS, _WITHIN * len(small)) and not (several and name in _TURNS):
        return None
    return name if name is not None or not several else period


def _seen(step: float, dt: float, beside: FloatArray) -> tuple[float, float] | None:
    """Return the period that a step shows, by the speeds beside it, and its error, or None."""
    # At the edge of the range noise alone goes to and fro: such a step says nothing more.
    if not (np.sign(beside) == -np.sign(step)).all():
        return None
    return abs(step) + abs(float(np.mean(beside))) * dt, 0.5 * float(np.ptp(beside)) * dt


def _named(period: float, error: float) -> float | None:
    """Return the turn or the roundest number within three errors of a period, None if neither."""
    rounded = [float(f'{period:.{digits}g}') for digits in _DIGITS]
    for name in (*_TURNS, *rounded):
        if abs(period - name) <= 3.0 * error:
            return name
    return None


def unwrapped(log: JointLog) -> JointLog:
    """
    Return a recording with the positions that wrap made continuous; ``log.wraps`` has the periods.

    Every step of more than half of a period is taken for the shorter way around.
    """
    q, wraps = log.q, dict(log.wraps)
    for i, name in enumerate(log.names):
        period = wrap_period(log.time, log.q[:, i])
        if period is None:
            continue
        known = np.isfinite(log.q[:, i])
        q = q.copy()
        q[known, i] = np.unwrap(q[known, i], period=period)
        wraps[name] = period
    return log if q is log.q else replace(log, q=q, wraps=wraps)


def near_turn(position: FloatArray, like: FloatArray, period: float | FloatArray) -> FloatArray:
    """Return a position moved by whole periods to less than half of one from another."""
    return np.asarray(position + period * np.round((like - position) / period))


class RunningUnwrap:
    """
    Make positions continuous as they come; of a recording :func:`unwrapped` does it.

    The first wrap is known by the motion before it, as many steps as a recording has on both
    sides, and a period that is a turn or a round number of at least 1 rad or m; any later one by
    that period.

    :param n: number of positions in a sample.
    :param periods: what is known of each (n,), NaN for nothing.
    """

    def __init__(self, n: int, periods: FloatArray | None = None) -> None:
        self.periods = np.full(n, np.nan) if periods is None else periods
        self._turned = np.zeros(n)
        self._time: deque[int] = deque(maxlen=2 * _BESIDE + 1)
        self._raw: deque[list[float]] = deque(maxlen=2 * _BESIDE + 1)
        self._low, self._high = [math.inf] * n, [-math.inf] * n

    def __call__(self, t_ns: int, q: FloatArray) -> FloatArray:
        """Return the positions (n,) of the next sample, continuous; NaN stays NaN."""
        if self._time and t_ns <= self._time[-1]:
            self._time.clear()
            self._raw.clear()
        # Plain floats: NumPy takes several times as long over a few joints.
        known = q.tolist()
        last = self._raw[-1] if self._raw else known
        for i, now in enumerate(known):
            if not math.isfinite(now):
                known[i] = now = last[i]
            self._low[i] = now if now < self._low[i] else self._low[i]
            self._high[i] = now if now > self._high[i] else self._high[i]
            if abs(now - last[i]) > _HALF * (self._high[i] - self._low[i]):
                self._look(i, t_ns, now)
        wraps = np.isfinite(self.periods)
        if wraps.any():
            here = np.array(known)
            back = near_turn(here, np.array(last), np.where(wraps, self.periods, 1.0)) - here
            self._turned += np.where(wraps & np.isfinite(back), back, 0.0)
        self._time.append(t_ns)
        self._raw.append(known)
        return np.asarray(q + self._turned)

    def _look(self, i: int, t_ns: int, position: float) -> None:
        """Take the period that the step to a position shows, if it shows one."""
        if len(self._time) <= 2 * _BESIDE or np.isfinite(self.periods[i]):
            return
        before = np.diff(np.array(self._time)) * 1e-9
        dt = (t_ns - self._time[-1]) * 1e-9
        if dt > _HOLE * float(np.median(before)):
            return
        raw = np.array([sample[i] for sample in self._raw])
        seen = _seen(position - raw[-1], dt, np.diff(raw) / before)
        if seen is None or self._high[i] - self._low[i] > (1.0 + _SAME) * seen[0]:
            return
        period, error = seen
        if error <= _SAME * period and period >= _LEAST:
            name = _named(period, max(error, 1e-4 * period))
            self.periods[i] = np.nan if name is None else name
