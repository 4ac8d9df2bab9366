# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The experiment that would separate causes that these data cannot."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.next_experiment.conditions import conditions
from sosml_friction.diagnosis.next_experiment.pair_conditions import PairCondition, pair_condition
from sosml_friction.diagnosis.next_experiment.recommendation import Option, Recommendation
from sosml_friction.diagnosis.next_experiment.separation import separation
from sosml_friction.diagnosis.next_experiment.stretch import Stretch
from sosml_friction.diagnosis.next_experiment.supposed import Supposed
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.motion.building_blocks import begin_motion
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kinds.multisine import MultisineSettings, add_multisine
from sosml_friction.motion.trajectory_kinds.rich import rich
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.motion.trajectory_kinds.symmetric_reversals import symmetric_reversals
from sosml_friction.regression.band_rows import SMALL_GRID
from sosml_friction.regression.candidate import Candidate
from sosml_friction.regression.evidence import CandidateColumns
from sosml_friction.regression.signals import Signals, make_signals
from sosml_friction.regression.whitened import WhitenedRegression

#: Log-likelihood by which the right cause has to lead: odds of exp(10) = 22 000 to 1.
NEEDED = 10.0


def recommend(
    laboratory: WhitenedRegression, selection: Selection, causes: Sequence[Cause]
) -> Recommendation | None:
    """
    Return the experiment for the first ambiguous of the causes and its closest rival.

    The margin in these data is half the distance of their evidence. Each trajectory of the menu
    and each change of condition is then supposed to be recorded besides
    (:func:`~.separation.separation`). The trajectory with the largest
    margin is recommended if that suffices; else, and where the equations of the two are the same
    along any motion, the change of condition that is known for the pair or has the largest margin.
    """
    names = laboratory.robot.names
    unsure = {cause.key: cause.rivals for cause in causes if cause.rivals}
    finding = next((f for f in selection.accepted if f.reported(names) in unsure), None)
    if finding is None:
        return _of_impacts(laboratory)
    inseparable = laboratory.inseparable(finding.effect)
    own = finding.effect.identifier
    closest = _closest(finding)
    first = unsure[finding.reported(names)][0].partition('@')[0]
    other = first if closest is None else closest.effect.identifier
    margin = 0.0
    if closest is not None:
        margin = max(0.5 * (finding.score.gain - closest.score.gain), 0.0)
    pair = (own, other)
    _, where = finding.reported(names)
    known, said = pair_condition(*pair) or PairCondition('', '')
    if closest is None or other in inseparable:
        # Joint sensors cannot tell them apart at all: their columns differ by numerics alone.
        return Recommendation(pair, where, 1.0, margin, NEEDED, condition=said)
    cause, rival = supposed(laboratory, finding), supposed(laboratory, closest)
    here, _ = separation(laboratory, cause, rival, ())
    options = weigh(laboratory, cause, rival)
    runs = [option for option in options if option.kind == 'trajectory']
    changes = [option for option in options if option.kind == 'condition']
    # Of what leaves less than the floor of a cause, its column is not known any better.
    most = 1.0 - laboratory.settings.floor
    best = next((run for run in runs if run.margin > NEEDED and run.overlap < most), None)
    aliases = other in finding.effect.aliases or own in closest.effect.aliases
    if best is not None and not aliases:
        return Recommendation(
            pair, where, here, margin, NEEDED, best.name, best.duration_s, best.overlap,
            best.margin, options=options,
        )  # fmt: skip
    change = next((option for option in changes if option.name == known), None)
    if change is None and not said and changes and changes[0].margin > NEEDED:
        change = changes[0]
    if change is None:
        return Recommendation(pair, where, here, margin, NEEDED, condition=said, options=options)
    return Recommendation(
        pair, where, here, margin, NEEDED, None, change.duration_s, change.overlap, change.margin,
        said or change.instruction, options,
    )  # fmt: skip


def _closest(finding: Finding) -> Finding | None:
    """Return the rival that another condition is known to tell apart, else the first; or none."""
    own = finding.effect.identifier
    for rival in finding.rivals:
        if pair_condition(own, rival.effect.identifier) is not None:
            return rival
    return finding.rivals[0] if finding.rivals else None


def _of_impacts(laboratory: WhitenedRegression) -> Recommendation | None:
    """Return what tells a gap from a spring, where impacts alone show one of them."""
    if not laboratory.contacts.impacts:
        return None
    pair = ('backlash', 'joint_elasticity')
    where = laboratory.robot.names[laboratory.contacts.impacts[0].joint]
    said = pair_condition(*pair)
    instruction = said.instruction if said else ''
    return Recommendation(pair, where, 1.0, 0.0, NEEDED, condition=instruction)


def weigh(laboratory: WhitenedRegression, cause: Supposed, rival: Supposed) -> tuple[Option, ...]:
    """Return every trajectory of the menu and change of condition, largest margin first."""
    first = laboratory.signals[0]
    options = []
    for name, make in _menu(first).items():
        try:
            planned = _planned(first, make())
        except TrajectoryError:
            continue
        stretch = Stretch(laboratory.seen_alike([planned])[0])
        share, margin = separation(laboratory, cause, rival, (stretch,))
        options.append(Option(name, 'trajectory', stretch.duration, share, margin, ''))
    for name, condition in conditions(laboratory.signals).items():
        share, margin = separation(laboratory, cause, rival, condition.stretches)
        duration = sum(stretch.duration for stretch in condition.stretches)
        options.append(Option(name, 'condition', duration, share, margin, condition.instruction))
    return tuple(sorted(options, key=lambda option: -option.margin))


def supposed(laboratory: WhitenedRegression, finding: Finding) -> Supposed:
    """Return a finding as a cause that is supposed; its grid too, where that is small."""
    p = len(laboratory.nominal.bound)
    columns = finding.columns
    points: list[Inner] = [dict(finding.inner)]
    C, A, B = columns.C[:, :, :1], columns.A[:, :1], columns.B[:, :1, :p]
    grid = _small_grid(laboratory, finding)
    if grid is not None:
        candidate, own = grid
        points += list(candidate.grid)
        C = np.concatenate([C, own.C], axis=2)
        A = np.concatenate([A, own.A], axis=1)
        B = np.concatenate([B, own.B[:, :, :p]], axis=1)
    return Supposed(
        finding.effect,
        finding.joint,
        points,
        CandidateColumns(columns.rows, C, A, B),
        finding.score.amplitude,
        finding.score.x[:p],
    )


def _small_grid(
    laboratory: WhitenedRegression, finding: Finding
) -> tuple[Candidate, CandidateColumns] | None:
    """Return the candidate that a finding is a point of, with its columns, where it is small."""
    for candidate, columns in zip(laboratory.candidates, laboratory.columns, strict=True):
        if (
            candidate.effect.identifier == finding.effect.identifier
            and candidate.joint == finding.joint
            and len(candidate.grid) <= SMALL_GRID
            and np.array_equal(columns.rows, finding.columns.rows)
        ):
            return candidate, columns
    return None


def _menu(signals: Signals) -> dict[str, Callable[[], Trajectory]]:
    """Return trajectories within the motion that was measured."""
    names = signals.robot.names
    low, high = signals.q.min(axis=0), signals.q.max(axis=0)
    centre = dict(zip(names, (0.5 * (low + high)).tolist(), strict=True))
    span = np.maximum(high - low, 1e-9)
    speed = signals.scales.speed
    scale = (span / span.max()).tolist()
    top = float(speed.max())
    half = 0.5 * float(span.max())
    rungs = [top * share for share in (0.03, 0.1, 0.3, 0.8)]
    plateau = min(0.8, half / max(rungs[-1], 1e-9))

    def ladder() -> Trajectory:
        return speed_ladder(centre, centre, rungs[:3], 1.0, 0.3, top, scale)

    def sines() -> Trajectory:
        settings = MultisineSettings(
            amplitude=half, peak_speed=top, peak_acceleration=6.0 * top, periods=2
        )
        motion, _, factor = begin_motion('the multisine', centre, centre, scale)
        return add_multisine(motion, settings, factor).build()

    def everything() -> Trajectory:
        settings = MultisineSettings(
            amplitude=0.6 * half, peak_speed=top, peak_acceleration=6.0 * top
        )
        return rich(
            centre, centre, [-0.3 * float(x) for x in span], rungs, plateau, 0.3, 0.3 * half,
            0.4, 8.0, 0.05, settings, top, scale,
        )  # fmt: skip

    def reversals() -> Trajectory:
        return symmetric_reversals(centre, centre, rungs[:3], 0.65, 0.3, 3, top, scale)

    return {
        'slow_ladder': ladder,
        'symmetric_reversals': reversals,
        'multisine': sines,
        'rich': everything,
    }


def _planned(signals: Signals, trajectory: Trajectory) -> Signals:
    """Return the signals of a trajectory that is followed exactly."""
    step = signals.band.step
    t = np.arange(0.0, trajectory.duration, step)
    q = trajectory.spline()(t)
    empty = np.zeros_like(q)
    log = JointLog(signals.robot.names, np.rint(t * 1e9).astype(np.int64), q, empty, empty)
    planned = make_signals(log, signals.robot, signals.scales, signals.band, 0.0)
    planned = replace(planned, untold=signals.untold, stated=signals.stated)
    return replace(planned, tau=planned.whole_torque)
