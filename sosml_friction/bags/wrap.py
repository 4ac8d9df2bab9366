# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that wrap: an encoder's register that begins anew at the end of its range."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.sampling import HOLE

if TYPE_CHECKING:
    from sosml_friction.bags.joint_log import JointLog

#: A register wraps by its whole range: a step of less than half of it is told from none by nobody.
HALF = 0.5
#: Wraps are of one period; the motion within a step is known by its neighbours, to this share.
SAME = 0.02
#: Steps before and after a wrap that must go the same way: one sample beside the others is none.
BESIDE = 2
#: A period that is a turn, or a round number of rad, deg or m, within its error is that one.
_TURNS = (2.0 * np.pi, 4.0 * np.pi, np.pi, 360.0, 180.0)
_DIGITS = (1, 2)
#: Fewest wraps by another period: one or two may be recordings that were joined.
_FEWEST = 3
#: Share of a period that steps of motion are within, but for one of a hundred, which may be a bad
#: sample, and fewest such steps: normal noise jumps by four times the largest of twenty steps in
#: two samples of 10^7 (integral of its distribution).
_FOLLOWED, _WITHIN, _STEPS = 0.25, 0.99, 20
#: Least period [rad or m] that is told on line, by one wrap: noise and its steps are smaller.
LEAST = 1.0


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
    if len(q) < 2 * BESIDE + 2:
        return None
    span = float(np.ptp(q))
    steps = np.diff(q)
    jumps = np.flatnonzero(np.abs(steps) > HALF * span)
    if not len(jumps) or span == 0.0:
        return None
    dt = np.diff(t)
    speed = steps / dt
    sizes, errors = [], []
    whole_steps = dt <= HOLE * float(np.median(dt))
    followed = whole_steps & (steps != 0.0)
    followed[jumps] = False
    for k in jumps[whole_steps[jumps]]:
        near = np.r_[max(0, k - BESIDE) : k, k + 1 : min(k + 1 + BESIDE, len(steps))]
        seen = seen_period(float(steps[k]), float(dt[k]), speed[near])
        if len(near) == 2 * BESIDE and seen is not None and not np.isin(near, jumps).any():
            sizes.append(seen[0])
            errors.append(seen[1])
    if not sizes:
        return None
    period = float(np.median(sizes))
    off = np.abs(np.array(sizes) - period)
    error = float(np.median(errors)) / np.sqrt(len(sizes))
    alike = (off <= SAME * period + np.array(errors)).all() and error <= SAME * period
    whole = (np.abs(np.abs(steps[jumps]) - period) <= HALF * period).all()
    if not (alike and whole and span <= (1.0 + SAME) * period):
        return None
    name = named_period(period, max(error, 1e-4 * period))
    several = len(sizes) >= _FEWEST
    small = np.abs(steps[followed]) < _FOLLOWED * period
    # Noise does not jump by a turn several times: then a wheel may be as fast as it is.
    if small.sum() < max(_STEPS, _WITHIN * len(small)) and not (several and name in _TURNS):
        return None
    return name if name is not None or not several else period


def seen_period(step: float, dt: float, beside: FloatArray) -> tuple[float, float] | None:
    """Return the period that a step shows, by the speeds beside it, and its error, or None."""
    # At the edge of the range noise alone goes to and fro: such a step says nothing more.
    if not (np.sign(beside) == -np.sign(step)).all():
        return None
    return abs(step) + abs(float(np.mean(beside))) * dt, 0.5 * float(np.ptp(beside)) * dt


def named_period(period: float, error: float) -> float | None:
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
