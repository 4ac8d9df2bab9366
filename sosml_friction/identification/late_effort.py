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

#: What a finding about it is called, and that which tells the same of a joint by itself.
LATE, BY_JOINT = 'late_effort', 'effort_lag'
#: The term that says by how much.
DELAY = 'effort_delay'


@dataclass(frozen=True)
class LateEffort:
    """
    Hold by how much effort is late, with its standard error, and the time of samples [s].

    ``samples``: how many of them it is taken sooner for that. Of effort that is early, as beside a
    position that is late, both are negative, and it is taken later.
    """

    delay_s: float
    std_error: float
    step_s: float
    samples: int

    @classmethod
    def of(cls, fit: TermFit, logs: Sequence[JointLog], undone: int) -> LateEffort | None:
        """
        Return what a fit with a delay found; None unless it shows one very strongly.

        Effort that is early by an interval at most is left alone: a controller that answers a
        position in the next cycle is as early, and so seems friction that is no law's, as in the
        EMPS record, of which more is left when it is undone.

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
        """Return how late it is still when it is undone by whole samples, as fits found it."""
        return EffortTiming(self.delay_s - self.samples * self.step_s, self.std_error)

    def undone(self, log: JointLog) -> JointLog:
        """Return the samples with the effort of as much later; those without are left out."""
        time = log.time
        later = time + self.samples * self.step_s
        after = np.searchsorted(time, later)
        # By half a sample the clock of the last one may be off.
        after[(after == len(time)) & (later < time[-1] + 0.5 * self.step_s)] = len(time) - 1
        kept = np.flatnonzero((after < len(time)) & (later > time[0] - 0.5 * self.step_s))
        gap = np.append(0.0, np.diff(time))[after[kept]]
        # The first sample behind a hole is as good as any where it is the one that is taken.
        at = time[after[kept]] - later[kept] < 0.5 * self.step_s
        kept = kept[(gap < HOLE * self.step_s) | at]
        return replace(log, tau=on_lines(later, time, log.tau)).rows(kept)

    def finding(self) -> DataFinding:
        """Return for a person what was found and done."""
        told = plus_minus(1e3 * abs(self.delay_s), 1e3 * Z_95 * self.std_error, 'ms')
        number = abs(self.samples)
        when, taken, cause = (
            ('after', 'sooner', 'a filter or a queue in the driver does so')
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
    Tell whether effort is later, or earlier, than between samples it can be.

    It is as late as it can be, or the data alone show it very strongly: beside the prior that it
    is not, data of a slow motion or of noisy effort show nothing, as an interval may be much
    shorter than what they tell.
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
