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
from sosml_friction.diagnosis.effect import Effect, Inner
from sosml_friction.diagnosis.laboratory import Laboratory
from sosml_friction.diagnosis.selection import Finding, Selection
from sosml_friction.diagnosis.signals import Signals, make_signals
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.identification.motion import begin_motion
from sosml_friction.identification.multisine import MultisineSettings, add_multisine
from sosml_friction.identification.rich import rich
from sosml_friction.identification.speed_ladder import speed_ladder
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]

#: Log-likelihood by which the right cause has to lead.
NEEDED = 10.0
#: A trajectory that overlaps them as much as this does not separate two causes.
_HOPELESS = 0.995

#: What tells causes apart whose equations are the same whatever the motion.
CONDITIONS: dict[frozenset[str], str] = {
    frozenset({'effort_bias', 'asymmetric_friction'}): (
        'hold the joint where gravity asks nothing of it, free of load and at rest: a bias of '
        'effort stays, friction that differs between the directions does not'
    ),
    frozenset({'backlash', 'joint_elasticity'}): (
        'lock the motor and move the link by hand, or measure the link: with position at the '
        'motor alone a gap and a spring look alike'
    ),
    frozenset({'effort_scale', 'gravity'}): (
        'hang a known mass on the arm and record again: a wrong torque constant scales it, a '
        'wrong first moment does not'
    ),
    frozenset({'effort_scale', 'payload'}): (
        'hang a known mass on the arm and record again: a wrong torque constant scales it too'
    ),
    frozenset({'gravity', 'spring'}): (
        'record without the person or the cable (not worn) and compare: gravity stays, a spring '
        'goes'
    ),
    frozenset({'viscous', 'thermal_drift'}): (
        'repeat the same speeds cold and warm: a wrong viscous friction is the same in both'
    ),
    frozenset({'coulomb', 'thermal_drift'}): (
        'repeat the same speeds cold and warm: a wrong Coulomb friction is the same in both'
    ),
    frozenset({'load_dependent_friction', 'position_dependent_friction'}): (
        'repeat the recording with a known payload: friction that follows the load grows, '
        'friction that follows posture does not'
    ),
    frozenset({'load_dependent_friction', 'coulomb'}): (
        'repeat the recording with a known payload: friction that follows the load grows'
    ),
}


@dataclass(frozen=True)
class Recommendation:
    """
    Hold what to do next.

    ``pair``: the two causes; ``overlap``: share of the first that the second explains in these
    data; ``margin``: log-likelihood that separates them here, ``needed`` what would do;
    ``trajectory``: a name for ``sosml trajectory``, or None, with ``predicted_overlap`` and
    ``predicted_margin``; ``condition``: what to change besides, or ''.
    """

    pair: tuple[str, str]
    overlap: float
    margin: float
    needed: float
    trajectory: str | None
    predicted_overlap: float
    predicted_margin: float
    condition: str

    @property
    def sentence(self) -> str:
        """Return it for a person."""
        one, other = (name.replace('_', ' ') for name in self.pair)
        text = (
            f'{one} and {other} are {100 * self.overlap:.1f} % the same in these data (margin '
            f'{self.margin:.2g}, needed {self.needed:g})'
        )
        if self.condition:
            text += f': {self.condition}'
        if self.trajectory is not None:
            text += (
                f'{"; else" if self.condition else ":"} run {self.trajectory} (predicted '
                f'{100 * self.predicted_overlap:.1f} % the same, margin '
                f'{self.predicted_margin:.2g})'
            )
        elif not self.condition:
            text += ': no trajectory of the menu separates them; change the load or the posture'
        return text

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {
            'pair': list(self.pair),
            'overlap': self.overlap,
            'margin': self.margin,
            'needed': self.needed,
            'trajectory': self.trajectory,
            'predicted_overlap': self.predicted_overlap,
            'predicted_margin': self.predicted_margin,
            'condition': self.condition,
            'sentence': self.sentence,
        }


def recommend(
    laboratory: Laboratory, selection: Selection, model: RobotModelFile
) -> Recommendation | None:
    """
    Return the experiment for the first ambiguous cause and its closest rival.

    The margin in these data is half the distance of their evidence; that of a planned trajectory
    is half the whitened energy of the cause, as large as found, that its rival leaves there, with
    the noise of these data.
    """
    finding = next((f for f in selection.accepted if f.rivals or f.effect.inseparable), None)
    if finding is None:
        return None
    first = laboratory.signals[0]
    amplitude = finding.score.amplitude
    if not finding.rivals:
        pair = (finding.effect.identifier, finding.effect.inseparable[0])
        return Recommendation(
            pair, 1.0, 0.0, NEEDED, None, 1.0, 0.0, CONDITIONS.get(frozenset(pair), '')
        )
    own = finding.effect.identifier
    rival = next(
        (r for r in finding.rivals if frozenset({own, r.effect.identifier}) in CONDITIONS),
        finding.rivals[0],
    )
    pair = (finding.effect.identifier, rival.effect.identifier)
    margin = max(0.5 * (finding.score.gain - rival.score.gain), 0.0)
    here, _ = overlap(laboratory, laboratory.signals, finding, rival, amplitude)
    best: tuple[str | None, float, float] = (None, 1.0, 0.0)
    if rival.effect.identifier not in finding.effect.inseparable:
        for name, make in _menu(first).items():
            try:
                planned = _planned(first, make(), model)
            except TrajectoryError:
                continue
            share, left = overlap(laboratory, [planned], finding, rival, amplitude)
            if left > best[2] and share < _HOPELESS:
                best = (name, share, left)
    if best[2] <= margin:
        best = (None, 1.0, 0.0)
    condition = CONDITIONS.get(frozenset(pair), '')
    return Recommendation(pair, here, margin, NEEDED, best[0], best[1], best[2], condition)


def overlap(
    laboratory: Laboratory,
    signals: list[Signals] | tuple[Signals, ...],
    finding: Finding,
    rival: Finding,
    amplitude: FloatArray,
) -> tuple[float, float]:
    """
    Return the share of a cause that its rival explains along a motion, and the margin.

    By least squares of the whitened effort of the cause on the nominal columns, then on the
    rival's besides; nominal parameters are free here, which is the careful side.
    """
    one = _whitened(laboratory, signals, finding.effect, finding.joint, finding.inner)
    other = _whitened(laboratory, signals, rival.effect, rival.joint, rival.inner)
    Z = np.concatenate(
        [
            np.concatenate(
                [
                    laboratory.noise[i].whiten(s.band.apply(laboratory.nominal.columns(s)[:, i]))
                    for i in range(laboratory.robot.n)
                ]
            )
            for s in signals
        ]
    )
    y = one @ amplitude
    alone = _rest(Z, y)
    left = _rest(np.concatenate([Z, other], axis=1), y)
    return float(np.clip(1.0 - left / max(alone, 1e-300), 0.0, 1.0)), 0.5 * left


def _whitened(
    laboratory: Laboratory,
    signals: list[Signals] | tuple[Signals, ...],
    effect: Effect,
    joint: int,
    inner: Inner,
) -> FloatArray:
    parts = []
    for s in signals:
        columns = s.band.apply(effect.columns(s, joint, inner))
        parts.append(
            np.concatenate([laboratory.noise[i].whiten(columns[:, i]) for i in range(s.robot.n)])
        )
    return np.concatenate(parts)


def _rest(X: FloatArray, y: FloatArray) -> float:
    size = np.linalg.norm(X, axis=0)
    X = X[:, size > 0.0] / size[size > 0.0]
    beta = np.linalg.lstsq(X, y, rcond=1e-9)[0]
    return float(np.sum((y - X @ beta) ** 2))


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

    return {'slow_ladder': ladder, 'multisine': sines, 'rich': everything}


def _planned(signals: Signals, trajectory: Trajectory, model: RobotModelFile) -> Signals:
    """Return the signals of a trajectory that is followed exactly."""
    step = signals.band.step
    t = np.arange(0.0, trajectory.duration, step)
    q = trajectory.spline()(t)
    empty = np.zeros_like(q)
    log = JointLog(signals.robot.names, np.rint(t * 1e9).astype(np.int64), q, empty, empty)
    return make_signals(log, signals.robot, signals.scales, signals.band, 0.0)
