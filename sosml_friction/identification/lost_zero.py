# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that leap and stay there: an encoder that lost its zero, or was set anew."""

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE
from sosml_friction.identification.glitches import step_speeds

#: What a finding about it is called.
LOST_ZERO = 'lost_zero'
#: By how many times a leap is more than the largest other change from one step to the next. What
#: knocks a joint makes it no faster than it ever goes; twice, as nothing else is near it. Chosen,
#: no measurement.
_MORE = 2.0
#: Most leaps of a joint. One that leaps more often sticks and slips. Chosen, no measurement.
_MOST = 5


def leaps(time: FloatArray, q: FloatArray) -> IndexArray:
    """
    Return the samples from which on a joint is elsewhere, as it never goes so far in a step.

    It would be faster for one step than it ever is in one direction over two, as of
    :func:`~sosml_friction.identification.glitches.step_speeds`, and go on at its speed of before.
    Across a hole a joint may have been moved.

    :param time: rising stamps (N,) [s].
    :param q: known positions (N,) [rad or m].
    """
    speed, limit = step_speeds(time, q)
    changes, steps = np.abs(np.diff(speed)), np.diff(time)
    if len(changes) < 2:
        return np.array([], dtype=np.intp)
    found = np.flatnonzero((np.abs(speed) > limit) & (steps < HOLE * np.median(steps)))
    if not 0 < len(found) <= _MOST:
        return np.array([], dtype=np.intp)
    # Of the changes into a step and out of it the smaller is by the leap alone.
    beside = np.concatenate([[changes[0]], np.minimum(changes[1:], changes[:-1]), [changes[-1]]])
    others = np.ones(len(changes), dtype=bool)
    others[np.clip(np.concatenate([found - 1, found]), 0, len(changes) - 1)] = False
    largest = float(np.max(changes, where=others, initial=0.0))
    return np.asarray(found[beside[found] > _MORE * largest] + 1)


def without_lost_zero(log: JointLog) -> tuple[JointLog, dict[str, str]]:
    """
    Return the longest stretch in which no position leaps, and what is said of the leaps by joint.

    Which of two zeros is that of the model no recording tells.
    """
    found = {
        name: at
        for name, q in zip(log.names, log.q.T, strict=True)
        if len(at := leaps(log.time, q))
    }
    if not found:
        return log, {}
    cuts = np.unique(np.concatenate(list(found.values())))
    kept = max(np.split(np.arange(len(log)), cuts), key=len)
    told = {}
    for name, at in found.items():
        first, q = int(at[0]), log.q[:, log.names.index(name)]
        often = '' if len(at) == 1 else f' the first of {len(at)} times'
        told[name] = (
            f'the position of joint {name} leaps{often} by {abs(q[first] - q[first - 1]):.3g} at '
            f'{log.time[first]:.4g} s, farther than it ever goes in a step, and stays there, as '
            'where an encoder loses its zero: what is outside the longest stretch, '
            f'{len(log) - len(kept)} of {len(log)} samples, is left out; see its encoder'
        )
    return log.rows(kept), told
