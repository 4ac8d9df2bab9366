# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that leap: samples are missing, and their stamps were made up."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from sosml_friction.arrays import FloatArray

#: Steps to either side of one that are asked, and by what it is more than the largest of them. No
#: motion whose speed rises or falls over these steps has such a step, and a lost sample makes two
#: of one, less what the speed changes by.
_BESIDE, _MORE = 2, 1.8
#: Of so many counts, and standard deviations of noise, a step tells its size to a third and less.
_COUNTS, _SIGMAS = 3.0, 6.0


def position_leaps(time: FloatArray, q: FloatArray, quantum: float, noise: float) -> int:
    """
    Return how often a position goes much farther in one step than in those beside it.

    All steps go the same way, by the stamps in the same time: where a recorder tells what it
    lost, the step is longer in time as well, and is none.

    :param time: (N,) [s]; ``q`` (N,) [rad or m]; ``quantum``, ``noise``: of a position, as of
        :func:`~sosml_friction.observers.signal_noise.signal_noise`.
    """
    steps, speeds = np.diff(q), np.diff(q) / np.diff(time)
    wide = 2 * _BESIDE + 1
    if len(steps) < wide:
        return 0
    own, fast = (sliding_window_view(x, wide) for x in (steps, speeds))
    one_way = np.abs(np.sign(own).sum(axis=1)) == wide
    others = np.delete(np.abs(own), _BESIDE, axis=1)
    tells = others.min(axis=1) > max(_COUNTS * quantum, _SIGMAS * noise)
    leaps = one_way & tells
    for x in (own, fast):
        beside = np.delete(np.abs(x), _BESIDE, axis=1).max(axis=1)
        leaps &= np.abs(x[:, _BESIDE]) > _MORE * beside
    return int(leaps.sum())
