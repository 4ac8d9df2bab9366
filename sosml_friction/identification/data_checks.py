# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a recording, before anything is fitted to it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import too_slow
from sosml_friction.bags.wrap import unwrapped
from sosml_friction.exceptions import DataError
from sosml_friction.identification.data_finding import (
    LEFT_OUT,
    NOTE,
    REFUSED,
    WARNING,
    DataFinding,
)
from sosml_friction.identification.even_stamps import EVEN, with_even_stamps
from sosml_friction.identification.glitches import without_glitches
from sosml_friction.identification.joint_checks import JointChecks, check_joint
from sosml_friction.identification.joint_relations import WINDOW_S, Slopes
from sosml_friction.identification.new_values import repeated_samples, with_new_values
from sosml_friction.identification.stamp_checks import check_stamps
from sosml_friction.identification.swapped_joints import swapped_joints
from sosml_friction.model.robot import Robot

#: Six windows of steady motion, the fewest a law is fitted to, take at least this long [s].
SHORTEST_S = 2.0
#: A stamp further back than this is of another recording, a nearer one came late [s].
_LATE_S = 0.1
#: Steps longer than this many periods count as a gap.
_GAP_PERIODS = 1.5
#: Share of the recording in gaps beyond which it is more than a note. Chosen, no measurement: a
#: driver on a machine with a load of 6 had a third, and the elbow's viscous friction was 16 % off.
_MOST_GAPS = 0.2
#: Share of samples with a repeated stamp beyond which the stamps are wrong.
_MOST_REPEATED = 0.2
#: Share of samples that the longest stretch of one clock must have.
_LEAST_KEPT = 0.5


@dataclass(frozen=True)
class DataChecks:
    """
    Hold what was found in a recording.

    ``samples`` were recorded, ``used`` of them are fitted, over ``duration_s``. ``period_s`` is
    the median step between stamps, ``jitter_s`` the median distance of a step from it. ``gaps``
    counts steps of more than 1.5 periods, ``longest_step_s`` is the longest. Left out are
    ``repeated_stamps``, ``backward_stamps`` (samples of another pass; samples that only came late
    are sorted, and not counted) and ``incomplete_samples`` (a position is missing).

    ``refused`` says of a joint with effort why it is not fitted.
    """

    samples: int
    used: int
    duration_s: float
    period_s: float
    jitter_s: float
    gaps: int
    longest_step_s: float
    repeated_stamps: int
    backward_stamps: int
    incomplete_samples: int
    joints: Mapping[str, JointChecks] = field(default_factory=dict)
    findings: tuple[DataFinding, ...] = ()

    @property
    def refused(self) -> dict[str, str]:
        """Return by joint why it is not fitted, without a full stop."""
        return {f.joint: f.sentence for f in self.findings if f.level == REFUSED}

    @property
    def resting(self) -> dict[str, str]:
        """Return by joint that it rests, so that it is left out, without a full stop."""
        return {f.joint: f.sentence for f in self.findings if f.check == 'rest'}

    @property
    def warnings(self) -> dict[str, str]:
        """Return by joint what is wrong with data that are used all the same."""
        return {f.joint: f.sentence for f in self.findings if f.level == WARNING}

    @property
    def not_fitted(self) -> dict[str, str]:
        """Return by joint why it is not fitted though it may report effort."""
        return {**self.refused, **self.resting}

    def told(self, *findings: DataFinding) -> DataChecks:
        """Return the same with more that was found."""
        return replace(self, findings=(*self.findings, *findings))

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return what a person should be told: everything that is more than a note."""
        return tuple(f.sentence for f in self.findings if f.level != NOTE)


def check_data(
    log: JointLog, robot: Robot, recovery: str = '', free_rotors: Collection[str] = ()
) -> tuple[JointLog, DataChecks]:
    """
    Return the part of a recording that can be fitted, and what is wrong with all of it.

    The log returned has stamps that rise, a position of every joint in every sample, and NaN for
    effort that saturates and for all effort of a joint that is refused: it is then not fitted, and
    ``refused`` says why. A run without position is left out as if it had never been received.

    :param robot: its limits and gravity are what the data are held against.
    :param recovery: what a cut-off bag says of itself, empty for a whole one.
    :param free_rotors: joints whose armature is not known.
    :raises DataError: if no joint can be fitted; one sentence: what, where, and what to do.
    """
    # A bag is unwrapped where it is read; a log may come from elsewhere.
    log = unwrapped(log.select(robot.names))
    log.require_effort()
    findings = [DataFinding('cut_off', '*', LEFT_OUT, recovery)] if recovery else []
    findings += [DataFinding('held_joints', '*', LEFT_OUT, said) for said in robot.remarks]
    samples = len(log)
    log, backward = _one_pass(log, findings)
    log, repeated = _without_repeats(log, findings)
    log, incomplete = _whole_samples(log, findings)
    log, held = with_new_values(_with_effort(log, findings))
    findings += [DataFinding(check, '*', LEFT_OUT, what) for check, what in held.items()]
    log = _without_repeated_samples(log, findings)
    log, off = without_glitches(log)
    findings += [DataFinding('glitch', name, LEFT_OUT, what) for name, what in off.items()]
    steps = np.diff(log.time)
    duration = float(log.time[-1])
    if len(steps) == 0 or duration < SHORTEST_S:
        raise DataError(
            f'the recording has {len(log)} usable samples over {duration:.3g} s: friction needs '
            f'at least {SHORTEST_S:g} s of motion at several speeds in both directions; record a '
            'trajectory (sosml trajectory lists them)'
        )
    period = float(np.median(steps))
    if slow := too_slow(period):
        raise DataError(slow)
    log, uneven = with_even_stamps(log)
    findings += [DataFinding(EVEN, '*', NOTE, uneven)] if uneven else []
    joints = {}
    v, tau, slopes = log.v.copy(), log.tau.copy(), Slopes.of(log)
    if swapped := swapped_joints(log, robot, slopes):
        raise DataError(swapped)
    for i, name in enumerate(robot.names):
        joints[name], v[:, i], tau[:, i], own = check_joint(
            log, robot, i, slopes, name in free_rotors
        )
        findings += own
    findings += check_stamps(replace(log, tau=tau), period)
    long = steps[steps > _GAP_PERIODS * period]
    if len(long):
        what = (
            f'{len(long)} steps are longer than {_GAP_PERIODS:g} periods of {1e3 * period:.3g} '
            f'ms, {float(np.sum(long)):.3g} s together, the longest {steps.max():.3g} s'
        )
        level = NOTE
        if float(np.sum(long)) > _MOST_GAPS * duration:
            level = WARNING
            what += ': what the joints did in them is not known, see whether the driver was busy'
        findings.append(DataFinding('gaps', '*', level, what))
    checks = DataChecks(
        samples=samples,
        used=len(log),
        duration_s=duration,
        period_s=period,
        jitter_s=float(np.median(np.abs(steps - period))),
        gaps=len(long),
        longest_step_s=float(steps.max()),
        repeated_stamps=repeated,
        backward_stamps=backward,
        incomplete_samples=incomplete,
        joints=joints,
        findings=tuple(findings),
    )
    if np.isnan(tau).all():
        raise DataError('; '.join([*checks.refused.values(), *checks.resting.values()]))
    return replace(log, v=v, tau=tau), checks


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
    """Return the log without samples that repeat the stamp of the one before, and their count."""
    again = np.append(False, np.diff(log.t_ns) == 0)
    count = int(again.sum())
    if not count:
        return log, 0
    at = np.flatnonzero(again)
    other = int(np.sum((log.q[at] != log.q[at - 1]).any(axis=1)))
    what = f'{count} of {len(log)} samples repeat the stamp of the one before'
    if other > _MOST_REPEATED * len(log):
        raise DataError(
            f'{what}, {other} of them with another position, so the stamps are not the times of '
            'measurement: let the driver stamp each sample when it is measured'
        )
    findings.append(DataFinding('repeated_stamps', '*', LEFT_OUT, f'{what} and are left out'))
    return log.rows(~again), count


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
    runs = np.split(whole, np.flatnonzero(np.diff(whole)) + 1)
    has_effort = np.asarray(np.isfinite(log.tau).any(axis=1))
    if has_effort.any() and not has_effort[whole].any():
        raise DataError(
            f'no sample has both a position and an effort ({int(whole.sum())} and '
            f'{int(has_effort.sum())} of {len(log)} have one): they come from two topics with '
            'stamps of their own; take both from one, or interpolate one to the stamps of the '
            'other'
        )
    lacking = ', '.join(name for name, times in counts.items() if times < len(log))
    what = (
        f'{count} of {len(log)} samples lack a position of {lacking} and are left out, up to '
        f'{max(len(run) for run in runs if not run[0])} in a row'
    )
    findings.append(DataFinding('incomplete_samples', '*', LEFT_OUT, what))
    return log.rows(whole), count


def _with_effort(log: JointLog, findings: list[DataFinding]) -> JointLog:
    """
    Return the samples with an effort of any joint, where one comes every now and then.

    A drive may report its current at a lower rate than its position: the samples between are as
    if they had never been received. Longer without effort than a speed is told over is a hole of
    effort alone.
    """
    known = np.isfinite(log.tau).any(axis=1)
    heard = log.time[known]
    next_one = np.searchsorted(heard, log.time)
    inside = (next_one > 0) & (next_one < len(heard))
    between = ~known & inside
    between[between] = np.diff(heard)[next_one[between] - 1] <= WINDOW_S
    count = int(between.sum())
    if not count:
        return log
    what = f'{count} of {len(log)} samples lack every effort between others, and are left out'
    findings.append(DataFinding('without_effort', '*', LEFT_OUT, what))
    return log.rows(~between)
