# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Long recordings as means of a few samples each, so that time and memory stay bounded."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE
from sosml_friction.exceptions import DataError

#: Samples from which on means are taken: ten minutes of 1 kHz. Chosen by what an hour costs:
#: benchmarks/long_recordings.py.
MOST_SAMPLES = 600_000
#: Least rate of the means [Hz]. Between 83 Hz, where a reversal falls within a sample and an hour
#: of that benchmark had two false causes (at half as many samples), and 167 Hz, where it had none.
_LEAST_HZ = 150.0
#: Blocks whose samples are taken together: an array of all of them would be another recording.
#: Chosen, no measurement.
_AT_ONCE = 16_384


def block_means(
    log: JointLog, effort_hold: Sequence[str] = (), most: int = MOST_SAMPLES
) -> tuple[JointLog, int]:
    """
    Return a recording as means of blocks of m samples, and m: 1 up to ``most`` samples.

    m is no larger than leaves 150 Hz.

    Means of position, velocity and effort over the same time are a low-pass of both sides of the
    model, and keep what many samples know of a position. No block reaches over a hole; samples
    without a position, and blocks that are not full, are left out. An effort that is not known is
    left out of its mean.

    :param effort_hold: where in an interval the effort of each joint holds, ``mean`` if empty. A
        mean is then of the effort that acts from half an interval before a sample to half after.
    :raises DataError: if there are no two blocks.
    """
    forwards = np.diff(log.t_ns)
    forwards = forwards[forwards > 0]
    count = -(-len(log) // most)
    if len(forwards):
        count = min(count, max(1, int(1e9 / (np.median(forwards) * _LEAST_HZ))))
    if count == 1:
        return log, 1
    tau = log.tau.copy()
    for i, hold in enumerate(effort_hold):
        if hold == 'start':
            tau[1:, i] = 0.5 * (log.tau[1:, i] + log.tau[:-1, i])
        elif hold == 'end':
            tau[:-1, i] = 0.5 * (log.tau[1:, i] + log.tau[:-1, i])
    rows = np.flatnonzero(np.isfinite(log.q).all(axis=1))
    rows = rows[np.append(True, np.diff(log.t_ns[rows]) != 0)] if len(rows) else rows
    if len(rows) < 2:
        raise DataError(
            'no two samples have a position of every joint: record all joints in one message'
        )
    steps = np.diff(log.t_ns[rows])
    hole = (steps < 0) | (steps > HOLE * np.median(steps))
    runs = np.split(rows, np.flatnonzero(hole) + 1)
    blocks = [run[: len(run) // count * count].reshape(-1, count) for run in runs]
    block = blocks[0] if len(blocks) == 1 else np.concatenate(blocks)
    del steps, hole
    if len(block) < 2:
        raise DataError(
            f'there are nowhere {2 * count} samples in a row, of which two means could be made: '
            'record stamps that go forwards, without holes'
        )

    def means(column: FloatArray) -> FloatArray:
        result = np.empty((len(block), *column.shape[1:]))
        for k in range(0, len(block), _AT_ONCE):
            values = column[block[k : k + _AT_ONCE]]
            known = np.isfinite(values)
            number = known.sum(axis=1)
            total = np.where(known, values, 0.0).sum(axis=1)
            mean = np.where(number > 0, total / np.maximum(number, 1), np.nan)
            result[k : k + _AT_ONCE] = mean
        return result

    first = log.t_ns[block[:, 0]]
    late = sum(log.t_ns[block[:, k]] - first for k in range(1, count)) / count
    t_ns = first + np.rint(late).astype(np.int64)
    return replace(log, tau=tau).mapped(means, t_ns=t_ns), count


def block_sentence(log: JointLog, count: int) -> str:
    """Return what was done to a recording that is now ``log``."""
    rate = 1.0 / float(np.median(np.diff(log.time)))
    return f'the recording is long: means of {count} samples are used, {rate:.3g} Hz'
