# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Samples that were taken evenly and stamped unevenly, when they were received."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE
from sosml_friction.regression.rival import VERY_STRONG

#: What a finding about it is called.
EVEN = 'even_stamps'
#: Samples over which the phase of stamps is averaged: 13 know it to 0.28 of their scatter, each
#: time four times as many to half of that.
_WIDTHS = (13, 51, 205, 819)
#: The samples to each side that one is between.
_BESIDE = np.array([-2, -1, 1, 2])
_TINY = float(np.finfo(np.float64).tiny)


def with_even_stamps(log: JointLog) -> tuple[JointLog, str]:
    """
    Return a log stamped as evenly as its positions are, and what is said of it, '' for nothing.

    Even stamps are tried whose phase is a mean over several samples, as the clock of a robot
    drifts, and those that were recorded. The positions say which: between its neighbours in time
    a sample is off by r_k, with a Gaussian likelihood of -N / 2 log sum r_k^2 in each joint. Where
    samples were taken unevenly the recorded stamps are the best. Even ones are taken where they
    halve the squares of a joint, so that stamps were more of them than all else: a driver whose
    loop is a little uneven keeps its own. At holes another clock begins.

    :param log: of samples that are measurements; as it is where its stamps do not rise.
    """
    time = log.time
    steps = np.diff(time)
    if not (len(steps) and (steps > 0.0).all()):
        return log, ''
    period = float(np.median(steps))
    cuts = np.flatnonzero(steps > HOLE * period) + 1
    runs = [run for run in np.split(np.arange(len(time)), cuts) if len(run) > _WIDTHS[0]]
    tried = {width: _averaged(time, runs, period, width) for width in _WIDTHS}
    recorded = _squares(time, log.q, runs)
    # Joints that rest, or whose stamps are exact, favour none.
    told = recorded > 0.0
    found = {
        width: np.log(recorded[told] / np.maximum(_squares(stamps, log.q, runs)[told], _TINY))
        for width, stamps in tried.items()
    }
    best = max(found, key=lambda width: float(found[width].sum()))
    less, count = found[best], sum(len(run) - 2 for run in runs)
    # The best of several is taken.
    sure = count * float(less.sum()) > VERY_STRONG + 2.0 * np.log(len(_WIDTHS))
    if not (sure and less.max() > np.log(2.0)):
        return log, ''
    even = _in_free_slots(time, tried[best], log.q, runs)
    moved = even - time
    t_ns = log.t_ns + np.rint(1e9 * moved).astype(np.int64)
    return replace(log, t_ns=t_ns), (
        f'stamps scatter by {1e3 * float(np.std(moved)):.2g} ms (rms) about times at which the '
        'positions are smoother: those are used; stamp each sample when it is measured'
    )


def _averaged(time: FloatArray, runs: list[IndexArray], period: float, width: int) -> FloatArray:
    """
    Return stamps on even ones whose phase is a mean over ``width`` samples, (N,) [s].

    The phase of a stamp is that of exp(2 pi i t / T), whatever was lost. Of two samples at one
    time the first was late.
    """
    result = time.copy()
    for run in runs:
        t = time[run]
        turn = _phase(t, period, min(_WIDTHS[0], width))
        # Phase that goes on turning is a period that is off.
        slope = np.polynomial.Polynomial.fit(t, turn, 1).convert().coef[-1]
        own = period / (1.0 - slope * period / (2.0 * np.pi))
        offset = own / (2.0 * np.pi) * _phase(t, own, width)
        order = np.arange(len(t))
        number = np.rint((t - offset) / own) - order
        number = np.minimum.accumulate(number[::-1])[::-1] + order
        result[run] = offset + own * number
    return result


def _in_free_slots(
    time: FloatArray, even: FloatArray, q: FloatArray, runs: list[IndexArray]
) -> FloatArray:
    """
    Return even stamps of which some are a period sooner or later, as the positions say, (N,) [s].

    Beside a lost sample one that is late by more than half a period is nearer to the next even
    time, which is free. So the even time to the other side of a stamp is tried where it is free:
    r is what the position is off from the cubic through two samples to each side, and that time
    is right where it halves the squares of r, by more than chance would.
    """
    result = even.copy()
    for run in runs:
        t, x = even[run], q[run]
        if len(run) < len(_BESIDE) + 1:
            continue
        period = float(np.median(np.diff(t)))
        k = np.arange(2, len(run) - 2)
        way = np.where(t[k] > time[run][k], -1, 1)
        free = np.abs(t[k + way] - t[k]) > 1.5 * period
        beside = k[:, None] + _BESIDE
        taken = _off(t[k], x[k], t[beside], x[beside]) ** 2
        # Joints whose position is not known say nothing, nor do those that rest.
        told = np.isfinite(taken).any(axis=0)
        spread = np.full(q.shape[1], np.nan)
        spread[told] = np.nanmedian(taken[:, told], axis=0)
        told = spread > 0.0
        k, way, taken = k[free], way[free], taken[free][:, told]
        beside = k[:, None] + _BESIDE
        moved = t[k] + way * period
        other = _off(moved, x[k], t[beside], x[beside])[:, told] ** 2
        before, after = (np.nansum(r / spread[told], axis=1) for r in (taken, other))
        less = np.zeros(len(run))
        less[k] = np.where(2.0 * after < before, before - after, 0.0)
        # One that is wrong spoils the cubics of its neighbours.
        most = maximum_filter1d(less, len(_BESIDE) + 1)[k]
        right = (less[k] == most) & (most > 2.0 * VERY_STRONG)
        result[run[k[right]]] = moved[right]
    return result


def _off(t: FloatArray, x: FloatArray, times: FloatArray, values: FloatArray) -> FloatArray:
    """Return x (K, n) at t (K,) less the polynomial through values (K, m, n) at times (K, m)."""
    off = x.copy()
    for j in range(times.shape[1]):
        others = np.delete(times, j, axis=1)
        share = np.prod((t[:, None] - others) / (times[:, j, None] - others), axis=1)
        off -= share[:, None] * values[:, j]
    return off


def _phase(t: FloatArray, period: float, width: int) -> FloatArray:
    """Return the phase of stamps, a mean over ``width`` of them, continued over whole turns."""
    turns = 2.0 * np.pi / period * t
    cosine, sine = (uniform_filter1d(f(turns), width, mode='nearest') for f in (np.cos, np.sin))
    return np.asarray(np.unwrap(np.arctan2(sine, cosine)))


def _squares(time: FloatArray, q: FloatArray, runs: list[IndexArray]) -> FloatArray:
    """Return by joint the sum of the squares of what samples are off between neighbours, (n,)."""
    squares = np.zeros(q.shape[1])
    for run in runs:
        t, x = time[run], q[run]
        share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
        squares += np.nansum((x[1:-1] - x[:-2] - share * (x[2:] - x[:-2])) ** 2, axis=0)
    return squares
