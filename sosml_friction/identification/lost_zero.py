# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that leap and stay there: an encoder that lost its zero, or was set anew."""

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE
from sosml_friction.identification.glitches import step_speeds

#: What a finding about it is called.
LOST_ZERO = 'lost_zero'
#: Longest period of samples [s], of 50 Hz and its jitter: in a longer one a quick servo may go a
#: small step and be at rest again. Chosen, no measurement.
_LONGEST_S = 0.021
#: Most leaps of a joint. One that leaps more often sticks and slips. Chosen, no measurement.
_MOST = 5
#: Samples to either side that say where a joint is before a leap and after it, beside the two next
#: to it. A line through them is off by a half and less of a leap that no acceleration makes.
_SIDE = 5
#: Share of a leap by which what is said of it on both sides may be off.
_OFF = 0.5


def leaps(time: FloatArray, q: FloatArray) -> dict[int, float]:
    """
    Return by how far a joint is elsewhere from a sample on, as it never goes so far in a step.

    It would be faster for one step than it ever is in one direction over two, as of
    :func:`~sosml_friction.identification.glitches.step_speeds`, and positions before it and after
    it are on lines that are as far apart. Those beside a sample that came late, or that repeat an
    older one, are not. Across a hole a joint may have been moved.

    :param time: rising stamps (N,) [s].
    :param q: known positions (N,) [rad or m].
    """
    steps = np.diff(time)
    if not len(steps) or np.median(steps) > _LONGEST_S:
        return {}
    speed, limit = step_speeds(time, q)
    fast = np.flatnonzero((np.abs(speed) > limit) & (steps < HOLE * np.median(steps))) + 1
    if len(fast) > _MOST:
        return {}
    found = {int(k): _offset(time, q, int(k)) for k in fast}
    return {
        k: offset
        for k, offset in found.items()
        if abs(offset - (q[k] - q[k - 1])) < _OFF * abs(q[k] - q[k - 1])
    }


def _offset(time: FloatArray, q: FloatArray, k: int) -> float:
    """Return how far lines before and after a step to sample k are apart there, NaN if open."""
    sides = [np.arange(k - 1 - _SIDE, k - 1), np.arange(k + 1, k + 1 + _SIDE)]
    if sides[0][0] < 1 or sides[1][-1] >= len(q):
        return np.nan
    # A position that repeats the one before may be an older one.
    new = [rows[q[rows] != q[rows - 1]] for rows in sides]
    both = [own if len(own) > 1 else rows for own, rows in zip(new, sides, strict=True)]
    before, after = (np.polynomial.Polynomial.fit(time[rows], q[rows], 1) for rows in both)
    at = 0.5 * (time[k - 1] + time[k])
    return float(after(at) - before(at))


def _elsewhere(found: dict[int, float], count: int) -> BoolArray:
    """Return which of ``count`` samples have another zero than most."""
    if not found:
        return np.zeros(count, dtype=bool)
    level = np.zeros(count)
    for k, offset in found.items():
        level[k:] += offset
    # Leaps there and back end at the old zero.
    near = _OFF * min(abs(offset) for offset in found.values())
    zeros = np.unique(level)
    most = max(zeros, key=lambda zero: np.count_nonzero(np.abs(level - zero) < near))
    return np.asarray(np.abs(level - most) >= near)


def without_lost_zero(log: JointLog) -> tuple[JointLog, dict[str, str]]:
    """
    Return the samples of the zeros that most have, and what is said of the leaps by joint.

    Which of two zeros is that of the model no recording tells. Where several joints leap at once
    rows are missing.
    """
    by_joint = [leaps(log.time, q) for q in log.q.T]
    every = [k for own in by_joint for k in own]
    by_joint = [{k: x for k, x in own.items() if every.count(k) == 1} for own in by_joint]
    off = np.column_stack([_elsewhere(own, len(log)) for own in by_joint])
    told = {
        name: (
            f'the position of joint {name} leaps {len(own)} time{"s" if len(own) > 1 else ""}, '
            f'by up to {max(map(abs, own.values())):.3g}, first at {log.time[min(own)]:.4g} s, '
            'farther than it ever goes in a step, and stays there, as where an encoder loses its '
            f'zero, or rows are missing: {np.count_nonzero(off[:, i])} of {len(log)} samples, of '
            'another zero than most, are left out; see its encoder'
        )
        for i, (name, own) in enumerate(zip(log.names, by_joint, strict=True))
        if own
    }
    return (log.rows(np.flatnonzero(~off.any(axis=1))), told) if told else (log, told)
