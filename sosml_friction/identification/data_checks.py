# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a recording, before anything is fitted to it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.identification.data_finding import (
    LEFT_OUT,
    NOTE,
    REFUSED,
    WARNING,
    DataFinding,
)
from sosml_friction.identification.joint_checks import JointChecks, check_each_joint
from sosml_friction.identification.joint_relations import Slopes
from sosml_friction.identification.stamp_checks import check_stamps
from sosml_friction.identification.swapped_joints import swapped_joints
from sosml_friction.model.robot import Robot

#: Steps longer than this many periods count as a gap.
_GAP_PERIODS = 1.5
#: Share of the recording in gaps beyond which it is more than a note. Chosen, no measurement: a
#: driver on a machine with a load of 6 had a third, and the elbow's viscous friction was 16 % off.
_MOST_GAPS = 0.2


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
    ``refused`` says why.

    :param robot: its limits and gravity are what the data are held against.
    :param recovery: what a cut-off bag says of itself, empty for a whole one.
    :param free_rotors: joints whose armature is not known.
    :raises DataError: if no joint can be fitted; one sentence: what, where, and what to do.
    """
    log = log.select(robot.names)
    log.require_effort()
    findings = [DataFinding('cut_off', '*', LEFT_OUT, recovery)] if recovery else []
    findings += [DataFinding('held_joints', '*', LEFT_OUT, said) for said in robot.remarks]
    samples, clean = len(log), CleanSamples.of(log)
    log, period, steps = clean.log, clean.period_s, clean.steps
    duration = float(np.sum(steps))
    findings += clean.findings
    joints = {}
    v, tau, slopes = log.v.copy(), log.tau.copy(), Slopes.of(log)
    if swapped := swapped_joints(log, robot, slopes):
        raise DataError(swapped)
    for i, each in enumerate(check_each_joint(log, robot, slopes, free_rotors)):
        joints[robot.names[i]], v[:, i], tau[:, i], own = each
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
        repeated_stamps=clean.repeated_stamps,
        backward_stamps=clean.backward_stamps,
        incomplete_samples=clean.incomplete_samples,
        joints=joints,
        findings=tuple(findings),
    )
    if np.isnan(tau).all():
        raise DataError('; '.join([*checks.refused.values(), *checks.resting.values()]))
    return replace(log, v=v, tau=tau), checks
