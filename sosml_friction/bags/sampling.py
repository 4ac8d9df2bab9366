# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How evenly a recording was sampled: lost samples told from stamps that are off, and repeats."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import BoolArray, FloatArray

#: Rates at which joints are recorded [Hz]: every unit of time has three decades of its own. One of
#: 10 Hz is within, whatever its stamps are rounded to.
RATES = (9.5, 9_500.0)
#: A step of fewer periods than this holds no other sample.
_LONG = 1.5
#: A step of more median steps than this is a hole: what happened in it is not known. Half a period
#: of the widest band of a diagnosis, a tenth of the rate.
HOLE = 5.0
#: A longer step is a pause [s], as between two runs in one file, or a clock that was set: whoever
#: loses samples on the way loses fewer in a row. Chosen, no measurement.
PAUSE = 1.0
#: An even clock that loses samples has long steps of whole periods, within this share of one. By
#: chance two in five are; the share that tells is half way from there to all, which stamps that
#: scatter by 0.12 of a period still have: P(|x| < 0.2) of a difference of two.
_WITHIN = 0.2
_WHOLE = 0.5 * (1.0 + 2.0 * _WITHIN)
#: Steps to either side in which a stamp that came late is made up for.
_BESIDE = 2


def too_slow(step: float) -> str:
    """Return a sentence on samples this far apart [s], '' if joints may be recorded so."""
    if step <= 1.0 / RATES[0]:
        return ''
    return (
        f'samples are {step:.3g} s apart, where joints are recorded at {RATES[0]:.0f} Hz and '
        'more: check the unit of time, as ms that were taken for s (--time COLUMN:ms); else '
        'record at 50 Hz or more'
    )


def repeated_rows(series: Iterable[NDArray[Any]]) -> BoolArray:
    """Return which samples (N,) repeat the one before them in every series, each (N,)."""
    found = []
    for x in series:
        # NaN is what it was, too.
        same = (x[1:] == x[:-1]) | ((x[1:] != x[1:]) & (x[:-1] != x[:-1]))
        found.append(np.append(False, same)[: len(x)])
    return np.logical_and.reduce(found)


def lost_samples(time: FloatArray) -> int:
    """
    Return how many samples are missing between the others.

    A hole is a step of more than 1.5 median steps; what is missing in it are the whole steps that
    it has more than its place and its neighbours: a late stamp is followed by short steps, a clock
    in multiples of a controller's cycle has some of each, and neither has lost anything. A pause
    has lost nothing either.

    :param time: stamps (N,) [s]; steps backwards and of zero are left out.
    """
    steps = np.diff(time)
    steps = steps[steps > 0.0]
    if not len(steps):
        return 0
    period = float(np.median(steps))
    usual = np.minimum(steps, period)
    lost = 0
    for k in np.flatnonzero((steps > _LONG * period) & (steps <= PAUSE)):
        beside = np.r_[usual[max(0, k - _BESIDE) : k], usual[k + 1 : k + 1 + _BESIDE]]
        # Periods that the hole has more than the one of its step, less those its neighbours lack.
        more = steps[k] / period - 1.0 - float(np.sum(1.0 - beside / period))
        lost += max(0, int(np.rint(more)))
    return lost


def held_share(time: FloatArray) -> FloatArray:
    """
    Return the part of each step for which its effort holds, (N - 1,), 1 for all of it.

    Where a recorder lost m - 1 samples of an even clock, an effort is that of the last of m
    periods, or of the first, and the others are not known: 1 / m. Where a loop itself took longer,
    by any time, its command was held, or its mean taken, for all of it.

    :param time: stamps (N,) [s].
    """
    steps = np.diff(time)
    known = steps[steps > 0.0]
    period = float(np.median(known)) if len(known) else np.inf
    # What is longer is a hole, by whatever made it.
    long = known[(known > _LONG * period) & (known < HOLE * period)] / period
    whole = np.abs(long - np.rint(long)) <= _WITHIN
    if not len(long) or float(np.mean(whole)) < _WHOLE:
        return np.ones(len(steps))
    return np.asarray(1.0 / np.maximum(1.0, np.rint(steps / period)))


def pauses(time: FloatArray) -> FloatArray:
    """Return how long each pause between samples lasts, (k,) [s]."""
    steps = np.diff(time)
    return np.asarray(steps[steps > PAUSE])


def pauses_text(time: FloatArray) -> str:
    """Return how many pauses there are and of what length, '' for none."""
    found = pauses(time)
    if not len(found):
        return ''
    many = f'{len(found)} pauses of up to' if len(found) > 1 else 'a pause of'
    return f'{many} {found.max():.4g} s'


def lost_share(time: FloatArray) -> float:
    """Return the share of the samples that are missing, 0 to 1."""
    lost = lost_samples(time)
    return lost / (lost + len(time))
