# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The experiment that would separate causes that these data cannot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.conditions import conditions
from sosml_friction.diagnosis.effect import Inner
from sosml_friction.diagnosis.evidence import CandidateColumns
from sosml_friction.diagnosis.laboratory import Laboratory
from sosml_friction.diagnosis.selection import Finding, Selection
from sosml_friction.diagnosis.separation import Stretch, Supposed, separation
from sosml_friction.diagnosis.signals import Signals, make_signals
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.identification.motion import begin_motion
from sosml_friction.identification.multisine import MultisineSettings, add_multisine
from sosml_friction.identification.rich import rich
from sosml_friction.identification.speed_ladder import speed_ladder
from sosml_friction.identification.symmetric_reversals import symmetric_reversals
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]

#: Log-likelihood by which the right cause has to lead.
NEEDED = 10.0
#: What overlaps as much as this does not separate two causes, however large they are.
_HOPELESS = 0.995
#: Grids with more points than this are not tried over again along a planned motion.
_MOST_POINTS = 12

#: What tells causes apart that the joint sensors do not, said for the pair; by condition.
_SAID: dict[frozenset[str], tuple[str, str]] = {
    frozenset({'effort_bias', 'asymmetric_friction'}): (
        'free_hanging_hold',
        'hold the joint where gravity asks nothing of it, free of load and at rest, motors off: a '
        'bias of effort stays, friction that differs between the directions does not',
    ),
    frozenset({'backlash', 'joint_elasticity'}): (
        '',
        'lock the motor and move the link by hand, or measure the link: with position at the '
        'motor alone a gap and a spring look alike',
    ),
    frozenset({'effort_scale', 'gravity'}): (
        'known_payload',
        'hang a known mass on the arm and record again: a wrong torque constant scales it, a '
        'wrong first moment does not',
    ),
    frozenset({'effort_scale', 'payload'}): (
        'known_payload',
        'hang a known mass on the arm and record again: a wrong torque constant scales it too',
    ),
    frozenset({'effort_scale', 'inertia'}): (
        'known_payload',
        'hang a known mass on the arm and record again: a wrong torque constant scales it, a '
        'wrong inertia does not',
    ),
    frozenset({'gravity', 'spring'}): (
        'not_worn',
        'record without the person or the cable (not worn) and compare: gravity stays, a spring '
        'goes',
    ),
    frozenset({'effort_bias', 'spring'}): (
        'not_worn',
        'record without the person or the cable (not worn) and compare: a bias of effort stays, a '
        'spring goes',
    ),
    frozenset({'viscous', 'thermal_drift'}): (
        'warm_up_repeat',
        'repeat the same speeds cold and warm: a wrong viscous friction is the same in both',
    ),
    frozenset({'coulomb', 'thermal_drift'}): (
        'warm_up_repeat',
        'repeat the same speeds cold and warm: a wrong Coulomb friction is the same in both',
    ),
    frozenset({'load_dependent_friction', 'position_dependent_friction'}): (
        'known_payload',
        'repeat the recording with a known payload: friction that follows the load grows, '
        'friction that follows posture does not',
    ),
    frozenset({'load_dependent_friction', 'coulomb'}): (
        'known_payload',
        'repeat the recording with a known payload: friction that follows the load grows',
    ),
}
#: Pairs that can be told apart at all by another condition only.
CONDITIONS = {pair: said for pair, (_, said) in _SAID.items()}


@dataclass(frozen=True)
class Option:
    """
    Hold one thing to do: a trajectory of ``sosml trajectory``, or a change of condition.

    ``overlap``: share of the first cause that the second explains, with what it adds to these
    data; ``margin``: log-likelihood by which the right one leads then.
    """

    name: str
    kind: str
    duration_s: float
    overlap: float
    margin: float
    instruction: str

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {
            'name': self.name,
            'kind': self.kind,
            'duration_s': self.duration_s,
            'overlap': self.overlap,
            'margin': self.margin,
            'instruction': self.instruction,
        }


@dataclass(frozen=True)
class Recommendation:
    """
    Hold what to do next.

    ``pair``: the two causes, ``joint`` where the first is; ``overlap``: share of the first that
    the second explains in these data; ``margin``: log-likelihood that separates them here,
    ``needed`` what would do; ``trajectory``: a name for ``sosml trajectory``, or None;
    ``condition``: what to change instead, or ''; ``duration_s``, ``predicted_overlap`` and
    ``predicted_margin``: with these data and those of what is recommended together; NaN where
    the joint sensors do not take part. ``options``: all that was weighed, best first.
    """

    pair: tuple[str, str]
    joint: str
    overlap: float
    margin: float
    needed: float
    trajectory: str | None
    duration_s: float
    predicted_overlap: float
    predicted_margin: float
    condition: str
    options: tuple[Option, ...] = ()

    @property
    def sentence(self) -> str:
        """Return it for a person."""
        one, other = (name.replace('_', ' ') for name in self.pair)
        where = '' if self.joint == '*' else f' ({self.joint})'
        text = (
            f'{one} and {other}{where} are {100 * self.overlap:.1f} % the same in these data '
            f'(margin {self.margin:.2g}, needed {self.needed:g})'
        )
        predicted = ''
        if np.isfinite(self.predicted_margin):
            predicted = (
                f'{100 * self.predicted_overlap:.1f} % the same with both recordings, margin '
                f'{self.predicted_margin:.2g}'
            )
        if self.trajectory is not None:
            return (
                f'{text}: run {self.trajectory} ({self.duration_s:.0f} s; predicted {predicted})'
            )
        if self.condition and predicted:
            return (
                f'{text}, and no trajectory separates them: {self.condition} '
                f'({self.duration_s:.0f} s; predicted {predicted})'
            )
        if self.condition:
            return f'{text}, and no trajectory separates them: {self.condition}'
        return f'{text}: nothing on the menu separates them; change the load or the posture'

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {
            'pair': list(self.pair),
            'joint': self.joint,
            'overlap': self.overlap,
            'margin': self.margin,
            'needed': self.needed,
            'trajectory': self.trajectory,
            'duration_s': self.duration_s,
            'predicted_overlap': self.predicted_overlap,
            'predicted_margin': self.predicted_margin,
            'condition': self.condition,
            'options': [option.to_dict() for option in self.options],
            'sentence': self.sentence,
        }


def recommend(
    laboratory: Laboratory, selection: Selection, model: RobotModelFile
) -> Recommendation | None:
    """
    Return the experiment for the first ambiguous cause and its closest rival.

    The margin in these data is half the distance of their evidence. Each trajectory of the menu
    and each change of condition is then supposed to be recorded besides
    (:func:`~sosml_friction.diagnosis.separation.separation`). The trajectory with the largest
    margin is recommended if that suffices; else, and where the equations of the two are the same
    along any motion, the change of condition that is known for the pair or has the largest margin.
    """
    finding = next((f for f in selection.accepted if f.rivals or f.effect.inseparable), None)
    names = laboratory.robot.names
    if finding is None:
        return _of_impacts(laboratory)
    where = '*' if finding.effect.of_robot else names[finding.joint]
    own = finding.effect.identifier
    cause = supposed(laboratory, finding)
    if finding.rivals:
        closest = next(
            (r for r in finding.rivals if frozenset({own, r.effect.identifier}) in CONDITIONS),
            finding.rivals[0],
        )
        rival: Supposed | None = supposed(laboratory, closest)
        margin = max(0.5 * (finding.score.gain - closest.score.gain), 0.0)
        other = closest.effect.identifier
    else:
        other = finding.effect.inseparable[0]
        rival = _candidate(laboratory, other, finding.joint)
        margin = 0.0
    pair = (own, other)
    known, said = _SAID.get(frozenset(pair), ('', ''))
    if rival is None or other in finding.effect.inseparable:
        # Joint sensors cannot tell them apart at all: what the columns say is not to be believed.
        return Recommendation(
            pair, where, 1.0, margin, NEEDED, None, np.nan, np.nan, np.nan, said
        )  # fmt: skip
    here, _ = separation(laboratory, cause, rival, ())
    options = weigh(laboratory, cause, rival, model)
    runs = [option for option in options if option.kind == 'trajectory']
    changes = [option for option in options if option.kind == 'condition']
    twins = other in finding.effect.twins or own in (
        closest.effect.twins if finding.rivals else ()
    )
    best = next(
        (option for option in runs if option.margin > NEEDED and option.overlap < _HOPELESS), None
    )
    if best is not None and not twins:
        return Recommendation(
            pair, where, here, margin, NEEDED, best.name, best.duration_s, best.overlap,
            best.margin, '', options,
        )  # fmt: skip
    change = next((option for option in changes if option.name == known), None)
    if change is None and not said and changes and changes[0].margin > NEEDED:
        change = changes[0]
    if change is None:
        return Recommendation(
            pair, where, here, margin, NEEDED, None, np.nan, np.nan, np.nan, said, options
        )  # fmt: skip
    return Recommendation(
        pair, where, here, margin, NEEDED, None, change.duration_s, change.overlap, change.margin,
        said or change.instruction, options,
    )  # fmt: skip


def _of_impacts(laboratory: Laboratory) -> Recommendation | None:
    """Return what tells a gap from a spring, where impacts alone show one of them."""
    if not laboratory.bursts.impacts:
        return None
    pair = ('backlash', 'joint_elasticity')
    where = laboratory.robot.names[laboratory.bursts.impacts[0].joint]
    said = CONDITIONS[frozenset(pair)]
    return Recommendation(pair, where, 1.0, 0.0, NEEDED, None, np.nan, np.nan, np.nan, said)


def weigh(
    laboratory: Laboratory, cause: Supposed, rival: Supposed, model: RobotModelFile
) -> tuple[Option, ...]:
    """Return every trajectory of the menu and change of condition, largest margin first."""
    first = laboratory.signals[0]
    options = []
    for name, make in _menu(first).items():
        try:
            planned = _planned(first, make(), model)
        except TrajectoryError:
            continue
        stretch = Stretch(planned)
        share, margin = separation(laboratory, cause, rival, (stretch,))
        options.append(Option(name, 'trajectory', stretch.duration, share, margin, ''))
    for name, condition in conditions(laboratory.signals).items():
        share, margin = separation(laboratory, cause, rival, condition.stretches)
        duration = sum(stretch.duration for stretch in condition.stretches)
        options.append(Option(name, 'condition', duration, share, margin, condition.instruction))
    return tuple(sorted(options, key=lambda option: -option.margin))


def supposed(laboratory: Laboratory, finding: Finding) -> Supposed:
    """Return a finding as a cause that is supposed; its grid too, where that is small."""
    p = len(laboratory.nominal.bound)
    columns = finding.columns
    points: list[Inner] = [dict(finding.inner)]
    grid = _candidate(laboratory, finding.effect.identifier, finding.joint)
    C, A, B = columns.C[:, :, :1], columns.A[:, :1], columns.B[:, :1, :p]
    if grid is not None and np.array_equal(grid.columns.rows, columns.rows):
        points += list(grid.points)
        C = np.concatenate([C, grid.columns.C], axis=2)
        A = np.concatenate([A, grid.columns.A], axis=1)
        B = np.concatenate([B, grid.columns.B[:, :, :p]], axis=1)
    return Supposed(
        finding.effect,
        finding.joint,
        points,
        CandidateColumns(columns.rows, C, A, B),
        finding.score.amplitude,
        finding.score.x[:p],
    )


def _candidate(laboratory: Laboratory, identifier: str, joint: int) -> Supposed | None:
    """Return a candidate over its grid, without a size; None if there is none, or too large."""
    for candidate, columns in zip(laboratory.candidates, laboratory.columns, strict=True):
        if candidate.effect.identifier != identifier or len(candidate.grid) > _MOST_POINTS:
            continue
        if candidate.joint == joint or candidate.effect.of_robot:
            k, p = columns.C.shape[3], len(laboratory.nominal.bound)
            return Supposed(
                candidate.effect,
                candidate.joint,
                candidate.grid,
                columns,
                np.zeros(k),
                np.zeros(p),
            )
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


def _planned(signals: Signals, trajectory: Trajectory, model: RobotModelFile) -> Signals:
    """Return the signals of a trajectory that is followed exactly."""
    step = signals.band.step
    t = np.arange(0.0, trajectory.duration, step)
    q = trajectory.spline()(t)
    empty = np.zeros_like(q)
    log = JointLog(signals.robot.names, np.rint(t * 1e9).astype(np.int64), q, empty, empty)
    return make_signals(log, signals.robot, signals.scales, signals.band, 0.0)
