# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is reported later, or earlier, than between the samples where it acts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.bags.even_stretches import on_lines
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE
from sosml_friction.identification.data_finding import WARNING, DataFinding
from sosml_friction.identification.effort_timing import EffortTiming
from sosml_friction.identification.number_text import plus_minus
from sosml_friction.identification.term_fit import TermFit
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.effort_delay import LARGEST_S
from sosml_friction.model.terms.kinds.term import ALL_JOINTS
from sosml_friction.regression.estimate import estimate
from sosml_friction.regression.evidence import AT_BOUND
from sosml_friction.regression.nominal import EFFORT_HOLD
from sosml_friction.regression.rival import VERY_STRONG

#: What a finding about it is called.
LATE = 'late_effort'
#: The term that says by how much.
DELAY = 'effort_delay'


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

        :param undone: how many samples sooner the effort of ``logs`` was taken already.
        """
        (term,) = (term for term in fit.terms if term.term == DELAY)
        p, step = term.parameters['delay'], float(np.median([log.step for log in logs]))
        delay = undone * step + p.value
        sure = abs(delay) <= LARGEST_S and p.value**2 > VERY_STRONG * p.std_error**2
        if not sure or term.objection or -step <= delay <= 0.0:
            return None
        return cls(delay, p.std_error, step, _whole(delay / step))

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

    def finding(self) -> DataFinding:
        """Return for a person what was found and done."""
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
        return DataFinding(
            LATE,
            ALL_JOINTS,
            WARNING,
            f'effort is reported {told} {when} the motion that it makes, and samples are '
            f'{1e3 * self.step_s:.3g} ms apart: it was taken {number} '
            f'sample{"s" if number > 1 else ""} {taken}; {cause}, mend it there',
        )


def _whole(samples: float) -> int:
    """Return the nearest whole number that is not 0, of the same sign."""
    return int(np.copysign(max(1, round(abs(samples))), samples))


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
