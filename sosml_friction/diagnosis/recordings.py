# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The first step of a diagnosis: recordings, and what is to be said of them as data."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.bags.block_means import block_means, block_sentence
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.data_checks import Check, check_joints, check_log, without_bad
from sosml_friction.exceptions import DataError
from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.identification.late_effort import Late, undone
from sosml_friction.model.robot import Robot


class RecordingsError(DataError):
    """Recordings of which nothing is of use, with all ``checks`` of them."""

    def __init__(self, sentence: str, checks: tuple[Check, ...]) -> None:
        super().__init__(sentence)
        self.checks = checks


@dataclass(frozen=True)
class Recordings:
    """Hold recordings of a robot's joints without what is bad of them, and their checks."""

    logs: tuple[JointLog, ...]
    checks: tuple[Check, ...]

    @classmethod
    def checked(cls, logs: Sequence[JointLog], robot: Robot) -> 'Recordings':
        """
        Return the recordings of the robot's joints, continuous and checked.

        :raises DataError: if a joint is not in a recording.
        """
        good, checks = [], []
        for number, whole in enumerate(logs, 1):
            log = whole.select(robot.names)
            try:
                clean = CleanSamples.of(log)
            except DataError as error:
                which = f'recording {number}: ' if len(logs) > 1 else ''
                own = [Check('samples', 'bad', '*', f'{which}{error}')]
            else:
                log = clean.log
                own = [*check_log(clean), *check_joints(log, robot)]
            good.append(without_bad(log, own))
            checks.append(own)
        return cls(tuple(good), tuple(check for own in checks for check in own))

    def refuse_bad(self) -> None:
        """
        Refuse data that are of no use: all of them, or those of each joint.

        :raises RecordingsError: with the sentences of the checks that found them bad.
        """
        bad = [check for check in self.checks if check.severity == 'bad']
        for check in bad:
            if check.joint == '*':
                raise RecordingsError(check.sentence, self.checks)
        if all(np.isnan(log.tau).all() for log in self.logs):
            sentences = dict.fromkeys(check.sentence for check in bad)
            raise RecordingsError('; '.join(sentences), self.checks)

    def in_means(self) -> 'Recordings':
        """Return them with long ones as means of blocks, which is told."""
        means = [block_means(log) for log in self.logs]
        told = [
            Check('means', 'note', '*', block_sentence(log, together))
            for log, together in means
            if together > 1
        ]
        return replace(self, logs=tuple(log for log, _ in means), checks=(*self.checks, *told))

    def with_checks(self, checks: Sequence[Check]) -> 'Recordings':
        """Return them without what other checks found bad, which say it anew of a joint."""
        logs = tuple(without_bad(log, checks) for log in self.logs)
        anew = {(check.kind, check.joint) for check in checks}
        others = (own for own in self.checks if (own.kind, own.joint) not in anew)
        return replace(self, logs=logs, checks=(*others, *checks))

    def undone(self, late: Late, checks: Sequence[Check]) -> 'Recordings':
        """Return them with effort taken sooner by what it is late, which ``checks`` say."""
        logs = tuple(undone(late, log) for log in self.logs)
        return replace(self, logs=logs, checks=(*self.checks, *checks))
