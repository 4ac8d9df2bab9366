# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Values that are new, and those that repeat an earlier one: what is not new is no measurement."""

from dataclasses import replace

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import repeated_rows
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
#: What a finding on held values is called, by the column of a log.
HELD = {'q': 'held_position', 'tau': 'held_effort'}


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


def with_new_values(log: JointLog) -> tuple[JointLog, dict[str, str]]:
    """
    Return the samples in which the slowest value is a new one, and what was left out, by finding.

    A value that is repeated is of an earlier time, on average by half of its period: an effort
    then reads as viscous friction, a position as jumps. What happened in between is then told as
    between any samples. Other values that are repeated are on the line between their new ones.

    :param log: a recording whose stamps rise.
    """
    new = {('q', i): own for i, q in enumerate(log.q.T) if (own := new_positions(q)) is not None}
    for i, tau in enumerate(log.tau.T):
        own = new_values(tau)
        if own is not None and _rate(log, own) >= _SLOWEST:
            new['tau', i] = own
    if not new:
        return log, {}
    columns = {'q': log.q.copy(), 'tau': log.tau.copy()}
    for (what, i), own in new.items():
        x = columns[what][:, i]
        line = np.interp(log.time, log.time[own], x[own], left=np.nan, right=np.nan)
        # What was not known stays so.
        columns[what][:, i] = np.where(np.isnan(x), np.nan, line)
    slowest = min(new, key=lambda key: len(new[key]))
    rows, told = new[slowest], {}
    for what, word in {'q': 'position', 'tau': 'effort'}.items():
        of_kind = {i: own for (kind, i), own in new.items() if kind == what}
        if of_kind:
            last = min(of_kind, key=lambda i: len(of_kind[i]))
            names = ', '.join(log.names[i] for i in of_kind)
            told[HELD[what]] = (
                f'the {word} of {names} is repeated until the next one comes, of '
                f'{log.names[last]} at {_rate(log, of_kind[last]):.3g} Hz: '
                f'{len(log) - len(rows)} of {len(log)} samples between are left out, whose '
                f'{word} is of an earlier time'
            )
    return replace(log, **columns).rows(rows), told


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
