# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Velocity from quantised positions."""

import math
from collections import deque

from sosml_friction.exceptions import ConfigurationError


class WindowedSlope:
    """
    Estimate velocity as the least-squares slope of the last N positions over their stamps.

    With samples T apart and constant acceleration the slope is exactly the velocity at the middle
    of the window, so the lag is (N - 1) / 2 * T. White position noise sigma_q, of which rounding
    to a step D counts D / sqrt(12), becomes sigma_v = sigma_q sqrt(12 / (N (N^2 - 1))) / T. At
    N = 11 and T = 2 ms: lag 10 ms, and the 0.01 degree steps of an RMD-X leave 2.4 mrad/s where
    the difference of two neighbours would leave 36. Uneven stamps are used as they are.

    :param window: N >= 2.
    :param gap_ns: an interval between two samples longer than this starts a new window, as does
        a stamp that does not increase.
    :raises ConfigurationError: if the window is below two samples or the gap is not positive.
    """

    def __init__(self, window: int, gap_ns: int) -> None:
        if window < 2 or gap_ns <= 0:
            raise ConfigurationError(
                f'a velocity window of {window} samples with gaps up to {gap_ns} ns cannot give a '
                'slope: take at least 2 samples and a positive gap'
            )
        self.window = window
        self.gap_ns = gap_ns
        self._samples: deque[tuple[int, float]] = deque(maxlen=window)

    def reset(self) -> None:
        """Forget all samples."""
        self._samples.clear()

    def update(self, t_ns: int, q: float) -> float:
        """
        Take one position and return the velocity [rad/s or m/s], NaN until the window is full.

        :param t_ns: stamp of the measurement [ns].
        :param q: position [rad or m]; NaN starts a new window.
        """
        samples = self._samples
        if samples and not 0 < t_ns - samples[-1][0] <= self.gap_ns:
            samples.clear()
        if math.isnan(q):
            samples.clear()
            return math.nan
        samples.append((t_ns, q))
        if len(samples) < self.window:
            return math.nan
        t0, q0 = samples[0]
        t = [(stamp - t0) * 1e-9 for stamp, _ in samples]
        mean = sum(t) / self.window
        numerator = denominator = 0.0
        for time, (_, position) in zip(t, samples, strict=True):
            offset = time - mean
            numerator += offset * (position - q0)
            denominator += offset * offset
        return numerator / denominator


def lag(window: int, period: float) -> float:
    """Return the lag of a window of ``window`` samples ``period`` [s] apart [s]."""
    return 0.5 * (window - 1) * period
