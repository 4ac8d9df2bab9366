# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is reported later, or earlier, than between the samples where it acts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import HOLE
from sosml_friction.identification.data_finding import WARNING, DataFinding
from sosml_friction.identification.effort_timing import EffortTiming
from sosml_friction.identification.number_text import of_joint, plus_minus
from sosml_friction.identification.shared_time import precision_of, shared_time, told_once
from sosml_friction.identification.term_fit import TermFit
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.effort_delay import (
    LARGEST_S,
    EffortDelay,
    JointEffortDelay,
    effort_slope,
)
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, Inner
from sosml_friction.regression.estimate import Estimate, estimate
from sosml_friction.regression.evidence import AT_BOUND
from sosml_friction.regression.nominal import EFFORT_HOLD
from sosml_friction.regression.placed import with_amplitudes
from sosml_friction.regression.rival import VERY_STRONG

#: What a finding about it is called.
LATE = 'late_effort'
#: The term that says by how much.
DELAY = EffortDelay.identifier
#: Share of the squares of the slope of effort that is of slow motion. Chosen: of a half, ripple of
#: 42 /rad still made a motor 1.4 ms early (test_ripple_that_the_loop_answers_is_no_early_effort).
_SLOW = 0.75


#: Share of a sampling interval by which effort that acts within it is late or early at most: one
#: that holds from its sample on is half of it early, a mean up to its sample half of it late.
_WITHIN = 0.5


@dataclass(frozen=True)
class LateEffort:
    """
    Hold by how much effort of a joint is late, with its standard error, and samples are apart [s].

    ``samples``: by how many samples effort is taken sooner to undo the delay. Both are negative
    where effort is early, as beside a position that is late: it is then taken later.
    """

    delay_s: float
    std_error: float
    step_s: float
    samples: int

    @property
    def left(self) -> EffortTiming:
        """Return the delay that remains when whole samples of it are undone."""
        return EffortTiming(self.delay_s - self.samples * self.step_s, self.std_error)

    def sentence(self, joint: str, stated: bool = False) -> str:
        """
        Return for a person what was found and done, without a full stop.

        :param joint: whose effort it is; ``*`` for all.
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
        return (
            f'effort{of_joint(joint)} is reported {told} {when} the motion that it makes, and '
            f'samples are {1e3 * self.step_s:.3g} ms apart: {done} taken {number} '
            f'sample{"s" if number > 1 else ""} {taken}; {cause}, mend it there'
        )


#: By joint, those whose effort is late or early.
Late = Mapping[str, LateEffort]


def late_findings(late: Late, names: Sequence[str], stated: bool = False) -> list[DataFinding]:
    """
    Return for a person what was found and done.

    :param names: of all joints; ``stated`` as in :meth:`LateEffort.sentence`.
    """
    return [
        DataFinding(LATE, joint, WARNING, each.sentence(joint, stated))
        for joint, each in told_once(late, names).items()
    ]


def delays_of(joints: Sequence[str]) -> list[str]:
    """Return the terms by which efforts of joints are late, each by its own time."""
    return [f'{DELAY}@{joint}' for joint in joints] if len(joints) > 1 else [DELAY]


def sooner(late: Late, joints: Iterable[str]) -> FloatArray:
    """Return by how much the effort of each joint was taken sooner (n,) [s]."""
    return np.array(
        [late[joint].samples * late[joint].step_s if joint in late else 0.0 for joint in joints]
    )


def undone(late: Late, log: JointLog) -> JointLog:
    """Return the log with effort taken ``samples`` sooner, without samples that have none."""
    time, tau = log.time, log.tau.copy()
    known = np.ones(len(log), dtype=np.bool_)
    for joint, each in late.items():
        i = log.names.index(joint)
        later = time + each.samples * each.step_s
        after = np.searchsorted(time, later)
        # The last stamp may be off by half a sample.
        after[(after == len(time)) & (later < time[-1] + 0.5 * each.step_s)] = len(time) - 1
        known &= (after < len(time)) & (later > time[0] - 0.5 * each.step_s)
        after = np.minimum(after, len(time) - 1)
        gap = np.append(0.0, np.diff(time))[after]
        # Into a hole nothing is interpolated; the first sample behind it may be taken itself.
        at = time[after] - later < 0.5 * each.step_s
        known &= (gap < HOLE * each.step_s) | at
        tau[:, i] = np.interp(later, time, log.tau[:, i])
    return replace(log, tau=tau).rows(known)


def find_late(fit: TermFit, logs: Sequence[JointLog], before: Late, beyond: Sequence[str]) -> Late:
    """
    Return what a fit with delays found; as before unless it shows one very strongly.

    Effort that is early by at most one interval is left as it is. A controller that answers a
    position in the next cycle makes it as early. Friction that follows no law seems to do so
    too: of the EMPS record more is left when this is undone.

    Effort that is early by more has to be so in fast motion, too. A loop with damping answers
    a torque d that the model lacks: with the stiffness K = k + i w b, J a = -S d and
    S = -J w^2 / (K - J w^2), so that d goes with the slope of J a as -w Im S < 0, as of early
    effort. What a model lacks is seen in slow motion: ripple of a fast one is beyond the band.

    :param before: by what the effort of ``logs`` was taken sooner already.
    :param beyond: joints whose effort acts outside of the interval between its samples.
    """
    step = float(np.median([log.step for log in logs]))
    found = {
        fit.names[0] if term.joint == ALL_JOINTS else term.joint: term.parameters['delay']
        for term in fit.linear
        if term.term == DELAY
    }
    undone_before = sooner(before, found)
    changes, precision = shared_time(
        np.array([p.value for p in found.values()]),
        precision_of(np.array([p.std_error for p in found.values()])),
        undone_before,
    )
    delays = changes + undone_before
    alike = len(found) > 1 and bool(np.all(delays == delays[0]))
    early = [] if before or not (changes < 0.0).any() else _early_at_speed(fit, step)
    result = dict(before)
    each = zip(found, delays.tolist(), changes.tolist(), precision.tolist(), strict=True)
    for joint, delay, change, p in each:
        samples = round(abs(delay / step))
        # Within an interval it is where in it a sample is taken.
        sure = _WITHIN * step < abs(change) and change**2 * p > VERY_STRONG
        sure &= abs(delay) <= LARGEST_S and not -step <= delay <= 0.0
        if not sure or not (alike or samples or joint in beyond):
            continue
        if delay < 0.0 and not before and joint not in early:
            continue
        # The nearest whole number that is not 0, of the same sign.
        samples = int(np.copysign(max(1, samples), delay))
        result[joint] = LateEffort(delay, float(p**-0.5), step, samples)
    return result


class _DelayBySpeed(JointEffortDelay):
    """Add a delay of fast motion, and one of slow motion."""

    amplitudes: ClassVar[Mapping[str, str]] = {'delay': 's', 'slow': 's'}

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return -dtau/dt of either."""
        slope, speed = effort_slope(signals)[:, joint], np.abs(signals.v[:, joint])
        order = np.argsort(speed)
        share = np.cumsum(slope[order] ** 2)
        fast = speed > speed[order[np.argmax(share >= _SLOW * share[-1])]]
        return signals.in_joint(joint, -slope * fast, -slope * ~fast)


def _early_at_speed(fit: TermFit, step: float) -> list[str]:
    """Return the joints whose effort is early by more than an interval in fast motion alone."""
    placed = [
        replace(each, term=_DelayBySpeed()).with_inner(fit.laboratory, each.inner)
        if each.term.identifier == DELAY
        else each
        for each in fit.estimate.placed
    ]
    parts = with_amplitudes(placed, len(fit.laboratory.nominal.bound))
    own = {
        fit.names[each.joint]: part.start for each, part in parts if each.term.identifier == DELAY
    }
    return _strongly(estimate(fit.laboratory, placed), own, lambda joint, delay: delay < -step)


def beyond_interval(fit: TermFit, late: Late) -> list[str]:
    """
    Return the joints whose effort acts outside of the interval between its samples.

    Either the fitted time is at its bound, or the data alone, without the prior, very strongly
    show a time beyond it. With the prior, a slow motion or noisy effort would never show it.

    :param late: joints whose effort the fit has sooner than recorded.
    """
    laboratory = fit.laboratory
    columns = hold_columns(fit)
    bound, prior = laboratory.system.bound.copy(), laboratory.system.prior.copy()
    limits = {joint: float(bound[k]) for joint, k in columns.items()}
    at_bound = {
        joint: abs(fit.refit[laboratory.nominal.names[k]]) > AT_BOUND * limits[joint]
        for joint, k in columns.items()
    }
    own = list(columns.values())
    bound[own] = prior[own] = np.inf
    free = replace(laboratory, system=replace(laboratory.system, bound=bound, prior=prior))
    shown = _strongly(
        estimate(free, fit.estimate.placed),
        columns,
        lambda joint, delay: abs(delay) > limits[joint],
        sooner(late, columns),
    )
    return [joint for joint in columns if at_bound[joint] or joint in shown]


def _strongly(
    found: Estimate,
    columns: Mapping[str, int],
    such: Callable[[str, float], bool],
    before: FloatArray | None = None,
) -> list[str]:
    """
    Return the joints whose delay is such a one, and very strongly one at all.

    :param before: by how much the effort of each was taken sooner (n,) [s].
    """
    k = list(columns.values())
    delays, precision = shared_time(found.fit.baseline.x[k], precision_of(found.errors[k]), before)
    return [
        joint
        for joint, delay, p in zip(columns, delays.tolist(), precision.tolist(), strict=True)
        if such(joint, delay) and delay**2 * p > VERY_STRONG
    ]


def hold_columns(fit: TermFit) -> dict[str, int]:
    """Return by joint the nominal column of when within an interval its effort acts."""
    names = fit.laboratory.nominal.names
    own = {joint: f'{joint} {EFFORT_HOLD}' for joint in fit.names}
    return {joint: names.index(name) for joint, name in own.items() if name in names}
