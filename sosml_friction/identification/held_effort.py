# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Efforts that come at a lower rate than the samples, and are repeated until the next one."""

from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog

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


def new_efforts(tau: FloatArray) -> IndexArray | None:
    """
    Return the samples whose effort is a new one; None if that of every sample is.

    Efforts are repeated where they change after whole periods of two samples and more only. Of a
    rest, or of an effort of few counts, the samples are told in which a new one came that was
    as the one before.

    :param tau: effort of one joint (N,) [Nm or N], NaN where not known.
    """
    known = np.flatnonzero(np.isfinite(tau))
    steps = np.abs(np.diff(tau[known]))
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


def with_new_efforts(log: JointLog) -> tuple[JointLog, str]:
    """
    Return the samples in which the slowest effort is a new one, and what was left out, or ''.

    An effort that is repeated is of an earlier time, on average by half of its period, which reads
    as viscous friction. When it acted is then told by the motion, as between samples. Other
    efforts that are repeated are on the line between their new ones.

    :param log: a recording whose stamps rise.
    """
    new = {i: own for i, tau in enumerate(log.tau.T) if (own := new_efforts(tau)) is not None}
    rates = {i: 1.0 / float(np.median(np.diff(log.time[own]))) for i, own in new.items()}
    if not new or min(rates.values()) < _SLOWEST:
        return log, ''
    tau = log.tau.copy()
    for i, own in new.items():
        line = np.interp(log.time, log.time[own], log.tau[own, i], left=np.nan, right=np.nan)
        # What was not known stays so.
        tau[:, i] = np.where(np.isnan(log.tau[:, i]), np.nan, line)
    slowest = min(new, key=lambda i: len(new[i]))
    rows, rate = new[slowest], rates[slowest]
    told = (
        f'the effort of {", ".join(log.names[i] for i in new)} is repeated until the next one '
        f'comes, of {log.names[slowest]} at {rate:.3g} Hz: {len(log) - len(rows)} of {len(log)} '
        'samples between are left out, whose effort is of an earlier time'
    )
    return replace(log, tau=tau).rows(rows), told
