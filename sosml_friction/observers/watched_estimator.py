# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Estimates with, for each that is not known, the reason why."""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Callable, Collection, Hashable
from dataclasses import dataclass, field

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.dissipation import Dissipation
from sosml_friction.observers.estimate_error import EstimateError
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.held_joints import HeldJoints
from sosml_friction.observers.observer import Observer
from sosml_friction.observers.plausibility import EXCESS, Plausibility
from sosml_friction.observers.signal_noise import difference_noise

#: Two publishers take turns: this often within this time [s], after which they are found no more.
_TURNS = 2
_TURNS_S = 1.0
#: Where there are several, a position that goes out of line and back is another publisher's: by
#: more than so many steps and so many times its noise, either way. Chosen: of white noise one
#: sample in 1e7 is so far from both beside it.
_STEPS = 5.0
_NOISE = 8.0
#: Positions from which the noise is known. Only every second or third of them counts, if that
#: makes less: what comes by turns is then of one publisher.
_KEPT = 61
#: The gap is made from so many intervals of one message to the next, and is this multiple of
#: their median; never below the least, at which most streams run [s]. Chosen, no measurement.
_INTERVALS = 10
_GAP = 3.0
#: A position that is new by more steps than this after samples that say the same was measured
#: late; by one step it may be that of a coarse encoder.
_NEW = 1.5
LEAST_GAP_S = 0.05


@dataclass
class Watched:
    """
    Hold what one sample gave.

    :param estimates: tau_f of each observer (n,), NaN where not known.
    :param error: standard error of the selected one (n,), NaN where not known or settling.
    :param causes: by joint, why its estimate is not known.
    :param remarks: by joint, what is to be told of an estimate that is known.
    :param events: what happened to the stream at this sample: gap, repeated, backwards.
    :param repeats: of a sample of a motion that says something new: how many before it said the
        same; None for another.
    """

    estimates: dict[str, FloatArray] = field(default_factory=dict)
    error: FloatArray = field(default_factory=lambda: np.empty(0))
    causes: dict[str, str] = field(default_factory=dict)
    remarks: dict[str, str] = field(default_factory=dict)
    events: tuple[str, ...] = ()
    repeats: int | None = None


class WatchedEstimator:
    """
    Run a :class:`FrictionEstimator` on what of a stream is plausible, and say why on the rest.

    Samples in which nothing is wrong give its numbers to the last bit.

    :param estimator: what runs.
    :param selected: the observer whose errors are published.
    :param excess: of :class:`~sosml_friction.observers.plausibility.Plausibility`, as is what
        follows.
    :param follows_rate: whether the estimator's ``maximum_gap_s`` follows the rate of the
        stream.
    :param correct: from the measured effort to the torque behind it.
    """

    def __init__(
        self,
        estimator: FrictionEstimator,
        selected: str,
        excess: float = EXCESS,
        passive: Collection[str] = (),
        follows_rate: bool = False,
        correct: Callable[[FloatArray], FloatArray] | None = None,
    ) -> None:
        self.estimator = estimator
        self.names = estimator.robot.names
        uses_velocity = estimator.velocity_source == 'message'
        self._correct = correct or (lambda tau: tau)
        self._plausibility = Plausibility(
            estimator.robot, excess, passive, uses_velocity, self._correct
        )
        self._follows_rate = follows_rate
        self._steps: list[int] = []
        self._last_ns: int | None = None
        self._source: Hashable = None
        self._positions: deque[FloatArray] = deque(maxlen=_KEPT)
        #: Of joints that the model has not, but joint_states may.
        self.held = HeldJoints(estimator.robot)
        self._dissipation = Dissipation(estimator.robot.n)
        self._said: tuple[bytes, ...] = ()
        self._said_q = np.full(estimator.robot.n, np.nan)
        self._repeats = 0
        #: Whether joint_states has more publishers than this stream alone explains.
        self.several = False
        self._turns: list[float] = []
        self.select(selected)

    def select(self, selected: str) -> None:
        """Make the errors those of another observer that runs."""
        self.selected = selected
        self._error = EstimateError(self.estimator.observers[selected])

    def replace(self, observer: Observer) -> None:
        """Run an observer with other gains in the place of its like; it starts afresh."""
        self.estimator.observers[observer.identifier] = observer
        self.reset()
        self.select(self.selected)

    def reset(self) -> None:
        """Forget the past: the next sample starts the observers."""
        self.estimator.reset()
        self._plausibility.reset()
        self._dissipation.reset()
        self._last_ns = None

    def update(
        self,
        t_ns: int,
        q: FloatArray,
        v: FloatArray,
        tau: FloatArray,
        source: Hashable = None,
    ) -> Watched | None:
        """
        Take one sample; None for a repeated stamp, which brings nothing.

        :param t_ns: stamp of measurement [ns].
        :param q: position (n,) [rad or m].
        :param v: velocity (n,) [rad/s or m/s].
        :param tau: measured effort (n,) [Nm or N].
        :param source: what tells messages of one publisher from those of another, if anything.
        """
        if t_ns == self._last_ns:
            self.estimator.update(t_ns, q, v, tau)
            return None
        verdict = self._plausibility.judge(t_ns, q, v, tau)
        causes = {}
        if verdict.causes:
            causes = {self.names[i]: cause for i, cause in verdict.causes.items()}
        q_used = verdict.q
        if self._is_interleaved(t_ns, q, source):
            q_used = np.full(len(q), np.nan)
            causes = dict.fromkeys(
                self.names,
                'two publishers send these joints on joint_states by turns: stop one of them '
                '(ros2 topic info -v joint_states names them)',
            )
        self._follow_rate(t_ns)
        self._last_ns = t_ns
        torque = self._correct(verdict.tau)
        estimates = self.estimator.update(t_ns, q_used, verdict.v, torque)
        assert estimates is not None
        for i, cause in self.held.causes.items():
            causes.setdefault(self.names[i], cause)
            for estimate in estimates.values():
                estimate[i] = np.nan
        events = self.estimator.events
        known = np.isfinite(estimates[self.selected])
        # Plain values: NumPy takes several times as long over a few joints.
        if False in known.tolist():
            self._explain(causes, known, events, q, v, tau)
        else:
            causes = {}
        error = self._error.update(
            t_ns * 1e-9,
            self.estimator.velocity,
            torque,
            self.estimator.inertia,
            estimates[self.selected],
        )
        self._plausibility.learn(estimates[self.selected], error)
        self.held.look(t_ns * 1e-9, q, error)
        self._dissipation.take(
            t_ns * 1e-9,
            self.estimator.velocity,
            estimates[self.selected],
            error,
            torque,
            self._plausibility.moving,
        )
        remarks = {}
        if verdict.remarks or self._dissipation.remarks:
            found = self._dissipation.remarks | verdict.remarks
            remarks = {self.names[i]: remark for i, remark in found.items()}
        return Watched(estimates, error, causes, remarks, events, self._count_repeats(q, v, tau))

    def _count_repeats(self, q: FloatArray, v: FloatArray, tau: FloatArray) -> int | None:
        """Return how many samples said the same before one that is new; None if this is none."""
        said = q.tobytes(), v.tobytes(), tau.tobytes()
        if said == self._said:
            self._repeats += 1
            return None
        new = np.abs(q - self._said_q) > _NEW * self._plausibility.steps
        repeats = self._repeats if new.any() else 0
        self._said, self._said_q, self._repeats = said, q, 0
        return repeats if self._plausibility.moving.any() else None

    def _explain(
        self,
        causes: dict[str, str],
        known: FloatArray,
        events: tuple[str, ...],
        q: FloatArray,
        v: FloatArray,
        tau: FloatArray,
    ) -> None:
        """Add why joints are not known that are plausible."""
        of_message = self.estimator.velocity_source == 'message'
        lost = {}
        for i, name in enumerate(self.names):
            if not np.isfinite(q[i]):
                lost[name] = f'joint_states carries no position of {name}'
            elif of_message and not np.isfinite(v[i]):
                lost[name] = (
                    f'joint_states carries no velocity of {name}: make the driver publish it, or '
                    'set parameter velocity_source to position_difference'
                )
        first = next(iter(causes.items()), None)
        for i, name in enumerate(self.names):
            if known[i]:
                causes.pop(name, None)
            elif name in causes:
                continue
            elif lost:
                causes[name] = lost.get(name, next(iter(lost.values())))
            elif not np.isfinite(tau[i]):
                causes[name] = (
                    'friction of this joint unavailable: its actuator reports no current, so '
                    'joint_states carries no effort of it'
                )
            elif first is not None:
                causes[name] = f'joint {first[0]}: {first[1]}'
            elif 'backwards' in events:
                causes[name] = 'time went back: the observers start afresh'
            elif 'gap' in events:
                causes[name] = 'a gap in joint_states: the observers start afresh'
            else:
                causes[name] = 'the observers start'

    def _is_interleaved(self, t_ns: int, q: FloatArray, source: Hashable) -> bool:
        """Tell whether messages of two publishers come by turns."""
        t_s = t_ns * 1e-9
        turn = self._source is not None and source != self._source
        self._source = source
        if all(map(math.isfinite, q.tolist())):
            turn |= self.several and self._goes_back(q)
            self._positions.append(np.array(q))
        if turn:
            self._turns.append(t_s)
        if self._turns:
            self._turns = [t for t in self._turns if abs(t_s - t) < _TURNS_S]
        return len(self._turns) >= _TURNS

    def _goes_back(self, q: FloatArray) -> bool:
        """Tell whether the position before this one was out of line with those beside it."""
        if len(self._positions) < _KEPT:
            return False
        first, second, third = (self._positions[-k] for k in (3, 2, 1))
        least = _STEPS * self._plausibility.steps
        there, back = third - second, q - third
        way, farther = np.sort(np.abs([there, back]), axis=0)
        # What leaps and goes on, as at a wrap, does not come back.
        aside = (there * back < 0.0) & (farther < 2.0 * way)
        # A joint that turns round by itself is accelerated alike over both steps.
        aside &= (back - there) * (there - (second - first)) < 0.0
        if not (aside & (way > least)).any():
            return False
        x = np.array(self._positions)
        every = [difference_noise(np.diff(x[k::k], 2, axis=0), 2) for k in (1, 2, 3)]
        return bool((aside & (way > least + _NOISE * np.min(every, axis=0))).any())

    def _follow_rate(self, t_ns: int) -> None:
        if not self._follows_rate:
            return
        if self._last_ns is None or t_ns <= self._last_ns:
            return
        self._steps.append(t_ns - self._last_ns)
        if len(self._steps) == _INTERVALS:
            typical = statistics.median(self._steps) * 1e-9
            self._steps.clear()
            gap = max(LEAST_GAP_S, _GAP * typical)
            # A rate that wanders by less changes nothing.
            if not 0.5 <= gap / self.estimator.maximum_gap_s <= 1.5:
                self.estimator.maximum_gap_s = gap
