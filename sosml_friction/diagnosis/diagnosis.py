# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From recordings and a model to a verdict."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.block_means import block_means, block_sentence
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.wrap import unwrapped
from sosml_friction.diagnosis.data_checks import (
    REST_LEFT_OUT,
    Check,
    check_joints,
    check_log,
    velocity_lag,
    without_bad,
)
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.confusability import Confusability, confusability
from sosml_friction.diagnosis.decision.data_causes import FAULTS, data_causes
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.forward_gain import HORIZON_S, ForwardGain
from sosml_friction.diagnosis.decision.forward_gate import forward_gate, was_taken_back
from sosml_friction.diagnosis.decision.model_causes import estimated, model_causes
from sosml_friction.diagnosis.decision.report_slopes import report_slopes
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.selector import Selector
from sosml_friction.diagnosis.decision.shown_gate import shown_gate
from sosml_friction.diagnosis.decision.verdict import verdict_of
from sosml_friction.diagnosis.extended_model.carry_over import cause_gains, what_carries_over
from sosml_friction.diagnosis.extended_model.effort_error import (
    another_recording,
    folds_left_out,
    stages,
)
from sosml_friction.diagnosis.extended_model.gain import Gain, make_gain
from sosml_friction.diagnosis.extended_model.simulator_gain import SimulatorGain
from sosml_friction.diagnosis.library import library_hash, make_library
from sosml_friction.diagnosis.next_experiment.experiment import recommend
from sosml_friction.diagnosis.next_experiment.recommendation import Recommendation
from sosml_friction.diagnosis.trust import check_trust, trusting
from sosml_friction.diagnosis.unstated_friction import unstated_friction
from sosml_friction.diagnosis.untold_inertia import untold_inertia
from sosml_friction.diagnosis.wording import sentence_of
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.terms.kinds.transmission_term import TransmissionTerm
from sosml_friction.regression.carried_load import with_carried_load
from sosml_friction.regression.known_effort import with_known
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, prepare
from sosml_friction.regression.whitened import WhitenedRegression


@dataclass(frozen=True)
class Diagnosis:
    """
    Hold a verdict and what it rests on.

    ``stages``: relative effort error [%] on folds left out, refitted and after each cause.
    ``refit``, ``refit_errors``: deviations of nominal parameters, and their standard errors;
    ``tolerated``: those of them that are terms of the model as causes are.
    ``ranking``: the first round's candidates, best first; ``rejected``: the best that failed a
    gate, and which; ``laboratory`` and ``selection`` are what the report draws from, None where
    the data were too bad. ``confusability``: which candidates look alike along this motion.
    ``simulator``: the gain in the simulator whose model it is, where that was measured.
    """

    verdict: str
    causes: tuple[Cause, ...]
    checks: tuple[Check, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    library_hash: str
    sentence: str
    gain: Gain | None = None
    recommendation: Recommendation | None = None
    ranking: tuple[dict[str, Any], ...] = ()
    rejected: dict[str, Any] | None = None
    tolerated: tuple[Cause, ...] = ()
    refit: Mapping[str, float] = field(default_factory=dict)
    refit_errors: Mapping[str, float] = field(default_factory=dict)
    structure: Mapping[str, Any] = field(default_factory=dict)
    stages: tuple[dict[str, Any], ...] = ()
    band_hz: float = float('nan')
    laboratory: WhitenedRegression | None = None
    selection: Selection | None = None
    confusability: Confusability | None = None
    residual_before: FloatArray | None = None
    residual_after: FloatArray | None = None
    simulator: SimulatorGain | None = None

    @property
    def terms(self) -> tuple[Cause, ...]:
        """Return what the extended model may have: the causes, and what is tolerated."""
        return (*self.causes, *self.tolerated)


def diagnose(
    logs: Sequence[JointLog],
    model: RobotModelFile,
    holdout: JointLog | None = None,
    settings: DiagnosisSettings | None = None,
    without: tuple[str, ...] = (),
    step: Callable[[str], None] = lambda text: None,
    keep_all: bool = False,
) -> Diagnosis:
    """
    Say what a model gets wrong about recordings, and why.

    :param logs: recordings; their joints include the model's.
    :param holdout: another recording, on which the gain is measured; None for folds of ``logs``.
    :param without: effects not to look for.
    :param step: called with what is being done.
    :param keep_all: keep causes in the extended model that ``holdout`` contradicts.
    :raises DataError: if a joint of the model is not in a recording.
    :raises ConfigurationError: if ``holdout`` is of no use, or ``settings.trust`` says nothing.
    """
    settings = settings or DiagnosisSettings()
    robot = model.make_robot()
    logs = [unwrapped(log.select(robot.names)) for log in logs]
    library = make_library(without)
    check_trust(settings.trust)
    # A term of the model that cannot be used is refused before anything is computed.
    known_terms(model)
    step('checking the data')
    by_log = [check_log(log) + check_joints(log, robot) for log in logs]
    checks = [check for own in by_log for check in own]
    logs = [without_bad(log, own) for log, own in zip(logs, by_log, strict=True)]
    try:
        _refuse_bad(checks, logs)
        for k, log in enumerate(logs):
            logs[k], together = block_means(log)
            if together > 1:
                checks.append(Check('means', 'note', '*', block_sentence(logs[k], together)))
        signals = with_known(prepare(logs, model, robot, settings), model)
        told = [i for i in range(robot.n) if i not in signals[0].silent]
        lags = [velocity_lag(logs[0], signals[0], i) for i in told]
        checks += [lag for lag in lags if lag is not None]
        others = None if holdout is None else _prepared(holdout, model, signals[0], settings)
        laboratory = trusting(WhitenedRegression.make(signals, library, settings, step))
        if untold := untold_inertia(laboratory):
            checks += untold.values()
            settings = replace(settings, free_inertia=(*settings.free_inertia, *untold))
            laboratory = trusting(WhitenedRegression.make(signals, library, settings, step))
        if laboratory.without_rests:
            checks.append(REST_LEFT_OUT)
        others = None if others is None else laboratory.seen_alike(others)
    except DataError as error:
        return Diagnosis(
            verdict='bad_data',
            causes=(),
            checks=tuple(checks),
            names=robot.names,
            units=robot.effort_units,
            library_hash=library_hash(library),
            sentence=str(error),
        )
    selector = Selector(laboratory, step)
    selection = selector.run()
    stood_out = [*selection.accepted, *filter(None, (selection.rejected, selection.masked))]
    if any(isinstance(cause.effect, TransmissionTerm) for cause in stood_out):
        # A gear that gives moves the nominal body, whose inertia the other causes may have hidden.
        beside = [cause.placed for cause in selection.accepted]
        untold = untold_inertia(laboratory, beside)
        if new := [name for name in untold if name not in settings.free_inertia]:
            checks += [untold[name] for name in new]
            settings = replace(settings, free_inertia=(*settings.free_inertia, *new))
            laboratory = trusting(WhitenedRegression.make(signals, library, settings, step))
            selector = Selector(laboratory, step)
            selection = selector.run()
    shown_gate(selector, selection)
    laboratory = selection.laboratory or laboratory
    if others is not None and np.any(laboratory.signals[0].more_load):
        count = len(laboratory.nominal.bound)
        placed = [finding.placed for finding in selection.accepted]
        others = with_carried_load(others, placed, selection.after.x, count)
    step('measuring the gain')
    folds = folds_left_out(laboratory)
    held = folds if others is None else another_recording(laboratory, others)
    forward = judge = ForwardGain(laboratory, model, others)
    if others is not None and what_carries_over(laboratory, selection, held)[0] is not selection:
        # What another recording contradicts may be right in these: it is judged by their folds.
        judge = ForwardGain(laboratory, model)
    before, after = forward_gate(judge, laboratory, selection)
    if was_taken_back(selection.rejected):
        # What is left is more without it, and may have a structure.
        selection.judge_remainder(laboratory)
    kept, own_gains = selection, cause_gains(laboratory, selection, held)
    if others is not None:
        carried, own_gains = what_carries_over(laboratory, selection, held)
        kept = selection if keep_all else carried
    if judge is not forward:
        before = forward.squares((), selection.before.x, selection.before.fold_x)
        after = forward.squares(kept.accepted, kept.after.x, kept.after.fold_x)
    gain = make_gain(
        held.error(selection.before, ()),
        held.error(kept.after, kept.accepted),
        held.measured,
        before,
        after,
        HORIZON_S,
        held.on,
    )
    causes = data_causes(checks, laboratory, without, selection)
    found = model_causes(laboratory, selection, kept, own_gains)
    causes += [cause for cause in found if not cause.tolerated]
    tolerated = tuple(cause for cause in found if cause.tolerated)
    # What the model lacks is told before what the data lack.
    causes.sort(key=lambda cause: cause.effect in FAULTS)
    verdict = verdict_of(causes, selection)
    recommendation = None
    if verdict == 'ambiguous':
        step('looking for an experiment that separates the rivals')
        recommendation = recommend(laboratory, selection, causes)
    nominal = laboratory.nominal.names
    slopes = report_slopes(laboratory, kept.accepted, kept.after.x)
    errors = estimated(laboratory, kept).errors / slopes
    rejected = selection.rejected
    return Diagnosis(
        verdict=verdict,
        causes=tuple(causes),
        checks=tuple(checks),
        names=robot.names,
        units=robot.effort_units,
        library_hash=library_hash(library),
        sentence=sentence_of(
            verdict,
            causes,
            gain,
            selection,
            robot.names,
            robot.effort_units,
            tolerated,
            unstated_friction(laboratory, kept.after.x / slopes, errors),
        ),
        gain=gain,
        recommendation=recommendation,
        ranking=tuple(_entry(finding, robot.names) for finding in selection.ranking),
        rejected=None if rejected is None else _entry(rejected, robot.names),
        tolerated=tolerated,
        # The nominal's deviations come first, the amplitudes of the causes after them.
        refit=dict(zip(nominal, (kept.after.x / slopes).tolist(), strict=False)),
        refit_errors=dict(zip(nominal, errors.tolist(), strict=False)),
        structure=_structure(laboratory, selection),
        stages=tuple(stages(folds, laboratory, selection)),
        band_hz=signals[0].band.cutoff,
        laboratory=laboratory,
        selection=selection,
        confusability=confusability(laboratory, selection.accepted),
        # The pictures show the recordings that were diagnosed, not the one that was left out.
        residual_before=folds.error(selection.before, ()),
        residual_after=folds.error(selection.after, selection.accepted),
    )


def _refuse_bad(checks: Sequence[Check], logs: Sequence[JointLog]) -> None:
    """
    Refuse data that are of no use: all of them, or those of each joint.

    :raises DataError: with the sentences of the checks that found them bad.
    """
    bad = [check for check in checks if check.severity == 'bad']
    for check in bad:
        if check.joint == '*':
            raise DataError(check.sentence)
    if all(np.isnan(log.tau).all() for log in logs):
        raise DataError('; '.join(dict.fromkeys(check.sentence for check in bad)))


def _prepared(
    holdout: JointLog, model: RobotModelFile, first: Signals, settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return the signals of the recording the gain is measured on, seen as ``first`` is.

    :raises ConfigurationError: if it is of no use.
    """
    log = unwrapped(holdout.select(first.robot.names))
    band = replace(settings, band=first.band.cutoff)
    try:
        checks = check_log(log) + check_joints(log, first.robot)
        log = without_bad(log, checks)
        _refuse_bad(checks, [log])
        log = block_means(log)[0]
        return with_known(prepare([log], model, first.robot, band, first.scales), model)
    except DataError as error:
        raise ConfigurationError(f'the recording left out (holdout): {error}') from None


def _entry(finding: Finding, names: tuple[str, ...]) -> dict[str, Any]:
    """Return a candidate as in ``ranking`` of diagnosis.json."""
    effect, joint = finding.reported(names)
    return {
        'effect': effect,
        'joint': joint,
        'delta_bic': finding.delta_bic,
        'cv_gain': finding.score.cv_gain,
        'cv_gain_se': finding.score.cv_se,
        'floor': finding.floor,
        'objection': finding.objection,
        'failed': list(finding.failed),
    }


def _structure(laboratory: WhitenedRegression, selection: Selection) -> dict[str, Any]:
    """Return ``structure`` of diagnosis.json: what is left that is not noise."""
    names, left = laboratory.robot.names, selection.remainder
    largest = [left.largest(i) for i in range(len(names))]
    rows = laboratory.known
    return {
        'cv_gain': [None if x is None else float(x.energy / rows[x.joint]) for x in largest],
        'floor': [None if x is None else float(x.floor / rows[x.joint]) for x in largest],
        'axes': [
            {
                'axis': x.axis,
                'joint': names[x.joint],
                'energy': float(x.energy),
                'floor': float(x.floor),
                'share': float(x.share),
                'hertz': x.hertz or None,
                'unknown': x.significant,
            }
            for x in left.found
        ],
    }
