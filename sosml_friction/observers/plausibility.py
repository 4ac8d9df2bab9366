# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether stamped joint states can be true, by the URDF's limits and by each other."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.model.robot import Robot
from sosml_friction.observers.constant_effort import ConstantEffort
from sosml_friction.observers.plain_sample import take_friction, take_plain_sample
from sosml_friction.observers.signal_noise import seen_noise

#: Measured beyond this multiple of a limit of the URDF is no measurement; beyond the limit itself
#: it is only told. Limits are often those of continuous duty: the pulses recorded on EMPS have
#: 1.98 times the force of its URDF's limit, which encloses its other record.
EXCESS = 2.0
#: A position this share of its range beyond a limit is no measurement. Chosen: a mechanical stop
#: stands beyond the limit of the software.
BEYOND = 0.1
#: Evidence is gathered over this time and at least ``_LEAST`` samples [s]: with the pause between
#: two looks, a number that is wrong is told before it was so for 0.1 s.
WINDOW_S = 0.07
_LEAST = 4
_LOOK_S = 0.02
_LONG_LOOK_S = 0.1
#: A servo's position may be held so long between two of its frames [s].
_FRAME_S = 0.05
#: Position and velocity that both change are compared over this time [s], of many frames.
_LONG_S = 0.4
#: A velocity may lag so much behind the position it belongs to [s], and be off by this share of
#: its limit. Chosen: filters of drives are faster.
_LAG_S = 0.05
_OFFSET = 0.02
#: Positions are told from constant ones above so many of their smallest steps.
_STEPS = 3.0
#: Before a smaller step was seen: that of ten bits per turn [rad], or a millimetre [m].
_COARSE = {'Nm': 2.0 * math.pi / 1024.0, 'N': 1e-3}
#: Where velocity has no limit: one for the offset above [rad/s or m/s].
_SPEED = 1.0
#: A joint at rest holds against at most this multiple of the friction seen in motion: breakaway
#: is above sliding, by a factor below two in the measured joints of docs/validation.md.
_BREAKAWAY = 2.0
#: Friction in motion is known after this time of it [s], and the greatest of the last 10 s of it,
#: as looked at; each start is left out [s].
_KNOWN = round(0.5 / _LOOK_S)
_KEPT = round(10.0 / _LOOK_S)
_SETTLED_S = 0.2
#: The speed before a standstill is that over twice this time, and at least six intervals; and a
#: standstill that friction cannot explain is one for so long [s].
_STOP_S = 0.02


class Verdict(NamedTuple):
    """
    What is left of a sample.

    ``q``, ``v`` and ``tau`` are those that were given where nothing is wrong; NaN where not to be
    used. ``causes``: by joint, why, and what to do; ``remarks``: by joint, what is told and yet
    used.
    """

    q: FloatArray
    v: FloatArray
    tau: FloatArray
    causes: dict[int, str]
    remarks: dict[int, str]


class _Sample:
    """A sample that was used: its stamp [s], and q, v, tau and the way by velocities, (4, n)."""

    __slots__ = ('q', 'rows', 't_s', 'tau', 'travel', 'v')

    def __init__(self, t_s: float, rows: FloatArray) -> None:
        self.t_s, self.rows = t_s, rows
        self.q, self.v, self.tau, self.travel = rows[0], rows[1], rows[2], rows[3]


class _Place(NamedTuple):
    t_s: float
    #: The position, and by joint when it came there [s], (2, n).
    rows: FloatArray

    @property
    def q(self) -> FloatArray:
        return self.rows[0]

    @property
    def since(self) -> list[float]:
        return self.rows[1].tolist()


class Plausibility:
    """
    Judge samples (t, q, v, tau) one after the other, by their stamps alone.

    * Limits: an effort beyond :data:`EXCESS` times the limit of the URDF is not used; a velocity
      beyond it, a position beyond its limits by :data:`BEYOND` of the range, or one that is
      reached faster than the limit of velocity allows, make the whole sample unusable: momentum
      and weight of every joint need them. A position that leapt and stays is told until the past
      is forgotten. A limit that is not stated, or 0, judges nothing.
    * Position against velocity: one of them exactly constant while the other says that the joint
      moves, or the two apart by more than half.
    * Rest against effort: a position exactly constant while more than twice the friction that was
      seen in motion would have to hold the joint, or to have stopped it: a frozen encoder, a brake
      or a stop.
    * Effort constant to the last bit: at 0.0 not measured, unless it was something else before
      and the joint rests, or the joint is ``passive``; at another value hung or saturated, where
      it was never so long the same in motion and the motion needs another.

    What was judged wrong is right again as soon as the evidence ends. Samples that are not finite
    pass: the estimator knows what to do with them.

    :param robot: whose joints are the columns.
    :param excess: instead of :data:`EXCESS`.
    :param passive: joints without an actuator, whose effort is truly 0.0.
    :param uses_velocity: False where velocity is made from positions.
    :param correct: from the measured effort to the torque behind it, which friction balances.
    """

    def __init__(
        self,
        robot: Robot,
        excess: float = EXCESS,
        passive: Collection[str] = (),
        uses_velocity: bool = True,
        correct: Callable[[FloatArray], FloatArray] | None = None,
    ) -> None:
        self._correct = correct or (lambda tau: tau)
        n = robot.n
        self._robot = robot
        self.names = robot.names
        self._uses_velocity = uses_velocity
        limits = robot.limits
        self._units = [('rad', 'Nm') if u == 'Nm' else ('m', 'N') for u in robot.effort_units]
        self._told = [_limit(limit.effort) for limit in limits]
        self._most_effort = [excess * told for told in self._told]
        self._velocity = np.array([excess * _limit(limit.velocity) for limit in limits])
        lower = np.array([limit.lower for limit in limits])
        upper = np.array([limit.upper for limit in limits])
        # The same place twice, as of a joint whose limits nobody filled in, limits nothing.
        room = np.where(upper > lower, upper - lower, np.inf)
        with np.errstate(invalid='ignore'):
            self._lower = np.where(np.isfinite(room), lower - BEYOND * room, -np.inf)
            self._upper = np.where(np.isfinite(room), upper + BEYOND * room, np.inf)
        self._ranges = self._velocity.tolist(), self._lower.tolist(), self._upper.tolist()
        self._limits = np.array([self._told, self._velocity, self._lower, self._upper])
        self._still = np.zeros(n)
        self._stated = limits
        self._passive = [name in passive for name in robot.names]
        #: The smallest step of each position that was seen, coarse before one was [rad or m].
        self.steps = np.array([_COARSE[unit] for unit in robot.effort_units])
        self._constant = ConstantEffort(self._passive, WINDOW_S, _LEAST)
        self._friction = [0.0] * n
        #: What a joint at rest holds against at most; infinite before friction in motion is known.
        self._most = np.full(n, np.inf)
        #: The greatest friction in motion since the last look.
        self._greatest = np.zeros(n)
        # By joint: the greatest between looks, those that may be of a standstill not yet seen.
        self._recent: list[deque[float]] = [deque() for _ in range(n)]
        #: The others, of the last motions: the greatest between two looks.
        self._seen: list[deque[float]] = [deque(maxlen=_KEPT) for _ in range(n)]
        self.reset()
        # Compile now: at the second sample it would stall the node.
        nothing = np.full((4, n), np.nan)
        take_plain_sample(
            0.0, nothing, nothing, 0.0, self._limits, nothing[:2], self._spans, self.steps
        )
        still = self.moving, self._standing, self._most, 0.0, False, _STOP_S
        take_friction(nothing[0], *still, nothing[0], self._greatest, self._beyond_s, nothing[0])

    def reset(self) -> None:
        """Forget the past but the resolution of positions and the friction seen in motion."""
        n = len(self.names)
        self._history: deque[_Sample] = deque()
        self._looked_s = self._looked_far_s = -math.inf
        self._constant.reset()
        #: By joint: the value at which position or velocity stands, NaN where not judged so.
        self._frozen_q = np.full(n, np.nan)
        self._frozen_v = np.full(n, np.nan)
        self._apart_until = np.full(n, -math.inf)
        self._apart_last = -math.inf
        self._found = False
        #: Which joints moved when last looked at (n,).
        self.moving = np.zeros(n, dtype=bool)
        self._standing = np.zeros(n, dtype=bool)
        self._stood_since = np.full(n, math.nan)
        self._beyond_s = np.zeros(n)
        self._spans = np.zeros(3)
        self._trusted: _Place | None = None
        self._doubted: list[_Place] = []
        #: By joint whose position leapt and stayed: what is said.
        self._leapt: dict[int, str] = {}
        self._started_s = math.nan

    def judge(self, t_ns: int, q: FloatArray, v: FloatArray, tau: FloatArray) -> Verdict:
        """
        Return what of a sample can be used.

        :param t_ns: stamp of measurement [ns].
        :param q: position (n,) [rad or m].
        :param v: velocity (n,) [rad/s or m/s].
        :param tau: effort (n,) [Nm or N].
        """
        t_s = t_ns * 1e-9
        if self._history and t_s < self._history[-1].t_s:
            self.reset()
        seen = v if self._uses_velocity else self._still
        self._constant.take(t_s, tau)
        if self._is_plain(t_s, q, seen, tau):
            if math.isnan(self._started_s):
                self._started_s = t_s
            return Verdict(q, v, tau, {}, self._leapt)
        causes: dict[int, str] = {}
        remarks: dict[int, str] = {}
        tau = self._judge_effort(tau, causes, remarks)
        whole = self._judge_limits(q, seen, causes)
        whole |= self._judge_jump(t_s, q, causes)
        if not whole and _finite(q) and _finite(seen):
            self._remember(t_s, q, seen, tau)
            if t_s - self._looked_s >= _LOOK_S:
                self._looked_s = t_s
                self._look(t_s)
        whole |= self._judge_agreement(t_s, q, seen, causes)
        tau = self._constant.judge(t_s, tau, self.moving.tolist(), causes)
        if whole:
            q = np.full(len(q), np.nan)
            self._started_s = math.nan
        elif math.isnan(self._started_s):
            self._started_s = t_s
        return Verdict(q, v, tau, causes, self._leapt | remarks)

    def _is_plain(self, t_s: float, q: FloatArray, v: FloatArray, tau: FloatArray) -> bool:
        """Take a sample that gives no cause to look closer, as nearly all are; tell if it is."""
        history, trusted = self._history, self._trusted
        if (
            self._found
            or self._constant.hangs
            or self._doubted
            or trusted is None
            or not history
            or t_s < self._apart_last
            or t_s - trusted.t_s > 1.0
            or t_s - self._looked_s >= _LOOK_S
        ):
            return False
        last, interval = history[-1], self._interval()
        elapsed = t_s - last.t_s
        if elapsed > max(WINDOW_S, 5.0 * interval):
            return False
        rows = np.empty((4, len(q)))
        rows[0], rows[1], rows[2] = q, v, tau
        spans = self._spans
        spans[0], spans[1], spans[2] = t_s - trusted.t_s, _FRAME_S, 2.0 * interval
        if not take_plain_sample(
            t_s,
            rows,
            last.rows,
            elapsed,
            self._limits,
            trusted.rows,
            spans,
            self.steps,
        ):
            return False
        self._trusted = _Place(t_s, trusted.rows)
        self._append(_Sample(t_s, rows))
        return True

    def learn(self, estimate: FloatArray, error: FloatArray) -> None:
        """
        Take the friction that was estimated from the sample judged last.

        :param estimate: tau_f (n,) [Nm or N], NaN where not known.
        :param error: its standard error (n,), NaN where not known.
        """
        self._constant.learn(estimate, error)
        if len(self._history) < 2 or math.isnan(self._started_s):
            return
        last = self._history[-1]
        self._found |= take_friction(
            estimate,
            self.moving,
            self._standing,
            self._most,
            min(last.t_s - self._history[-2].t_s, WINDOW_S),
            last.t_s - self._started_s > _SETTLED_S,
            _STOP_S,
            last.q,
            self._greatest,
            self._beyond_s,
            self._frozen_q,
        )

    def _judge_effort(
        self, tau: FloatArray, causes: dict[int, str], remarks: dict[int, str]
    ) -> FloatArray:
        # Plain floats, here and below: NumPy takes several times as long over a few joints.
        beyond = [i for i, x in enumerate(tau.tolist()) if abs(x) >= self._told[i] < math.inf]
        if not beyond:
            return tau
        tau = np.array(tau, dtype=float)
        for i in beyond:
            said = (
                f'effort {tau[i]:.3g} {self._units[i][1]} where the URDF limits it to '
                f'{self._stated[i].effort:.3g}: check its unit and its cable, or correct the '
                'limit; or it is saturated, and the torque is another'
            )
            if abs(tau[i]) > self._most_effort[i]:
                causes[i], tau[i] = said, np.nan
            else:
                remarks[i] = said
        return tau

    def _judge_limits(self, q: FloatArray, v: FloatArray, causes: dict[int, str]) -> bool:
        if all(
            not abs(speed) > most and not position < least and not position > greatest
            for position, speed, most, least, greatest in zip(
                q.tolist(), v.tolist(), *self._ranges, strict=True
            )
        ):
            return False
        fast = np.abs(v) > self._velocity
        outside = (q < self._lower) | (q > self._upper)
        for i in np.flatnonzero(fast).tolist():
            causes[i] = (
                f'velocity {v[i]:.3g} {self._units[i][0]}/s where the URDF limits it to '
                f'{self._stated[i].velocity:.3g}: check its unit, or correct the limit'
            )
        for i in np.flatnonzero(outside).tolist():
            limit = self._stated[i]
            causes[i] = (
                f'position {q[i]:.4g} {self._units[i][0]} where the URDF allows {limit.lower:.4g} '
                f'to {limit.upper:.4g}: check its unit and its zero, or correct the limits'
            )
        return True

    def _judge_jump(self, t_s: float, q: FloatArray, causes: dict[int, str]) -> bool:
        """Refuse a position that cannot be reached, until it has stood for a while by itself."""
        if not _finite(q):
            return False
        if self._trusted is None or t_s - self._trusted.t_s > 1.0:
            self._trusted, self._doubted = _place(None, t_s, q), []
            return False
        reachable = self._reachable(self._trusted, t_s, q)
        if not all(reachable.tolist()):
            if self._doubted and not self._reachable(self._doubted[-1], t_s, q).all():
                self._doubted = []
            self._doubted.append(_place(self._doubted[-1] if self._doubted else None, t_s, q))
            if t_s - self._doubted[0].t_s < WINDOW_S or len(self._doubted) < _LEAST:
                for i in np.flatnonzero(~reachable).tolist():
                    causes.setdefault(
                        i,
                        f'position jumped by {q[i] - self._trusted.q[i]:.3g} {self._units[i][0]} '
                        f'within {1e3 * (t_s - self._trusted.t_s):.3g} ms, faster than the URDF '
                        'lets it move: check the encoder and its cable, and that one node alone '
                        'publishes joint_states',
                    )
                return True
        before = self._trusted
        if self._doubted:
            first, before = self._doubted[0], self._doubted[-1]
            leapt = ~self._reachable(self._trusted, first.t_s, first.q)
            # What went back is at no place that can be reached from there.
            for i in np.flatnonzero(leapt & self._reachable(before, t_s, q)).tolist():
                self._leapt[i] = (
                    f'position leapt by {first.q[i] - self._trusted.q[i]:.3g} '
                    f'{self._units[i][0]} and stayed: if its zero moved, so did gravity; check '
                    'the encoder, then call ~/reset'
                )
            self._forget()
        self._trusted, self._doubted = _place(before, t_s, q), []
        return False

    def _reachable(self, before: _Place, t_s: float, q: FloatArray) -> BoolArray:
        # Stamps may bunch: two intervals more are granted. And a servo that holds a position
        # between its frames makes the way of a whole frame at once.
        bunched, passed = 2.0 * self._interval(), t_s - before.t_s
        return np.array(
            [
                abs(now - place)
                <= speed * (max(passed, min(t_s - since, _FRAME_S)) + bunched) + 10.0 * step
                for now, place, since, speed, step in zip(
                    q.tolist(),
                    before.q.tolist(),
                    before.since,
                    self._ranges[0],
                    self.steps,
                    strict=True,
                )
            ]
        )

    def _interval(self) -> float:
        """Return the mean interval of the history [s]; long before there is one."""
        if len(self._history) < _LEAST:
            return WINDOW_S
        return (self._history[-1].t_s - self._history[0].t_s) / (len(self._history) - 1)

    def _remember(self, t_s: float, q: FloatArray, v: FloatArray, tau: FloatArray) -> None:
        rows = np.array([q, v, tau, np.zeros(len(q))])
        if self._history and t_s - self._history[-1].t_s > max(WINDOW_S, 5.0 * self._interval()):
            self._forget()
        if self._history:
            last = self._history[-1]
            for i, (now, before) in enumerate(zip(q.tolist(), last.q.tolist(), strict=True)):
                # Less than this is the rounding of the same position.
                if 1e-9 * (1.0 + abs(now)) < abs(now - before) < self.steps[i]:
                    self.steps[i] = abs(now - before)
            rows[3] = last.travel + (0.5 * (t_s - last.t_s)) * (last.v + v)
        self._append(_Sample(t_s, rows))

    def _append(self, sample: _Sample) -> None:
        self._history.append(sample)
        t_s = sample.t_s
        while len(self._history) > _LEAST + 1 and self._history[1].t_s <= t_s - _LONG_S:
            self._history.popleft()

    def _forget(self) -> None:
        """Begin with new evidence: what was before does not belong to what is now."""
        self._history.clear()
        self._apart_until[:] = self._apart_last = -math.inf

    def _look(self, t_s: float) -> None:
        samples = list(self._history)
        first = len(samples) - 1
        while first > 0 and (
            t_s - samples[first].t_s < WINDOW_S or len(samples) - first <= _LEAST
        ):
            first -= 1
        recent = samples[first:]
        enough = t_s - recent[0].t_s >= 0.99 * WINDOW_S and len(recent) > _LEAST
        q = np.array([sample.q for sample in recent])
        noise = seen_noise(q)[1] if len(q) > 2 else np.zeros(q.shape[1])
        room = np.ptp(q, axis=0)
        self.moving = room > _STEPS * np.array(self.steps) + 4.0 * noise
        self._standing = (room == 0.0) & enough
        self._constant.look(t_s, self.moving)
        for joint, recent_friction in enumerate(self._recent):
            recent_friction.append(float(self._greatest[joint]))
            if not self.moving[joint]:
                recent_friction.clear()
            # One more has begun.
            if len(recent_friction) > WINDOW_S / _LOOK_S + 1.0:
                greatest = recent_friction.popleft()
                if greatest > 0.0:
                    seen = self._seen[joint]
                    # Only where the greatest leaves are all the others asked.
                    leaves = len(seen) == _KEPT and seen[0] >= self._friction[joint]
                    seen.append(greatest)
                    self._friction[joint] = (
                        max(seen) if leaves else max(self._friction[joint], greatest)
                    )
            # Short slips do not count.
            if len(self._seen[joint]) >= _KNOWN:
                self._most[joint] = _BREAKAWAY * self._friction[joint]
                if self._has_stopped_dead(samples, joint):
                    self._frozen_q[joint] = samples[-1].q[joint]
                    self._found = True
        self._greatest[:] = 0.0
        if not (enough and self._uses_velocity):
            return
        v = np.array([sample.v for sample in recent])
        steady = np.ptp(v, axis=0) == 0.0
        # An offset of a velocity is granted only where one of the two is alive.
        alive = ~(self._standing & steady & (v[-1] != 0.0))
        apart = self._apart(recent, v, noise, _OFFSET * alive)
        self._frozen_q = np.where(self._standing & apart, q[-1], self._frozen_q)
        # A velocity of which only the zeros are seen is that of a joint that creeps.
        self._frozen_v = np.where(steady & apart & self.moving, v[-1], self._frozen_v)
        # Not for two numbers apart: nothing is frozen then, and the evidence of the longer look
        # must not be forgotten with the finding.
        self._found |= bool((np.isfinite(self._frozen_q) | np.isfinite(self._frozen_v)).any())
        if t_s - samples[0].t_s >= 0.99 * _LONG_S and t_s - self._looked_far_s >= _LONG_LOOK_S:
            self._looked_far_s = t_s
            speeds = np.array([sample.v for sample in samples])
            wrong = self._apart(samples, speeds, noise, _OFFSET)
            self._apart_until = np.where(wrong, t_s + _LONG_S, self._apart_until)
            self._apart_last = float(np.max(self._apart_until))

    def _has_stopped_dead(self, samples: list[_Sample], joint: int) -> bool:
        """
        Tell whether twice the friction in motion would not have stopped a joint as it did.

        With v the speed at t - d, d before the joint stood still, friction was, on average over d,
        tau - g - M (v(t) - v(t - d)) / d, with v(t) = 0 for the joint itself.
        """
        last = len(samples) - 1
        while last > 0 and samples[last - 1].q[joint] == samples[-1].q[joint]:
            last -= 1
        since = samples[last].t_s
        stands = samples[-1].t_s - since
        if since == self._stood_since[joint] or stands < WINDOW_S or len(samples) - last <= _LEAST:
            return False
        self._stood_since[joint] = since
        d = max(_STOP_S, 3.0 * self._interval())
        before = [s for s in samples[: last + 1] if since - s.t_s <= 2.0 * d]
        way = samples[last].q - before[0].q
        span = since - before[0].t_s
        if span < 1.5 * d or abs(way[joint]) <= _STEPS * self.steps[joint]:
            return False
        middle = [s for s in before if since - s.t_s <= d]
        change = samples[last].v - middle[0].v
        change[joint] = -way[joint] / span
        q = samples[last].q
        inertia, gravity = self._robot.inertia(q)[joint], self._robot.gravity(q)[joint]
        effort = float(np.mean([self._correct(s.tau)[joint] for s in middle]))
        friction = effort - gravity - inertia @ change / d
        doubt = inertia[joint] * 2.0 * self.steps[joint] / (span * d)
        return bool(abs(friction) > _BREAKAWAY * self._friction[joint] + doubt)

    def _apart(
        self, samples: list[_Sample], v: FloatArray, noise: FloatArray, offset: FloatArray | float
    ) -> BoolArray:
        """Tell where the way by positions and the way by velocities differ by more than half."""
        by_q = samples[-1].q - samples[0].q
        by_v = samples[-1].travel - samples[0].travel
        speed = np.where(np.isfinite(self._velocity), self._velocity, _SPEED)
        granted = (
            0.5 * np.maximum(np.abs(by_q), np.abs(by_v))
            + _LAG_S * np.ptp(v, axis=0)
            + offset * speed * (samples[-1].t_s - samples[0].t_s)
            + _STEPS * np.array(self.steps)
            + 4.0 * noise
        )
        return np.asarray(np.abs(by_q - by_v) > granted)

    def _judge_agreement(
        self, t_s: float, q: FloatArray, v: FloatArray, causes: dict[int, str]
    ) -> bool:
        if not self._found and t_s >= self._apart_last:
            return False
        found, self._found = self._found, False
        # A position that moves again, or is not there, ends the finding.
        self._frozen_q = np.where(q == self._frozen_q, self._frozen_q, np.nan)
        self._frozen_v = np.where(v == self._frozen_v, self._frozen_v, np.nan)
        frozen_q, frozen_v = np.isfinite(self._frozen_q), np.isfinite(self._frozen_v)
        self._found = bool(frozen_q.any() or frozen_v.any())
        if found and not self._found:
            self._forget()
        apart = self._apart_until > t_s
        for i in np.flatnonzero(frozen_q | frozen_v | apart).tolist():
            if frozen_q[i]:
                causes[i] = (
                    'position stands still to the last bit while velocity or effort say that the '
                    'joint moves: check the encoder; or a brake or a stop holds the joint'
                )
            elif frozen_v[i]:
                causes[i] = (
                    f'velocity stays at {v[i]:.3g} to the last bit while the position moves '
                    'otherwise: check the driver, or set parameter velocity_source to '
                    'position_difference'
                )
            else:
                causes[i] = (
                    'velocity and the change of position differ by more than half: check the unit '
                    'of the velocity and that one node alone publishes joint_states, or set '
                    'parameter velocity_source to position_difference'
                )
        return bool(frozen_q.any() or frozen_v.any() or apart.any())


def _place(before: _Place | None, t_s: float, q: FloatArray) -> _Place:
    """Return where the joints are now; one that stayed came there when it did before."""
    since = (
        np.full(len(q), t_s) if before is None else np.where(q == before.q, before.rows[1], t_s)
    )
    return _Place(t_s, np.array([q, since]))


def _finite(x: FloatArray) -> bool:
    return all(map(math.isfinite, x.tolist()))


def _limit(stated: float) -> float:
    """Return a limit that judges: infinite where it is not stated, or 0 as for not filled in."""
    return stated if 0.0 < stated < math.inf else math.inf
