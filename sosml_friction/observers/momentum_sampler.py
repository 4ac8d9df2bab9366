# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From stamped joint states to the momentum and the forcing that drive observers."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numba
import numpy as np
from numba.core.dispatcher import Dispatcher

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.advance import (
    BACKWARDS,
    GAP,
    INTERVAL,
    OUTCOME,
    START,
    UNUSABLE,
    advance,
)
from sosml_friction.observers.momentum_samples import MomentumSamples

#: Where in an interval a sample of effort holds: ``start`` for a command that is held until the
#: next sample, ``mean`` for a value of the moment of its stamp, ``end`` for a mean since the
#: sample before.
EFFORT_HOLDS = ('start', 'mean', 'end')
#: The same for a person.
HOLDS_TOLD = (
    'start for a command that is held, mean for a value measured at its stamp, end for a mean '
    'since the sample before'
)
VELOCITY_SOURCES = ('message', 'position_difference')


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
        #: Share of an interval's effort that is its later sample's, (n,); the rest the earlier's.
        self.later_weight = np.array([EFFORT_HOLDS.index(hold) / 2.0 for hold in holds])
        self.velocity_source = velocity_source
        self.maximum_gap_s = float(maximum_gap_s)
        self._fixed = robot.constants, self.later_weight
        self._differentiated = velocity_source == 'position_difference'
        self._kept = np.zeros(3, dtype=np.int64)
        self._memory = np.empty((4 + robot.n, robot.n))
        # Of a single sample.
        self._stamps = np.zeros((2, 1), dtype=np.int64)
        self._motion = np.empty((3, 1, robot.n))
        self._rows = tuple(self._motion[:, 0])
        self._state = self._stamps, self._motion, self._kept, self._memory
        self._advance: Callable[..., int] = advance
        self._shapes = self._motion.shape, (1, robot.n, robot.n)
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next sample starts the observers."""
        self._kept[:] = 0
        self._stamps[1] = UNUSABLE
        self._memory[:] = np.nan

    @property
    def events(self) -> tuple[str, ...]:
        """Return why the last sample began afresh: gap, backwards; empty if it did not."""
        status = int(self._stamps[1, 0])
        return (
            *(('gap',) if status & GAP else ()),
            *(('backwards',) if status & BACKWARDS else ()),
        )

    @property
    def inertia(self) -> FloatArray:
        """Return M at the last sample that was usable, (n, n); NaN before one."""
        return self._memory[4:].copy()

    @property
    def velocity(self) -> FloatArray:
        """Return the velocity at the last sample, (n,), wherever it comes from."""
        return self._memory[1].copy()

    def stretches(self, log: JointLog) -> list[Stretch]:
        """
        Return what the observers are driven by over a recording, one stretch per fresh start.

        :raises DataError: if a joint of the robot is not in the log.
        """
        log = log.select(self.robot.names)
        self.reset()
        count, n = log.q.shape
        stamps, h = np.array([log.t_ns, log.t_ns]), np.empty(count)
        driven, inertia = np.empty((3, count, n)), np.empty((count, n, n))
        motion = np.array([log.q, log.v, log.tau], dtype=float)
        advance(
            *self._fixed,
            self.maximum_gap_s,
            self._differentiated,
            stamps,
            motion,
            self._kept,
            self._memory,
            h,
            driven,
            inertia,
        )
        outcome = stamps[1] & OUTCOME
        ends = np.flatnonzero((outcome == START) | (outcome == UNUSABLE))
        found = []
        for first, last in zip(ends, [*ends[1:], count], strict=True):
            rows = first + 1 + np.flatnonzero(outcome[first + 1 : last] == INTERVAL)
            if outcome[first] == START and len(rows):
                # A stretch without a repeated stamp is a slice, and no copy.
                own = rows if len(rows) < last - first - 1 else slice(first + 1, last)
                p, integral, forcing = driven[:, own]
                samples = MomentumSamples(h[own], p, integral, forcing, inertia[own])
                found.append(Stretch(rows, driven[0, first].copy(), samples))
        return found

    def _begin_to_take(self) -> None:
        """Compile what takes one sample at a time, which would stall the first."""
        zero = np.zeros(self.robot.n)
        _, samples = self._take(0, zero, zero, zero)
        # Numba looks at the types of arguments in each call, and these are always of this class.
        if isinstance(advance, Dispatcher):
            own = *self._fixed, self.maximum_gap_s, self._differentiated, *self._state
            given = *own, samples.h, self._motion, samples.inertia
            self._advance = advance.get_overload(tuple(map(numba.typeof, given)))
        self.reset()

    def _take(
        self, t_ns: int, q: FloatArray, v: FloatArray, tau: FloatArray
    ) -> tuple[int, MomentumSamples]:
        """
        Take one sample and return its outcome and, where there is one, the interval.

        :param t_ns: stamp of measurement [ns].
        :param q: position (n,) [rad or m].
        :param v: velocity (n,) [rad/s or m/s]; unused with ``position_difference``.
        :param tau: actuator effort at the joint (n,) [Nm or N], NaN where not known.
        """
        self._stamps[0, 0] = t_ns
        position, velocity, effort = self._rows
        position[:], velocity[:], effort[:] = q, v, tau
        # New arrays: an observer may keep them.
        shape, square = self._shapes
        h, driven, inertia = np.empty(1), np.empty(shape), np.empty(square)
        status = self._advance(
            *self._fixed,
            self.maximum_gap_s,
            self._differentiated,
            *self._state,
            h,
            driven,
            inertia,
        )
        return status & OUTCOME, MomentumSamples(h, driven[0], driven[1], driven[2], inertia)
