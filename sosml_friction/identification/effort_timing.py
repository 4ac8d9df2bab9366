# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where in an interval between samples a measured effort acted, by the motion it made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import truncnorm

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.even_stretches import UNEVEN
from sosml_friction.identification.data_finding import NOTE, WARNING, DataFinding
from sosml_friction.identification.number_text import of_joint, plus_minus
from sosml_friction.identification.shared_time import precision_of, shared_time, told_once
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.kinds.term import ALL_JOINTS
from sosml_friction.observers.momentum_sampler import EFFORT_HOLDS, HOLDS_TOLD
from sosml_friction.regression.rival import VERY_STRONG

#: What a finding about it is called, and one about a hold that was stated.
TIMING, STATED = 'effort_timing', 'effort_hold'
#: Standard deviation of what is anywhere within an interval alike, as a share of it.
_ANYWHERE = float(1.0 / np.sqrt(12.0))


@dataclass(frozen=True)
class EffortTiming:
    """
    Hold how late an effort is reported: ``delay_s`` after it acted, at a sample's own time.

    A command that is held until the next sample is half an interval early, a mean of the time
    since the sample before half an interval late, each of the median interval. ``std_error`` [s].
    """

    delay_s: float
    std_error: float

    @classmethod
    def of(
        cls,
        delays: FloatArray,
        errors: FloatArray,
        prior: float,
        step: float,
        sooner: FloatArray | None = None,
    ) -> list[EffortTiming]:
        """
        Return the timing of each joint that a regression found, one if they do not differ.

        :param delays: what it found beside a Gaussian prior about 0 (n,) [s], with ``errors``.
        :param prior: standard deviation of that prior [s].
        :param step: time between samples [s].
        :param sooner: as of :func:`~.shared_time.shared_time`.
        """
        # What the data alone say: precisions add up. Nothing, if they are no surer than the prior.
        whole = precision_of(errors)
        precision = np.maximum(0.0, whole - prior**-2.0)
        means = np.divide(delays * whole, precision, np.zeros_like(delays), where=precision > 0.0)
        pairs = zip(*shared_time(means, precision, sooner), strict=True)
        return [cls._within(float(mean), float(p), step) for mean, p in pairs]

    @classmethod
    def _within(cls, mean: float, precision: float, step: float) -> EffortTiming:
        """Return the timing that data say, anywhere within an interval alike."""
        half = 0.5 * step
        if not precision > 0.0:
            return cls(0.0, _ANYWHERE * step)
        spread = precision**-0.5
        low, high = (-half - mean) / spread, (half - mean) / spread
        told = truncnorm(low, high, mean, spread)
        found, error = float(told.mean()), float(told.std())
        if not (np.isfinite(found) and abs(found) <= half and error > 0.0):
            # Beyond the interval, by more than a number can hold: its end.
            return cls(float(np.clip(mean, -half, half)), spread)
        return cls(found, error)

    def later(self, step: float) -> float:
        """Return the share of an interval's effort that is its later sample's."""
        return float(np.clip(0.5 + self.delay_s / step, 0.0, 1.0))

    def is_told(self, step: float) -> bool:
        """Tell whether the motion says anything: it is surer than anywhere within an interval."""
        return self.std_error < _ANYWHERE * step

    def hold(self, step: float) -> str:
        """Return the nearest of the holds that an observer knows."""
        return min(EFFORT_HOLDS, key=lambda hold: abs(self.delay_s - _delay(hold, step)))

    def sentence(self, step: float, joint: str = ALL_JOINTS) -> str:
        """Return for a person what was found of a joint, without a full stop."""
        found = self._found() if self.is_told(step) else 'the motion does not tell it either'
        return (
            f'nothing says where between samples effort{of_joint(joint)} holds; {found} '
            f'(samples are {1e3 * step:.3g} ms apart), which is in the errors; '
            f'--effort-hold states it: {HOLDS_TOLD}'
        )

    def contradicts(self, hold: str, step: float) -> bool:
        """
        Tell whether the motion very strongly says another time than a stated hold does.

        By less than what steps that count as even make it later it contradicts none.
        """
        off = self.delay_s - _delay(hold, step)
        return abs(off) > UNEVEN * step and off**2 > VERY_STRONG * self.std_error**2

    def contradiction(self, hold: str, step: float, joint: str = ALL_JOINTS) -> str:
        """Return for a person that the motion contradicts a stated hold, without a full stop."""
        off = abs(self.delay_s - _delay(hold, step)) / self.std_error
        return (
            f'the hold of effort{of_joint(joint)} is stated as {hold}, and {self._found()}, '
            f'{off:.0f} standard errors from that (samples are {1e3 * step:.3g} ms apart): '
            f'without --effort-hold it is measured; it states {HOLDS_TOLD}'
        )

    def _found(self) -> str:
        early = 'late' if self.delay_s > 0.0 else 'early'
        told = plus_minus(1e3 * abs(self.delay_s), 1e3 * Z_95 * self.std_error, 'ms')
        return f'by the motion it is reported {told} {early}'


def timing_findings(timing: Mapping[str, EffortTiming], step: float) -> list[DataFinding]:
    """Return for a person when effort of the joints acts, once where all are alike."""
    return [
        DataFinding(TIMING, joint, NOTE, each.sentence(step, joint))
        for joint, each in told_once(timing, list(timing)).items()
    ]


def stated_findings(
    timing: Mapping[str, EffortTiming], hold: str, step: float
) -> list[DataFinding]:
    """Return for a person where the motion contradicts a hold that was stated for all joints."""
    return [
        DataFinding(STATED, joint, WARNING, each.contradiction(hold, step, joint))
        for joint, each in told_once(timing, list(timing)).items()
        if each.contradicts(hold, step)
    ]


def _delay(hold: str, step: float) -> float:
    """Return how late an effort of a hold is reported [s]."""
    return (0.5 * EFFORT_HOLDS.index(hold) - 0.5) * step
