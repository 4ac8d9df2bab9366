# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Single positions that no motion goes to: a bit that was read wrongly."""

import numpy as np
from scipy.stats import norm

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.marked_samples import without_marked
from sosml_friction.observers.signal_noise import signal_noise, white_noise

#: Chance that noise alone makes a glitch of one sample of a recording.
_CHANCE = 1e-3


def step_speeds(time: FloatArray, q: FloatArray) -> tuple[FloatArray, float]:
    """
    Return the speed of each step (N - 1,) between known positions, and the highest a joint has.

    That is v + sqrt(2) sigma z / T, v the highest speed that it has in one direction over two
    steps, T the period, sigma the white noise of a position, at least a count, and z the normal
    quantile that noise exceeds in one of N samples with the chance of a thousandth.

    :param time: stamps (N,) [s].
    :param q: positions (N,) [rad or m].
    """
    steps = np.diff(time)
    if not (steps > 0.0).any():
        return np.zeros(len(steps)), np.inf
    period = float(np.median(steps[steps > 0.0]))
    # Over a hole a joint goes far; a stamp that is late makes no speed.
    speed = np.diff(q) / np.maximum(steps, period)
    slower = np.minimum(np.abs(speed[1:]), np.abs(speed[:-1]))
    top = float(np.max(slower, where=speed[1:] * speed[:-1] > 0.0, initial=0.0))
    noise = max(white_noise(q), signal_noise(q)[0])
    return speed, top + np.sqrt(2.0) * noise * float(norm.isf(0.5 * _CHANCE / len(q))) / period


def glitches(time: FloatArray, q: FloatArray) -> BoolArray:
    """
    Return which positions (N,) of a joint are none: it would go there and back at once, too fast.

    :param time: stamps (N,) [s].
    :param q: positions (N,) [rad or m], NaN where not known.
    """
    found = np.zeros(len(q), dtype=bool)
    rows = np.flatnonzero(np.isfinite(q))
    speed, limit = step_speeds(time[rows], q[rows])
    slower = np.minimum(np.abs(speed[1:]), np.abs(speed[:-1]))
    found[rows[1:-1]] = (speed[1:] * speed[:-1] < 0.0) & (slower > limit)
    return found


def without_glitches(log: JointLog) -> tuple[JointLog, dict[str, str]]:
    """Return the samples without glitches of a position, and what is said of them by joint."""
    return without_marked(log, glitches, _told)


def _told(time: FloatArray, q: FloatArray, found: BoolArray) -> str:
    at = np.flatnonzero(found)
    others = np.flatnonzero(np.isfinite(q) & ~found)
    off = float(np.max(np.abs(q[at] - np.interp(at, others, q[others]))))
    return (
        f'is off by up to {off:.3g} in {len(at)} single samples, first in number {at[0]}: it '
        'would go there and back faster than it ever goes one way, so that they are left out'
    )
