# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where in an interval between samples a measured effort acted, by the motion it made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import truncnorm

from sosml_friction.identification.number_text import plus_minus
from sosml_friction.model.parameter import Z_95
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
    since the sample before half an interval late. ``std_error`` [s].
    """

    delay_s: float
    std_error: float

    @classmethod
    def of(cls, delay: float, error: float, prior: float, step: float) -> EffortTiming:
        """
        Return the timing that a regression found, anywhere within an interval alike.

        :param delay: what it found beside a Gaussian prior about 0 [s], with this ``error``.
        :param prior: standard deviation of that prior [s].
        :param step: time between samples [s].
        """
        half = 0.5 * step
        # What the data alone say: precisions add up. Nothing, if they are no surer than the prior.
        known = 1.0 - (error / prior) ** 2
        if known <= 0.0:
            return cls(0.0, _ANYWHERE * step)
        mean, spread = delay / known, error / float(np.sqrt(known))
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

    def sentence(self, step: float) -> str:
        """Return for a person what was found, without a full stop."""
        found = self._found() if self.is_told(step) else 'the motion does not tell it either'
        return (
            f'nothing says where between samples effort holds; {found} '
            f'(samples are {1e3 * step:.3g} ms apart), which is in the errors; '
            f'--effort-hold states it: {HOLDS_TOLD}'
        )

    def contradicts(self, hold: str, step: float) -> bool:
        """Tell whether the motion very strongly says another time than a stated hold does."""
        off = self.delay_s - _delay(hold, step)
        return off**2 > VERY_STRONG * self.std_error**2

    def contradiction(self, hold: str, step: float) -> str:
        """Return for a person that the motion contradicts a stated hold, without a full stop."""
        off = abs(self.delay_s - _delay(hold, step)) / self.std_error
        return (
            f'the hold of effort is stated as {hold}, and {self._found()}, '
            f'{off:.0f} standard errors from that (samples are {1e3 * step:.3g} ms apart): '
            f'without --effort-hold it is measured; it states {HOLDS_TOLD}'
        )

    def _found(self) -> str:
        early = 'late' if self.delay_s > 0.0 else 'early'
        told = plus_minus(1e3 * abs(self.delay_s), 1e3 * Z_95 * self.std_error, 'ms')
        return f'by the motion it is reported {told} {early}'


def _delay(hold: str, step: float) -> float:
    """Return how late an effort of a hold is reported [s]."""
    return (0.5 * EFFORT_HOLDS.index(hold) - 0.5) * step
