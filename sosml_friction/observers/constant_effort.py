# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether an effort that is constant to the last bit is measured."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled

#: A joint is in motion for so long after it was seen to move [s]: a reversal is shorter.
_MOTION_S = 0.4
#: The observers have settled after a step of the effort by then [s].
_SETTLED_S = 0.2
#: An effort hangs that is the same for at least so many times as long as it ever was in motion,
#: while friction by it changes by so many of its steps and standard errors: a coarse effort that
#: is right follows the motion within a step or two. Chosen.
_RUNS = 4.0
_STEPS = 3.0
_ERRORS = 6.0


class ConstantEffort:
    """
    Find efforts that are 0.0 or hang: not measured, or saturated.

    At 0.0 an effort is not measured, unless it was something else before and the joint rests, or
    is ``passive``. At another value it hangs if it was never so long the same in motion, and if
    the motion needs another: by a constant effort, what the model needs passes for friction. What
    was the same since the joint rested is not judged: a push of constant effort begins so.

    :param passive: by joint, whether it has no actuator.
    :param zero_s: 0.0 is judged after this time [s], and
    :param zeros: so many samples.
    """

    def __init__(self, passive: Sequence[bool], zero_s: float, zeros: int) -> None:
        self._passive, self._zero_s, self._zeros = passive, zero_s, zeros
        n = len(passive)
        #: As :func:`_take` has it. How long and how fine is kept, whatever else is forgotten.
        self._runs = np.full((6, n), np.nan)
        self._runs[4], self._runs[5] = 0.0, np.inf
        self._ever = np.zeros(n, dtype=bool)
        self.reset()
        # Compile now: at the first sample it would stall the node.
        _take(0.0, np.full(n, np.nan), self._moved_s, np.full((6, n), np.nan))

    def reset(self) -> None:
        """Forget the past but how long an effort was the same in motion, and its steps."""
        n = len(self._passive)
        self._runs[:4] = np.nan
        self._moved_s = np.full(n, -math.inf)
        self._estimate = self._error = np.full(n, np.nan)
        #: By joint: the beginning of a run, and friction by it when the observers had settled.
        self._noted = [(math.nan, math.nan)] * n
        #: By joint: the effort that hangs, NaN where none does.
        self._hung = np.full(n, np.nan)
        self.hangs = False

    def take(self, t_s: float, tau: FloatArray) -> None:
        """Take the effort (n,) of a sample with its stamp [s]."""
        _take(t_s, tau, self._moved_s, self._runs)

    def learn(self, estimate: FloatArray, error: FloatArray) -> None:
        """Take the friction (n,) that was made of it, and its standard error (n,)."""
        self._estimate, self._error = estimate, error

    def look(self, t_s: float, moving: BoolArray) -> None:
        """Find efforts that hang by now; ``moving`` (n,) tells which joints move."""
        self._moved_s[moving] = t_s
        _, since, _, began, longest, step = self._runs.tolist()
        for i, run_s in enumerate(since):
            if not (t_s - run_s >= _SETTLED_S and began[i] and moving[i]) or self._passive[i]:
                continue
            friction = float(self._estimate[i])
            if self._noted[i][0] != run_s or math.isnan(self._noted[i][1]):
                self._noted[i] = run_s, friction
            granted = _STEPS * step[i] + _ERRORS * float(self._error[i])
            needs = abs(friction - self._noted[i][1]) > granted
            if needs and t_s - run_s >= _RUNS * longest[i]:
                self._hung[i] = self._runs[0, i]
                self.hangs = True

    def judge(
        self, t_s: float, tau: FloatArray, moving: Sequence[bool], causes: dict[int, str]
    ) -> FloatArray:
        """Return the effort that was taken last, NaN where not measured; add why to ``causes``."""
        now = self._runs[0]
        # NaN is no effort that was something else.
        self._ever |= (now == now) & (now != 0.0)
        self._hung[self._hung != now] = np.nan
        self.hangs = bool(np.isfinite(self._hung).any())
        values, since, count, _, longest, _ = self._runs.tolist()
        used = tau
        for i, effort in enumerate(values):
            if self._hung[i] == effort:
                said = (
                    f'effort stays at {effort:.3g} to the last bit while the joint moves and '
                    'needs another: its measurement hangs or is saturated; check the driver and '
                    'the limit of its current'
                )
            elif (
                effort == 0.0
                and not self._passive[i]
                and count[i] >= self._zeros
                # A coarse effort is 0.0 for as long as it is anything else.
                and t_s - since[i] >= max(self._zero_s, _RUNS * longest[i])
                and (moving[i] or not self._ever[i])
            ):
                when = 'while the joint moves' if moving[i] else 'since the start'
                said = (
                    f'effort is exactly 0.0 {when}: enable the actuator, or make its driver '
                    'measure effort; a joint without an actuator is named in parameter '
                    'passive_joints'
                )
            else:
                continue
            if used is tau:
                used = np.array(tau, dtype=float)
            used[i] = np.nan
            # What is wrong is no measure of how long an effort may be the same.
            self._runs[3, i] = 0.0
            causes.setdefault(i, said)
        return used


@compiled
def _take(t_s: float, tau: FloatArray, moved_s: FloatArray, runs: FloatArray) -> None:
    """
    Follow for how long each effort is the same to the last bit.

    :param t_s: the stamp [s].
    :param tau: the effort (n,).
    :param moved_s: when each joint was seen to move last (n,) [s].
    :param runs: (6, n), written: the effort; since when it is so [s] and for how many samples;
        1 where that began in motion; the longest that was from motion to motion [s]; the smallest
        step, infinite before one.
    """
    for i in range(len(tau)):
        if tau[i] == runs[0, i]:
            runs[2, i] += 1.0
            continue
        in_motion = t_s - moved_s[i] < _MOTION_S
        if in_motion and runs[3, i] > 0.0:
            runs[4, i] = max(runs[4, i], t_s - runs[1, i])
        step = abs(tau[i] - runs[0, i])
        if step < runs[5, i]:
            runs[5, i] = step
        runs[0, i], runs[1, i], runs[2, i] = tau[i], t_s, 1.0
        runs[3, i] = 1.0 if in_motion else 0.0
