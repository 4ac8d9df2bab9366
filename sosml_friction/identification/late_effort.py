# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is reported later, or earlier, than between the samples where it acts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.even_stretches import on_lines
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE
from sosml_friction.identification.data_finding import WARNING, DataFinding
from sosml_friction.identification.effort_timing import EffortTiming
from sosml_friction.identification.number_text import plus_minus
from sosml_friction.identification.term_fit import TermFit
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.effort_delay import LARGEST_S, EffortDelay, effort_slope
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, Inner
from sosml_friction.regression.estimate import estimate, with_amplitudes
from sosml_friction.regression.evidence import AT_BOUND
from sosml_friction.regression.nominal import EFFORT_HOLD
from sosml_friction.regression.rival import VERY_STRONG

#: What a finding about it is called.
LATE = 'late_effort'
#: The term that says by how much.
DELAY = EffortDelay.identifier
#: Share of the squares of the slope of effort that is of slow motion. Chosen: of a half, ripple of
#: 42 /rad still made a motor 1.4 ms early (test_ripple_that_the_loop_answers_is_no_early_effort).
_SLOW = 0.75


@dataclass(frozen=True)
class LateEffort:
    """
    Hold by how much effort is late, with its standard error, and the time of samples [s].

    ``samples``: by how many samples effort is taken sooner to undo the delay. Both are negative
    where effort is early, as beside a position that is late: it is then taken later.
    """

    delay_s: float
    std_error: float
    step_s: float
    samples: int

    @classmethod
    def of(cls, fit: TermFit, logs: Sequence[JointLog], undone: int) -> LateEffort | None:
        """
        Return what a fit with a delay found; None unless it shows one very strongly.

        Effort that is early by at most one interval is left as it is. A controller that answers a
        position in the next cycle makes it as early. Friction that follows no law seems to do so
        too: of the EMPS record more is left when this is undone.

        Effort that is early by more has to be so in fast motion, too. A loop with damping answers
        a torque d that the model lacks: with the stiffness K = k + i w b, J a = -S d and
        S = -J w^2 / (K - J w^2), so that d goes with the slope of J a as -w Im S < 0, as of early
        effort. What a model lacks is seen in slow motion: ripple of a fast one is beyond the band.

        :param undone: how many samples sooner the effort of ``logs`` was taken already.
        """
        (term,) = (term for term in fit.linear if term.term == DELAY)
        p, step = term.parameters['delay'], float(np.median([log.step for log in logs]))
        delay = undone * step + p.value
        sure = abs(delay) <= LARGEST_S and p.value**2 > VERY_STRONG * p.std_error**2
        if not sure or term.objection or -step <= delay <= 0.0:
            return None
        if delay < 0.0 and not undone and not _is_early_at_speed(fit, step):
            return None
        # The nearest whole number that is not 0, of the same sign.
        samples = int(np.copysign(max(1, round(abs(delay / step))), delay))
        return cls(delay, p.std_error, step, samples)

    @property
    def left(self) -> EffortTiming:
        """Return the delay that remains when whole samples of it are undone."""
        return EffortTiming(self.delay_s - self.samples * self.step_s, self.std_error)

    def undone(self, log: JointLog) -> JointLog:
        """Return the log with effort taken ``samples`` sooner, without samples that have none."""
        time = log.time
        later = time + self.samples * self.step_s
        after = np.searchsorted(time, later)
        # The last stamp may be off by half a sample.
        after[(after == len(time)) & (later < time[-1] + 0.5 * self.step_s)] = len(time) - 1
        kept = np.flatnonzero((after < len(time)) & (later > time[0] - 0.5 * self.step_s))
        gap = np.append(0.0, np.diff(time))[after[kept]]
        # Into a hole nothing is interpolated; the first sample behind it may be taken itself.
        at = time[after[kept]] - later[kept] < 0.5 * self.step_s
        kept = kept[(gap < HOLE * self.step_s) | at]
        return replace(log, tau=on_lines(later, time, log.tau)).rows(kept)

    def finding(self, stated: bool = False) -> DataFinding:
        """
        Return for a person what was found and done.

        :param stated: whether a hold was stated, with which effort is used as it is.
        """
        told = plus_minus(1e3 * abs(self.delay_s), 1e3 * Z_95 * self.std_error, 'ms')
        number = abs(self.samples)
        when, taken, cause = (
            (
                'after',
                'sooner',
                'a filter or a queue in the driver does so, or the position is early, as a '
                'set-point is that was logged for it',
            )
            if self.samples > 0
            else ('before', 'later', 'a late position does so, or a command logged as effort')
        )
        done = (
            'it was used as its hold is stated, and without --effort-hold is'
            if stated
            else 'it was'
        )
        return DataFinding(
            LATE,
            ALL_JOINTS,
            WARNING,
            f'effort is reported {told} {when} the motion that it makes, and samples are '
            f'{1e3 * self.step_s:.3g} ms apart: {done} taken {number} '
            f'sample{"s" if number > 1 else ""} {taken}; {cause}, mend it there',
        )


class _DelayBySpeed(EffortDelay, registered=False):
    """Add a delay of fast motion, and one of slow motion."""

    amplitudes: ClassVar[Mapping[str, str]] = {'delay': 's', 'slow': 's'}

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return -dtau/dt of either."""
        slope, speed = effort_slope(signals), np.abs(signals.v)
        order = np.argsort(speed, axis=0)
        share = np.cumsum(np.take_along_axis(slope**2, order, axis=0), axis=0)
        at = np.argmax(share >= _SLOW * share[-1], axis=0)
        fast = speed > np.take_along_axis(speed, np.take_along_axis(order, at[None], 0), 0)
        return -np.stack((slope * fast, slope * ~fast), axis=2)


def _is_early_at_speed(fit: TermFit, step: float) -> bool:
    """Tell whether effort is early by more than an interval in fast motion alone."""
    placed = [
        replace(each, term=_DelayBySpeed()).with_inner(fit.laboratory, each.inner)
        if each.term.identifier == DELAY
        else each
        for each in fit.estimate.placed
    ]
    found = estimate(fit.laboratory, placed)
    parts = with_amplitudes(placed, len(fit.laboratory.nominal.bound))
    (k,) = (part.start for each, part in parts if each.term.identifier == DELAY)
    delay, error = float(found.fit.baseline.x[k]), float(found.errors[k])
    return delay < -step and delay**2 > VERY_STRONG * error**2


def is_beyond(fit: TermFit) -> bool:
    """
    Tell whether effort acts outside of the interval between its samples.

    Either its fitted time is at its bound, or the data alone, without the prior, very strongly
    show a time beyond it. With the prior, a slow motion or noisy effort would never show it.
    """
    laboratory = fit.laboratory
    k = laboratory.nominal.names.index(EFFORT_HOLD)
    delay, bound_s = fit.refit[EFFORT_HOLD], float(laboratory.nominal.bound[k])
    if abs(delay) > AT_BOUND * bound_s:
        return True
    bound, prior = laboratory.system.bound.copy(), laboratory.system.prior.copy()
    bound[k] = prior[k] = np.inf
    free = replace(laboratory, system=replace(laboratory.system, bound=bound, prior=prior))
    found = estimate(free, fit.estimate.placed)
    delay, error = float(found.fit.baseline.x[k]), float(found.errors[k])
    return abs(delay) > bound_s and delay**2 > VERY_STRONG * error**2
