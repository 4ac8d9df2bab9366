# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From stamped joint states to the momentum and the forcing that drive observers."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.momentum_samples import MomentumSamples

#: Where in an interval a sample of effort holds: ``start`` for a command that is held until the
#: next sample, ``end`` for a measurement of what flowed until now, ``mean`` when neither is known.
EFFORT_HOLDS = ('start', 'mean', 'end')
VELOCITY_SOURCES = ('message', 'position_difference')


@dataclass
class EstimatorCounts:
    """Count what happened to the samples an estimator was given."""

    samples: int = 0
    repeated_stamps: int = 0
    time_backwards: int = 0
    gaps: int = 0
    not_finite: int = 0
    without_effort: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Stretch:
    """
    Hold one uninterrupted run of a recording.

    :param rows: the sample of the log that ends each interval, (N,).
    :param p_start: momentum at the sample before the first interval, (n,).
    """

    rows: IndexArray
    p_start: FloatArray
    samples: MomentumSamples


class Interval(NamedTuple):
    """One row of :class:`MomentumSamples`."""

    h: float
    p: FloatArray
    integral: FloatArray
    forcing: FloatArray
    inertia: FloatArray


class Start(NamedTuple):
    """A sample at which the observers start; ``p`` None where they have to wait for the next."""

    p: FloatArray | None


def stack(intervals: Sequence[Interval]) -> MomentumSamples:
    """Return intervals as the columns that observers are driven by."""
    columns = zip(*intervals, strict=True)
    return MomentumSamples(*(np.array(column) for column in columns))


class MomentumSampler:
    """
    Make intervals of samples (t, q, v, tau).

    The forcing over (t_{k-1}, t_k] is the effort held as ``effort_hold`` says plus the trapezoid
    of C^T q' - g. A sample that is the first, the first after a gap longer than ``maximum_gap_s``,
    after time went backwards (a looping bag), or after one with a position or velocity that is not
    finite begins a new stretch; one with the stamp of its predecessor is dropped. The forcing of a
    joint is NaN over the intervals that need an effort that is missing: the next one with
    ``start``, this one with ``end``, both with ``mean``.

    :param robot: rigid-body terms; its joints are the columns of q, v and tau.
    :param effort_hold: one of :data:`EFFORT_HOLDS` for all joints, or one for each.
    :param velocity_source: ``message``, or ``position_difference``: backward difference over one
        interval, which lags by half of it.
    :raises ConfigurationError: if an option is unknown.
    """

    def __init__(
        self,
        robot: Robot,
        effort_hold: Sequence[str] | str = 'start',
        velocity_source: str = 'message',
        maximum_gap_s: float = 0.05,
    ) -> None:
        holds = [effort_hold] * robot.n if isinstance(effort_hold, str) else list(effort_hold)
        if len(holds) != robot.n or any(hold not in EFFORT_HOLDS for hold in holds):
            raise ConfigurationError(
                f'effort_hold is {effort_hold!r}: use one of {", ".join(EFFORT_HOLDS)} for all '
                f'joints or one for each of {", ".join(robot.names)}'
            )
        if velocity_source not in VELOCITY_SOURCES:
            raise ConfigurationError(
                f'velocity_source is {velocity_source!r}: use one of {", ".join(VELOCITY_SOURCES)}'
            )
        if not maximum_gap_s > 0.0:
            raise ConfigurationError(f'maximum_gap_s is {maximum_gap_s}: it must be positive')
        self.robot = robot
        self._weight_of_end = [EFFORT_HOLDS.index(hold) / 2.0 for hold in holds]
        self.velocity_source = velocity_source
        self.maximum_gap_s = maximum_gap_s
        self.counts = EstimatorCounts()
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next sample starts the observers. Counts are kept."""
        self._t_ns: int | None = None
        self._q = np.full(self.robot.n, np.nan)
        self._started = False
        self._drift = np.full(self.robot.n, np.nan)
        self._tau = np.full(self.robot.n, np.nan)
        self._inertia = np.full((self.robot.n, self.robot.n), np.nan)
        self._v = np.full(self.robot.n, np.nan)

    @property
    def inertia(self) -> FloatArray:
        """Return M at the last sample that was usable, (n, n); NaN before one."""
        return self._inertia

    @property
    def velocity(self) -> FloatArray:
        """Return the velocity at the last sample, (n,), wherever it comes from."""
        return self._v

    def stretches(self, log: JointLog) -> list[Stretch]:
        """
        Return what the observers are driven by over a recording, one stretch per fresh start.

        :raises DataError: if a joint of the robot is not in the log.
        """
        log = log.select(self.robot.names)
        self.reset()
        parts: list[tuple[FloatArray | None, list[int], list[Interval]]] = []
        for k in range(len(log)):
            taken = self.take(int(log.t_ns[k]), log.q[k], log.v[k], log.tau[k])
            if isinstance(taken, Start):
                parts.append((taken.p, [], []))
            elif taken is not None:
                # An interval follows a start.
                parts[-1][1].append(k)
                parts[-1][2].append(taken)
        return [
            Stretch(np.array(rows), p_start, stack(intervals))
            for p_start, rows, intervals in parts
            if p_start is not None and rows
        ]

    def take(
        self, t_ns: int, q: FloatArray, v: FloatArray, tau: FloatArray
    ) -> Interval | Start | None:
        """
        Return the interval that ends at a sample, or a start, or None: repeated stamp.

        :param t_ns: stamp of measurement [ns].
        :param q: position (n,) [rad or m].
        :param v: velocity (n,) [rad/s or m/s]; unused with ``position_difference``.
        :param tau: actuator effort at the joint (n,) [Nm or N], NaN where not known.
        """
        counts = self.counts
        counts.samples += 1
        h = np.nan
        if self._t_ns is not None:
            if t_ns == self._t_ns:
                counts.repeated_stamps += 1
                return None
            h = (t_ns - self._t_ns) * 1e-9
            if h < 0.0:
                counts.time_backwards += 1
                self.reset()
            elif h > self.maximum_gap_s:
                counts.gaps += 1
                self.reset()
        # Copies: a caller may reuse its arrays, and a strided view sums in another order.
        q, tau = np.array(q, dtype=float), np.array(tau, dtype=float)
        q_previous = self._q
        if self.velocity_source == 'position_difference':
            # NaN on a first sample: there is no velocity yet, and so no momentum to start from.
            v = (q - q_previous) / h
        else:
            v = np.array(v, dtype=float)
        self._t_ns, self._q, self._v = t_ns, q, v
        for name, effort in zip(self.robot.names, tau.tolist(), strict=True):
            if not isfinite(effort):
                counts.without_effort[name] = counts.without_effort.get(name, 0) + 1
        # Plain floats, here and below: NumPy takes several times as long over a few joints.
        measured = all(map(isfinite, q.tolist()))
        if not (measured and all(map(isfinite, v.tolist()))):
            if self.velocity_source == 'message' or not measured:
                counts.not_finite += 1
            self._started = False
            return Start(None)
        p, drift, inertia = self.robot.momentum_terms(q, v)
        taken: Interval | Start = Start(p)
        if self._started:
            integral = 0.5 * ((self._inertia + inertia) @ (q - q_previous))
            forcing = self._held(tau) + 0.5 * (self._drift + drift)
            taken = Interval(h, p, integral, forcing, inertia)
        self._started = True
        self._drift, self._tau, self._inertia = drift, tau, inertia
        return taken

    def _held(self, tau: FloatArray) -> FloatArray:
        # A joint whose effort counts from one end only is not lost with the other end's NaN.
        return np.array(
            [
                ((1.0 - w) * before if w < 1.0 else 0.0) + (w * after if w > 0.0 else 0.0)
                for w, before, after in zip(
                    self._weight_of_end, self._tau.tolist(), tau.tolist(), strict=True
                )
            ]
        )
