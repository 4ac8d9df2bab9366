# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Values that are new, and those that repeat an earlier one: what is not new is no measurement."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE, repeated_rows
from sosml_friction.identification.data_finding import LEFT_OUT, NOTE, DataFinding
from sosml_friction.identification.joint_relations import WINDOW_S
from sosml_friction.observers.signal_noise import signal_noise
from sosml_friction.regression.kernels import runs

#: Fewest changes that say something of a rate. Chosen, no measurement.
_FEWEST = 20
#: Share of the shortest times between changes that are by chance, and of all that must be whole
#: periods, within this share of one or half a sample. Chosen: random times of two samples and
#: more are whole periods in at most 60 %.
_BY_CHANCE, _WHOLE, _WITHIN = 0.05, 0.9, 0.2
#: Least share of changes by more than the smallest, or after more than one period: an effort
#: without noise that rises evenly changes by one count after even times. Chosen, no measurement.
_UNEVEN = 0.1
#: Slowest rate of efforts that are taken for repeated ones [Hz]: a command that is held longer, a
#: step or a random binary sequence, acts as it is. Chosen, no measurement: drives report faster.
_SLOWEST = 20.0
#: Columns of a log that say how often a joint is measured, in words.
WORDS = {'q': 'position', 'tau': 'effort'}


def new_values(x: FloatArray) -> IndexArray | None:
    """
    Return the samples whose value is a new one; None if that of every sample is.

    Values are repeated where they change after whole periods of two samples and more only. Of a
    rest, or of an effort of few counts, the samples are told in which a new one came that was
    as the one before.

    :param x: effort or position of one joint (N,), NaN where not known.
    """
    known = np.flatnonzero(np.isfinite(x))
    steps = np.abs(np.diff(x[known]))
    changes = np.flatnonzero(steps > 0.0) + 1
    if len(changes) < _FEWEST:
        return None
    times = np.diff(changes)
    shortest = float(np.quantile(times, _BY_CHANCE))
    if shortest < 2.0:
        return None
    # A rate that is no whole part of the other makes periods of two lengths.
    period = float(np.mean(times[times < 1.5 * shortest + 1.0]))
    count = np.maximum(np.rint(times / period), 1.0)
    whole = np.abs(times - count * period) <= max(0.5, _WITHIN * period)
    sizes = steps[changes - 1]
    uneven = max(float(np.mean(sizes > 1.5 * sizes.min())), float(np.mean(count > 1.0)))
    if float(np.mean(whole)) < _WHOLE or uneven < _UNEVEN:
        return None
    ends = np.append(changes, len(known))
    counts = np.maximum(np.rint(np.diff(ends) / period), 1.0).astype(np.int64)
    own = [
        first + np.rint(np.arange(k) * ((last - first) / k)).astype(np.int64)
        for first, last, k in zip(ends[:-1], ends[1:], counts, strict=True)
    ]
    return known[np.concatenate(own)]


def new_positions(q: FloatArray) -> IndexArray | None:
    """
    Return the samples with a new position, as :func:`new_values`; None if every one is new.

    A slow joint stays within one count for several samples as well, and then goes one further.
    Where positions are repeated, steps of more than two counts come after an equal pair.

    :param q: position of one joint (N,) [rad or m].
    """
    new = new_values(q)
    if new is None:
        return None
    steps = np.abs(np.diff(q[np.isfinite(q)]))
    far = np.flatnonzero(steps[1:] > 2.0 * signal_noise(q)[0]) + 1
    if len(far) < _FEWEST or float(np.mean(steps[far - 1] == 0.0)) < _WHOLE:
        return None
    return new


def _sparse_values(x: FloatArray) -> IndexArray | None:
    """
    Return the samples whose value is known, if some between them are not; None if none is.

    :param x: position or effort of one joint (N,), NaN where not known. What lacks for more than
        five times as long as usual is a hole, and none of its own.
    """
    known = np.flatnonzero(np.isfinite(x))
    steps = np.diff(known)
    if not len(steps) or not (_bridged(steps) & (steps > 1)).any():
        return None
    return known


def _bridged(steps: FloatArray | IndexArray) -> BoolArray:
    """Return which steps (K,) between values are no hole."""
    return np.asarray(steps <= HOLE * np.median(steps))


def with_new_values(log: JointLog) -> tuple[JointLog, list[DataFinding]]:
    """
    Return the samples in which the slowest value is a new one, and what was found.

    A drive may report a value at a lower rate than others, each joint in turn: between its values
    there is none (NaN), or an earlier one is repeated. A value that is repeated is on average half
    of its period old: an effort then reads as viscous friction, a position as jumps. So samples
    between new ones of the slowest are left out: what happened there is told as between any
    samples. Other values are interpolated to these, efforts linearly and positions by a cubic
    spline, and so are a few that lack at the rate of the recording. Where a column is not known
    for longer it leaves out nothing of the others.

    :param log: a recording whose stamps rise.
    """
    new: dict[tuple[str, int], IndexArray] = {}
    held: set[tuple[str, int]] = set()
    for what, found in (('q', new_positions), ('tau', new_values)):
        for i, x in enumerate(getattr(log, what).T):
            own, seldom = found(x), _sparse_values(x)
            if own is not None and (what == 'q' or _rate(log, own) >= _SLOWEST):
                new[what, i] = own
                held.add((what, i))
            elif seldom is not None and _rate(log, seldom) * WINDOW_S >= 1.0:
                new[what, i] = seldom
    if not new:
        return log, []
    columns = {what: getattr(log, what).copy() for what in ('q', 'v', 'tau')}
    if log.temperature is not None:
        columns['temperature'] = log.temperature.copy()
    besides = {
        (what, i): own
        for what in columns.keys() - WORDS.keys()
        for i, x in enumerate(columns[what].T)
        if (own := _sparse_values(x)) is not None
    }
    for (what, i), own in {**new, **besides}.items():
        columns[what][:, i] = _interpolated(log.time, columns[what][:, i], own, what == 'q')
    kept, undecided = np.ones((2, len(log)), dtype=np.bool_)
    for key in sorted(new, key=lambda key: _rate(log, new[key])):
        own = new[key]
        if np.median(np.diff(own)) > 1.0:
            between = _between(own, len(log))
            if key in held:
                # What comes before the first new value, or after the last, is of any time.
                between[: own[0]] = between[own[-1] + 1 :] = True
            kept &= ~(undecided & between)
            undecided &= ~between
            undecided[own] = False
    told = [_finding(log, keys, new, held, kept) for keys in _alike(new, held)]
    return replace(log, **columns).rows(kept), told


def _between(own: IndexArray, count: int) -> BoolArray:
    """Return which of so many samples lie between two of ``own`` without a hole, (count,)."""
    result = np.zeros(count, dtype=np.bool_)
    result[own[0] : own[-1]] = True
    result[own] = False
    for k in np.flatnonzero(~_bridged(np.diff(own))).tolist():
        result[own[k] : own[k + 1]] = False
    return result


def _interpolated(time: FloatArray, x: FloatArray, own: IndexArray, cubic: bool) -> FloatArray:
    """Return ``x`` (N,) through its values in the samples ``own``, as it is in holes."""
    if cubic:
        line = CubicSpline(time[own], x[own], extrapolate=False)(time)
    else:
        line = np.interp(time, time[own], x[own])
    return np.where(_between(own, len(x)), line, x)


def _alike(
    new: dict[tuple[str, int], IndexArray], held: set[tuple[str, int]]
) -> list[list[tuple[str, int]]]:
    """Return the columns of which one thing is said: of one quantity, held or lacking."""
    groups: dict[tuple[str, bool], list[tuple[str, int]]] = {}
    for key in new:
        groups.setdefault((key[0], key in held), []).append(key)
    return list(groups.values())


def _finding(
    log: JointLog,
    keys: list[tuple[str, int]],
    new: dict[tuple[str, int], IndexArray],
    held: set[tuple[str, int]],
    kept: BoolArray,
) -> DataFinding:
    """Return what is said of the columns of one quantity."""
    slowest = min(keys, key=lambda key: _rate(log, new[key]))
    word = WORDS[slowest[0]]
    names = ', '.join(log.names[i] for _, i in keys)
    own = f'{log.names[slowest[1]]} at {_rate(log, new[slowest]):.3g} Hz'
    left = f'{int(np.sum(~kept))} of {len(log)} samples between are left out'
    if slowest in held:
        what = f'the {word} of {names} is repeated until the next one comes, of {own}: {left}'
        return DataFinding(f'held_{word}', '*', LEFT_OUT, what)
    if np.median(np.diff(new[slowest])) > 1.0:
        what = f'the {word} of {names} is not in each sample, of {own}: {left}'
        return DataFinding(f'sparse_{word}', '*', LEFT_OUT, what)
    lacking = sum(int(_between(new[key], len(log)).sum()) for key in keys)
    what = f'{lacking} values lack of the {word} of {names} and are interpolated'
    return DataFinding(f'sparse_{word}', '*', NOTE, what)


def _rate(log: JointLog, rows: IndexArray) -> float:
    """Return how often values come [Hz]."""
    return 1.0 / float(np.median(np.diff(log.time[rows])))


def repeated_samples(log: JointLog) -> BoolArray:
    """
    Return which samples (N,) repeat the one before instead of a measurement that was lost.

    L samples of the same positions and efforts as the one before may be a rest, or a motion of
    less than a count in each. They are repeats if a joint is more than L + T counts further in the
    next sample, which is the first that is new, and comes T of their steps later (1 where stamps
    are regular): no joint stays within a count for L samples and goes that far in that time. Nor
    does one that rested go faster in that sample than in any other: a driver that is not yet up
    reports zeros, however long.
    """
    again = repeated_rows([*log.q.T, *log.tau.T])
    counts = np.array([signal_noise(q)[0] for q in log.q.T])
    new = ~again[1:] & ~again[:-1]
    # NaN is no motion. What does not move between samples that are new says nothing of its speed.
    fastest = np.fmax.reduce(np.abs(np.diff(log.q, axis=0))[new], axis=0, initial=0.0)
    fastest[fastest == 0.0] = np.inf
    steps = np.diff(log.t_ns)
    repeated = np.zeros(len(log), dtype=bool)
    for begin, end in runs(again):
        if end < len(log):
            went = np.abs(log.q[end] - log.q[begin - 1])
            # A change of position is a whole number of counts: half of one is beyond rounding.
            later = np.ceil(steps[end - 1] / max(np.median(steps[begin - 1 : end - 1]), 1.0))
            times = max(float(later), 1.0)
            most = np.minimum((end - begin + times + 0.5) * counts, times * fastest + counts)
            repeated[begin:end] = bool((went > most).any())
    return repeated
