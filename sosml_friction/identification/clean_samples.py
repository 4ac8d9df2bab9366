# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The samples of a recording that are measurements, in order, and what was left out of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import lost_share, too_slow
from sosml_friction.bags.wrap import unwrapped
from sosml_friction.exceptions import DataError
from sosml_friction.identification.data_finding import LEFT_OUT, NOTE, DataFinding
from sosml_friction.identification.even_stamps import EVEN, with_even_stamps
from sosml_friction.identification.glitches import without_glitches
from sosml_friction.identification.held_positions import without_held
from sosml_friction.identification.joint_relations import WINDOW_S
from sosml_friction.identification.lost_zero import LOST_ZERO, without_lost_zero
from sosml_friction.identification.new_values import repeated_samples, with_new_values

#: Six windows of steady motion, the fewest a law is fitted to, take at least this long [s].
SHORTEST_S = 2.0
#: A stamp further back than this is of another recording, a nearer one came late [s].
_LATE_S = 0.1
#: Share of samples with a repeated stamp beyond which the stamps are wrong.
_MOST_REPEATED = 0.2
#: Share of samples that the longest stretch of one clock must have.
_LEAST_KEPT = 0.5


@dataclass(frozen=True)
class CleanSamples:
    """
    Hold a recording whose stamps rise, with a position of every joint in every sample.

    ``period_s`` is its median step, ``steps`` (N - 1,) [s] all of them as they were recorded.
    ``findings`` say what was left out. ``lost_share`` of the samples lacks, in whatever way. Left
    out are ``repeated_stamps``, ``backward_stamps`` (samples of another pass; samples that only
    came late are sorted, and not counted) and ``incomplete_samples`` (a position is missing).
    """

    log: JointLog
    findings: tuple[DataFinding, ...]
    period_s: float
    steps: FloatArray
    lost_share: float
    repeated_stamps: int
    backward_stamps: int
    incomplete_samples: int

    @classmethod
    def of(cls, log: JointLog) -> CleanSamples:
        """
        Return what is measured of a recording.

        A run without position is left out as if it had never been received.

        :raises DataError: if nothing is; one sentence: what, where, and what to do.
        """
        findings: list[DataFinding] = []
        # A bag is unwrapped where it is read; a log may come from elsewhere.
        log, backward = _one_pass(unwrapped(log), findings)
        log, repeated_stamps = _without_repeats(log, findings)
        # Before anything is interpolated beside a glitch, and where it was repeated.
        log = _without_glitches(log, findings)
        log, found = with_new_values(log)
        findings += found
        log, incomplete = _whole_samples(log, findings)
        log = _without_repeated_samples(log, findings)
        log = _without_glitches(log, findings)
        log, held = without_held(log)
        findings += [DataFinding('held', name, LEFT_OUT, what) for name, what in held.items()]
        log, leaps = without_lost_zero(log)
        findings += [DataFinding(LOST_ZERO, name, LEFT_OUT, what) for name, what in leaps.items()]
        steps = np.diff(log.time)
        if len(steps) == 0 or log.time[-1] < SHORTEST_S:
            lost = ''.join(f'; {each.sentence}' for each in findings if each.level == LEFT_OUT)
            raise DataError(
                f'the recording has {len(log)} usable samples over {log.time[-1]:.3g} s: friction '
                'needs motion at several speeds in both directions; record a trajectory of at '
                f'least 10 s (sosml trajectory lists them){lost}'
            )
        period = float(np.median(steps))
        if slow := too_slow(period):
            raise DataError(slow)
        even, uneven = with_even_stamps(log)
        findings += [DataFinding(EVEN, '*', NOTE, uneven)] if uneven else []
        return cls(
            even,
            tuple(findings),
            period,
            steps,
            lost_share(log.time),
            repeated_stamps,
            backward,
            incomplete,
        )


def _one_pass(log: JointLog, findings: list[DataFinding]) -> tuple[JointLog, int]:
    """Return the longest stretch of one clock, late samples in order, and what is not in it."""
    steps = np.diff(log.t_ns) * 1e-9
    late = int(np.sum((steps < 0.0) & (steps >= -_LATE_S)))
    jumps = np.flatnonzero(steps < -_LATE_S) + 1
    left = 0
    if len(jumps):
        longest = max(np.split(np.arange(len(log)), jumps), key=len)
        left = len(log) - len(longest)
        what = (
            f'the stamps go back {len(jumps)} time{"s" if len(jumps) > 1 else ""}, first by '
            f'{-steps[jumps[0] - 1]:.3g} s at sample {jumps[0]}'
        )
        if len(longest) < _LEAST_KEPT * len(log):
            raise DataError(
                f'{what}, and no stretch between holds half of the {len(log)} samples: stamp '
                'joint_states with one clock that is not set meanwhile, and record one pass '
                'to a bag'
            )
        what += f': the {left} samples outside the longest stretch are left out'
        findings.append(DataFinding('backward_stamps', '*', LEFT_OUT, what))
        log = log.rows(longest)
    if late:
        what = f'{late} samples came after later ones and were put in order'
        findings.append(DataFinding('backward_stamps', '*', NOTE, what))
        log = log.rows(np.argsort(log.t_ns, kind='stable'))
    return log, left


def _without_repeats(log: JointLog, findings: list[DataFinding]) -> tuple[JointLog, int]:
    """
    Return the log with one sample for each stamp, and how many others there were.

    It has the first value of each column: joints may come in messages of their own.
    """
    again = np.append(False, np.diff(log.t_ns) == 0)
    count = int(again.sum())
    if not count:
        return log, 0
    number = np.cumsum(~again) - 1
    single = log.mapped(partial(_first_known, number=number), t_ns=log.t_ns[~again])
    known, left = (int(np.isfinite(np.stack([x.q, x.tau])).sum()) for x in (log, single))
    if known == left:
        return single, 0
    other = int((np.isfinite(log.q) & (log.q != single.q[number])).any(axis=1).sum())
    what = f'{count} of {len(log)} samples repeat the stamp of the one before'
    if other > _MOST_REPEATED * len(log):
        raise DataError(
            f'{what}, {other} of them with another position, so the stamps are not the times of '
            'measurement: let the driver stamp each sample when it is measured'
        )
    findings.append(DataFinding('repeated_stamps', '*', LEFT_OUT, f'{what} and are left out'))
    return single, count


def _first_known(x: FloatArray, number: IndexArray) -> FloatArray:
    """Return the first value that is known of the rows of each number, by column."""
    result = np.full((number[-1] + 1, x.shape[1]), np.nan)
    for own, column in zip(result.T, x.T, strict=True):
        known = np.flatnonzero(np.isfinite(column))[::-1]
        # Of several the last that is assigned stays.
        own[number[known]] = column[known]
    return result


def _without_glitches(log: JointLog, findings: list[DataFinding]) -> JointLog:
    """Return the log without samples of a position to which no motion goes."""
    log, off = without_glitches(log)
    findings += [DataFinding('glitch', name, LEFT_OUT, what) for name, what in off.items()]
    return log


def _without_repeated_samples(log: JointLog, findings: list[DataFinding]) -> JointLog:
    """Return the log without samples that repeat the one before while a joint went on."""
    again = repeated_samples(log)
    count = int(again.sum())
    if not count:
        return log
    what = (
        f'{count} of {len(log)} samples repeat all of the one before while a joint went on, and '
        'are left out as lost'
    )
    findings.append(DataFinding('repeated_samples', '*', LEFT_OUT, what))
    return log.rows(~again)


def _whole_samples(log: JointLog, findings: list[DataFinding]) -> tuple[JointLog, int]:
    """Return the samples with a position of every joint, and how many are not among them."""
    known = np.isfinite(log.q)
    counts = dict(zip(log.names, known.sum(axis=0).tolist(), strict=True))
    for name, times in counts.items():
        if not times:
            raise DataError(
                f'joint {name} has no position in any of {len(log)} samples: let its driver '
                'report it, all joints in one message'
            )
    # A velocity alone may be missing: the observers start afresh there, on line as well.
    whole = np.asarray(known.all(axis=1))
    count = int((~whole).sum())
    if not count:
        return log, 0
    if not whole.any():
        parts = ', '.join(f'{name} in {times}' for name, times in counts.items())
        raise DataError(
            f'no sample has the positions of all joints ({parts} of '
            f'{len(log)}): publish all joints in one message'
        )
    has_effort = np.asarray(np.isfinite(log.tau).any(axis=1))
    if has_effort.any() and not has_effort[whole].any():
        raise DataError(
            f'no sample has both a position and an effort ({int(whole.sum())} and '
            f'{int(has_effort.sum())} of {len(log)} have one): record both over the same time, '
            f'efforts at {1.0 / WINDOW_S:.0f} Hz and more'
        )
    runs = np.split(whole, np.flatnonzero(np.diff(whole)) + 1)
    lacking = ', '.join(name for name, times in counts.items() if times < len(log))
    what = (
        f'{count} of {len(log)} samples lack a position of {lacking} and are left out, up to '
        f'{max(len(run) for run in runs if not run[0])} in a row'
    )
    findings.append(DataFinding('incomplete_samples', '*', LEFT_OUT, what))
    return log.rows(whole), count
