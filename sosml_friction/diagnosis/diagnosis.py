# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From recordings and a model to a verdict."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.data_checks import Check
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.confusability import Confusability, confusability
from sosml_friction.diagnosis.decision.data_causes import data_causes
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.model_causes import estimated, model_causes
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.selector import nominal_friction
from sosml_friction.diagnosis.decision.verdict import verdict_of
from sosml_friction.diagnosis.design import Design, Step
from sosml_friction.diagnosis.extended_model.carry_over import Key
from sosml_friction.diagnosis.extended_model.effort_error import stages
from sosml_friction.diagnosis.extended_model.gain import Gain
from sosml_friction.diagnosis.extended_model.simulator_gain import SimulatorGain
from sosml_friction.diagnosis.judgement import Judgement
from sosml_friction.diagnosis.large_delay import checks_of, is_large, large_delay
from sosml_friction.diagnosis.library import library_hash, make_library
from sosml_friction.diagnosis.next_experiment.experiment import recommend
from sosml_friction.diagnosis.next_experiment.recommendation import Recommendation
from sosml_friction.diagnosis.recordings import Recordings, RecordingsError
from sosml_friction.diagnosis.search import Search
from sosml_friction.diagnosis.trust import check_trust
from sosml_friction.diagnosis.unstated_friction import unstated_friction
from sosml_friction.diagnosis.untold_inertia import untold_joints
from sosml_friction.diagnosis.wording import sentence_of
from sosml_friction.exceptions import DataError
from sosml_friction.identification.late_effort import Late, undone
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.terms.effort_delay import EffortDelay
from sosml_friction.model.terms.kinds.transmission_term import TransmissionTerm
from sosml_friction.regression.settings import DiagnosisSettings
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

    Each step takes the result of the one before, which nothing changes afterwards: recordings,
    design, search, judgement, conclusion.

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
    recordings = Recordings.checked(logs, robot)
    library = make_library(without)
    check_trust(settings.trust)
    # A term of the model that cannot be used is refused before anything is computed.
    known_terms(model)
    step('checking the data')
    try:
        recordings.refuse_bad()
        recordings = recordings.in_means()
        design = Design.make(recordings, model, robot, holdout, library, settings, step)
    except DataError as error:
        return Diagnosis(
            verdict='bad_data',
            causes=(),
            checks=error.checks if isinstance(error, RecordingsError) else recordings.checks,
            names=robot.names,
            units=robot.effort_units,
            library_hash=library_hash(library),
            sentence=str(error),
        )
    found = _searched(design, model, keep_all, without, step)
    unknown = found.verdict == 'unknown_structure'
    if not unknown and not is_large(found.causes, design):
        return found
    # What leaves something unknown beside it may only look like that.
    late = large_delay(design, design.recordings, model, step)
    if late:
        recordings = design.recordings.undone(late, checks_of(late, robot.names))
        library = {name: term for name, term in library.items() if name != EffortDelay.identifier}
        holdout = holdout and undone(late, holdout)
        try:
            design = Design.make(recordings, model, robot, holdout, library, settings, step)
        except DataError:
            return found
        beside = _searched(design, model, keep_all, without, step)
        known = beside.verdict != 'unknown_structure'
        return beside if known or later_leaves_less(late, beside, found) else found
    if not unknown:
        return found
    laws = nominal_friction(design.laboratory)
    # The law of one joint was asked for.
    if len({joint for _, joint in laws}) < 2:
        return found
    beside = _searched(design, model, keep_all, without, step, all_friction=True)
    named = beside.selection.accepted if beside.selection is not None else ()
    several = len({finding.joint for finding in named if finding.key in laws}) > 1
    return beside if several and beside.verdict != 'unknown_structure' else found


def _searched(
    design: Design,
    model: RobotModelFile,
    keep_all: bool,
    without: tuple[str, ...],
    step: Step,
    all_friction: bool = False,
) -> Diagnosis:
    """Return what is found in a design; an inertia that is contradicted may be a gear's doing."""
    found = _found(design, model, keep_all, without, step, all_friction)
    untold = [found.names.index(name) for name in untold_joints(found.checks)]
    if found.verdict != 'unknown_structure' or not untold:
        return found
    known = design.with_the_models_inertia(step)
    beside = _found(known, model, keep_all, without, step, all_friction)
    return beside if _gear_explains_more(beside, found, untold) else found


def later_leaves_less(late: Late, beside: Diagnosis, found: Diagnosis) -> bool:
    """
    Tell whether effort that is late leaves less once it is taken sooner.

    One that is early is what a loop makes of a hum, or of noise, too.
    """
    if beside.gain is None or found.gain is None or any(x.delay_s < 0.0 for x in late.values()):
        return False
    after, before = beside.gain.relative_after, found.gain.relative_after
    known = np.isfinite(after) & np.isfinite(before)
    return bool(np.sum(after[known] ** 2) < np.sum(before[known] ** 2))


def _gear_explains_more(beside: Diagnosis, found: Diagnosis, untold: Sequence[int]) -> bool:
    """Tell whether a gear that gives leaves less of these joints than an inertia that is free."""
    if beside.verdict == 'unknown_structure' or beside.selection is None:
        return False
    gears = {f.joint for f in beside.selection.accepted if isinstance(f.effect, TransmissionTerm)}
    if beside.gain is None or found.gain is None or not gears.issuperset(untold):
        return False
    left, before = beside.gain.relative_after, found.gain.relative_after
    return all(left[i] < before[i] for i in untold)


def _found(
    design: Design,
    model: RobotModelFile,
    keep_all: bool,
    without: tuple[str, ...],
    step: Step,
    all_friction: bool,
) -> Diagnosis:
    """Return the causes that search and judgement leave, and the verdict."""
    search = Search.run(design, step, all_friction)
    step('measuring the gain')
    judged = Judgement.of(search, model, keep_all)
    found, refused = (search, judged), set[Key]()
    while taken := _keys(search.selection) - _keys(judged.selection) - refused:
        # What a cause stood for that data left out contradict may be another one.
        refused |= taken
        search = search.further(judged.selection.accepted, refused, step)
        judged = Judgement.of(search, model, keep_all)
        if _keys(judged.selection) - _keys(found[1].selection):
            found = search, judged
    return _concluded(*found, without, step)


def _keys(selection: Selection) -> set[Key]:
    """Return effect and joint of what was accepted."""
    return {finding.key for finding in selection.accepted}


def _concluded(
    search: Search, judged: Judgement, without: tuple[str, ...], step: Callable[[str], None]
) -> Diagnosis:
    """Return the verdict and what it rests on: the last step."""
    laboratory, robot = search.laboratory, search.laboratory.robot
    selection, kept = judged.selection, judged.kept
    checks = search.design.checks
    found = model_causes(laboratory, selection, kept, judged.gains)
    tolerated = tuple(cause for cause in found if cause.tolerated)
    shown = data_causes(checks, laboratory, without, selection)
    # The impacts of a gear that gives are no other gap than the one that the regression has.
    causes = [cause for cause in shown if not any(each.stands_for(cause) for each in found)]
    causes += [cause for cause in found if not cause.tolerated]
    # What the model lacks is told before what the data lack.
    causes.sort(key=lambda cause: cause.is_fault)
    verdict = verdict_of(causes, selection, search.design.untold)
    recommendation = None
    if verdict == 'ambiguous':
        step('looking for an experiment that separates the rivals')
        recommendation = recommend(laboratory, selection, causes)
    nominal = laboratory.nominal.names
    own, errors = estimated(laboratory, kept).in_torque(laboratory)
    rejected = selection.rejected
    return Diagnosis(
        verdict=verdict,
        causes=tuple(causes),
        checks=checks,
        names=robot.names,
        units=robot.effort_units,
        library_hash=library_hash(search.design.library),
        sentence=sentence_of(
            verdict,
            causes,
            judged.gain,
            selection,
            robot.names,
            robot.effort_units,
            tolerated,
            unstated_friction(laboratory, own, errors),
            search.design.untold,
            search.design.untried,
        ),
        gain=judged.gain,
        recommendation=recommendation,
        ranking=tuple(_entry(finding, robot.names) for finding in selection.ranking),
        rejected=None if rejected is None else _entry(rejected, robot.names),
        tolerated=tolerated,
        # The nominal's deviations come first, the amplitudes of the causes after them.
        refit=dict(zip(nominal, own.tolist(), strict=False)),
        refit_errors=dict(zip(nominal, errors.tolist(), strict=False)),
        structure=_structure(laboratory, selection),
        stages=tuple(stages(judged.folds, laboratory, selection)),
        band_hz=laboratory.signals[0].band.cutoff,
        laboratory=laboratory,
        selection=selection,
        confusability=confusability(laboratory, selection.accepted),
        # The pictures show the recordings that were diagnosed, not the one that was left out.
        residual_before=judged.folds.error(selection.before, ()),
        residual_after=judged.folds.error(selection.after, selection.accepted),
    )


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
                'period': x.period or None,
                'bursts': x.bursts or None,
                'at_s': x.at_s if x.bursts else None,
                'unknown': x.significant,
            }
            for x in left.found
        ],
    }
