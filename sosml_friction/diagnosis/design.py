# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The second step of a diagnosis: rows of a regression, and the columns they are fitted by."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.data_checks import (
    Check,
    rest_left_out,
    velocity_lag,
    without_bad,
)
from sosml_friction.diagnosis.recordings import Recordings, RecordingsError
from sosml_friction.diagnosis.tone_above_band import tone_above_band
from sosml_friction.diagnosis.trust import trusting
from sosml_friction.diagnosis.untold_inertia import UNTOLD, untold_inertia, untold_joints
from sosml_friction.diagnosis.whole_effort import whole_effort
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.effort_scale import LARGEST
from sosml_friction.model.terms.kinds.term import Term
from sosml_friction.regression.known_effort import with_all_known, with_known
from sosml_friction.regression.placed import Placed
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, prepare
from sosml_friction.regression.whitened import WhitenedRegression

Step = Callable[[str], None]


@dataclass(frozen=True)
class Design:
    """
    Hold the regression of recordings on a model and a library of terms.

    ``recordings``: without what is bad of them. ``signals``: the stretches as they were recorded;
    those of ``laboratory`` may be without rests. ``checks``: those of the recordings, and of what
    the regression shows of them. ``others``: the signals of a recording that is left out, in the
    same band; None for none. ``of_the_model``: inertia is the model's even where the effort
    contradicts it.
    """

    recordings: Recordings
    signals: tuple[Signals, ...]
    library: Mapping[str, Term]
    laboratory: WhitenedRegression
    checks: tuple[Check, ...]
    others: tuple[Signals, ...] | None = None
    of_the_model: bool = False

    @classmethod
    def make(
        cls,
        recordings: Recordings,
        model: RobotModelFile,
        robot: Robot,
        holdout: JointLog | None,
        library: Mapping[str, Term],
        settings: DiagnosisSettings,
        step: Step,
    ) -> 'Design':
        """
        Make the regression of recordings that are of use.

        :raises DataError: if there is too little of them.
        :raises ConfigurationError: if ``holdout`` is of no use.
        """
        recordings, signals = _seen(recordings, model, robot, settings)
        told = _told(signals)
        own = [velocity_lag(recordings.logs[0], signals[0], i) for i in told]
        own += [tone_above_band(signals, i) for i in told]
        others = None
        if holdout is not None:
            holdout = without_bad(holdout, recordings.checks)
            others = _prepared(holdout, model, signals[0], settings)
        try:
            laboratory = _regression(signals, library, settings, step)
        except DataError as error:
            raise RecordingsError(str(error), recordings.checks) from error
        checks = (*recordings.checks, *filter(None, own))
        result = cls(recordings, tuple(signals), library, laboratory, checks)
        if untold := untold_inertia(result.laboratory):
            result = result.with_free_inertia(untold, step)
        if result.laboratory.without_rests:
            lab = result.laboratory
            left_out = (1.0 - lab.known / len(lab.y)).tolist()
            rest = rest_left_out({robot.names[i]: left_out[i] for i in told})
            result = replace(result, checks=(*result.checks, rest))
        if others is not None:
            result = replace(result, others=tuple(result.laboratory.seen_alike(others)))
        return result

    @property
    def untold(self) -> tuple[str, ...]:
        """Return the joints whose inertia is fitted freely, as the effort contradicts it."""
        return untold_joints(self.checks)

    @property
    def untried(self) -> dict[str, str]:
        """Return what recordings need that the terms of the library lack in these, by term."""
        tried = {candidate.effect.identifier for candidate in self.laboratory.candidates}
        return {
            name: term.needs
            for name, term in self.library.items()
            if term.needs and name not in tried
        }

    def with_free_inertia(self, untold: Mapping[str, Check], step: Step) -> 'Design':
        """Return it with the inertia of these joints fitted freely, which is told."""
        own = self.laboratory.settings
        settings = replace(own, free_inertia=(*own.free_inertia, *untold))
        laboratory = _regression(self.signals, self.library, settings, step)
        return replace(self, laboratory=laboratory, checks=(*self.checks, *untold.values()))

    def with_the_models_inertia(self, step: Step) -> 'Design':
        """Return it with the inertia of the model where the effort contradicts it, too."""
        own, untold = self.laboratory.settings, self.untold
        free = tuple(name for name in own.free_inertia if name not in untold)
        laboratory = _regression(self.signals, self.library, replace(own, free_inertia=free), step)
        checks = tuple(check for check in self.checks if check.kind != UNTOLD)
        return replace(self, laboratory=laboratory, checks=checks, of_the_model=True)

    def untold_inertia(self, beside: Sequence[Placed]) -> dict[str, Check]:
        """Return joints whose inertia the model does not tell beside causes, and is not free."""
        if self.of_the_model:
            return {}
        free = self.laboratory.settings.free_inertia
        untold = untold_inertia(self.laboratory, beside)
        return {name: check for name, check in untold.items() if name not in free}


def _seen(
    recordings: Recordings, model: RobotModelFile, robot: Robot, settings: DiagnosisSettings
) -> tuple[Recordings, list[Signals]]:
    """
    Return recordings without what their signals show to be bad, and these with all that is known.

    :raises DataError: if there is too little of them, or nothing that is of use.
    """
    signals = with_all_known(prepare(recordings.logs, model, robot, settings), model, settings)
    # Of a model that is itself no surer than that nothing is told.
    if any(share >= LARGEST for share in settings.trust.values()):
        return recordings, signals
    found = (whole_effort(signals, i) for i in _told(signals))
    whole = [check for check in found if check is not None]
    checked = recordings.with_checks(whole)
    if not any(check.severity == 'bad' for check in whole):
        return checked, signals
    checked.refuse_bad()
    return _seen(checked, model, robot, settings)


def _told(signals: Sequence[Signals]) -> list[int]:
    """Return the joints whose effort is known."""
    return [i for i in range(signals[0].robot.n) if i not in signals[0].silent]


def _regression(
    signals: Sequence[Signals],
    library: Mapping[str, Term],
    settings: DiagnosisSettings,
    step: Step,
) -> WhitenedRegression:
    """Return the regression with what is trusted."""
    return trusting(WhitenedRegression.make(signals, dict(library), settings, step))


def _prepared(
    holdout: JointLog, model: RobotModelFile, first: Signals, settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return the signals of the recording the gain is measured on, seen as ``first`` is.

    :raises ConfigurationError: if it is of no use.
    """
    band = replace(settings, band=first.band.cutoff)
    try:
        recordings = Recordings.checked([holdout], first.robot)
        recordings.refuse_bad()
        logs = recordings.in_means().logs
        signals = prepare(logs, model, first.robot, band, first.scales)
        return with_known([replace(s, untold=first.untold) for s in signals], model, [first])
    except DataError as error:
        raise ConfigurationError(f'the recording left out (holdout): {error}') from None
