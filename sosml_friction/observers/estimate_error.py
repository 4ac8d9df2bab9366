# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The standard error of an estimate on line: the noise that is seen, behind the observer's lag."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.observers.observer import Observer
from sosml_friction.observers.signal_noise import seen_noise

#: Samples the noise is measured over, and between two such measurements. Chosen: the median of
#: 200 differences is within some 10 % of its limit, and one in 50 samples costs little.
_SPAN = 200
_EVERY = 50
#: Settled: what is left of a step is below this share.
_LEFT = 0.05
#: Length of the impulse responses [s]: the slowest observer of the recipes has settled.
_RESPONSE_S = 5.0
#: Time over which the scatter of the estimate itself is followed [s], in so many samples of a
#: settling time. Chosen: twice the slowest response, some 70 settling times of a fast observer.
_SCATTER_S = 10.0
_PER_SETTLING = 5
#: How often it is measured anew in that time. Chosen, no measurement: it changes no faster.
_TIMES = 20
#: Relative standard deviation of 1.4826 times the median of n independent sizes, times sqrt(n).
_MEDIAN_ERROR = 1.17
#: Scatter that exceeds what white noise makes by more than this many of these is no chance.
_SURE = 3.0
#: At most so many samples of them, and none below so many stamps. Chosen: 10 kHz for those 5 s.
_LONGEST = 50_000
_FEWEST = 10


class EstimateError:
    """
    Follow the noise of velocity and effort, and what of it passes an observer.

    With g the response of the estimate to the true disturbance, sampled every h ::

        s^2 = s_tau^2 sum_k g_k^2 + (s_p / h)^2 sum_k (g_k - g_{k-1})^2

    for white noise of effort, s_tau, and of momentum, s_p^2 = sum_j M_ij^2 s_v,j^2, both measured
    from second differences over the last 200 samples, and each at least step / sqrt(12) of the
    resolution that is seen, which a signal at rest hides. Noise below half a step does not dither
    it: effort is then off by up to that half for as long as it stays, and step^2 / 12 is added
    whole. Where no noise and no step was seen, nothing is known.

    Noise that is not white, as of values that are held or filtered, passes the observer better
    than its differences say. So s is at least the scatter of the estimate e itself, where that is
    more than white noise makes by chance ::

        1.4826 median |e(t) - 2 e(t - T) + e(t - 2 T)| / sqrt(6)

    over the last 10 s, T the settling time, after which estimates are independent; friction that
    changes for most of these times counts as well. It is that of noise alone: not of a wrong
    model, of a wrong scale, nor of the lag after a change.

    :param observer: that is linear, or has a linear part (``lag_filter``). Without one (1 / 1) the
        error is not known.
    """

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self._n = observer.n
        self._samples: deque[tuple[float, FloatArray, FloatArray]] = deque(maxlen=_SPAN)
        # The finest step of velocity and of effort that was seen.
        self._steps = np.full((2, self._n), np.inf)
        # Compile now: at the fiftieth sample it would stall the node.
        seen_noise(np.zeros((_FEWEST, self._n)))
        self._since = 0
        # The estimates of the last time, oldest first, one in ``stride`` samples.
        self._estimates = np.empty((0, self._n))
        self._stride = self._skipped = 0
        # Their scatter, and how many times that of white noise it may be by chance.
        self._scatter = np.zeros((2, self._n))
        self._scattered_s = -math.inf
        self._value = np.full(self._n, np.nan)
        self._settling = np.full(self._n, np.nan)
        self._h = math.nan
        self._gains: list[tuple[float, float]] = []
        self._known_since = np.full(self._n, np.nan)
        _settled_error(
            0.0, np.zeros(self._n, dtype=bool), self._known_since, self._settling, self._value
        )

    def update(
        self,
        t_s: float,
        v: FloatArray,
        tau: FloatArray,
        inertia: FloatArray,
        estimate: FloatArray,
    ) -> FloatArray:
        """
        Return the standard error (n,) [Nm or N], NaN where the estimate is not known or settles.

        :param t_s: stamp [s].
        :param v: velocity as the observer has it (n,) [rad/s or m/s].
        :param tau: effort (n,) [Nm or N].
        :param inertia: M (n, n) at this sample.
        :param estimate: tau_f (n,) [Nm or N], NaN where there is none.
        """
        if self._samples and t_s < self._samples[-1][0]:
            self._samples.clear()
            self._estimates[:] = np.nan
            self._scattered_s = -math.inf
            self._known_since[:] = np.nan
        self._samples.append((t_s, np.array(v), np.array(tau)))
        self._since += 1
        self._skipped += 1
        if 0 < self._stride <= self._skipped:
            self._skipped = 0
            self._estimates[:-1] = self._estimates[1:]
            self._estimates[-1] = estimate
        if self._since >= _EVERY:
            self._since = 0
            self._measure(inertia)
        known = np.isfinite(estimate)
        return np.asarray(
            _settled_error(t_s, known, self._known_since, self._settling, self._value)
        )

    def _measure(self, inertia: FloatArray) -> None:
        if len(self._samples) < _FEWEST:
            return
        # The mean: the median of stamps that come in bunches is next to nothing.
        h = (self._samples[-1][0] - self._samples[0][0]) / (len(self._samples) - 1)
        if not (h > 0.0 and np.isfinite(inertia).all()):
            return
        if not abs(h - self._h) <= 0.1 * h:
            self._h = h
            responses = [self._response(h, joint) for joint in range(self._n)]
            self._gains = [
                (float(np.sum(g**2)), float(np.sum(np.diff(g, prepend=0.0) ** 2)) / h**2)
                if len(g)
                else (math.nan, math.nan)
                for g in responses
            ]
            self._settling[:] = [h * _settled(g) if len(g) else 0.0 for g in responses]
            slowest = float(self._settling.max())
            self._stride = max(1, round(slowest / h / _PER_SETTLING))
            count = min(round(_SCATTER_S / h / self._stride), _LONGEST)
            self._estimates = np.full((max(count, 1), self._n), np.nan)
        s_v, _ = self._noise(1)
        s_tau, hidden = self._noise(2)
        s_p = np.sqrt(inertia**2 @ s_v**2)
        by_effort, by_momentum = np.array(self._gains).T
        white = s_tau**2 * by_effort + s_p**2 * by_momentum + hidden**2
        white = np.sqrt(np.where(white > 0.0, white, np.nan))
        now = self._samples[-1][0]
        if not now - self._scattered_s < _SCATTER_S / _TIMES:
            self._scattered_s = now
            self._measure_scatter()
        scatter, chance = self._scatter
        self._value[:] = np.where(scatter > chance * white, scatter, white)

    def _noise(self, column: int) -> tuple[FloatArray, FloatArray]:
        """Return the noise of a column (n,), and what of its resolution no noise dithers (n,)."""
        step, noise = seen_noise(np.array([sample[column] for sample in self._samples]))
        finest = self._steps[column - 1] = np.minimum(self._steps[column - 1], step)
        rounding = np.where(finest < np.inf, finest / math.sqrt(12.0), 0.0)
        return np.maximum(noise, rounding), np.where(noise < 0.5 * finest, rounding, 0.0)

    def _measure_scatter(self) -> None:
        """Measure how much the estimate scatters, and how much more than white noise is chance."""
        e, lag = self._estimates, _PER_SETTLING
        bend = np.abs(e[2 * lag :] - 2.0 * e[lag:-lag] + e[: -2 * lag])
        for i in range(self._n):
            own = bend[np.isfinite(bend[:, i]), i]
            if len(own):
                scatter = 1.4826 * np.median(own) / math.sqrt(6.0)
                chance = 1.0 + _SURE * _MEDIAN_ERROR * math.sqrt(lag / len(own))
                self._scatter[:, i] = scatter, chance

    def _response(self, h: float, joint: int) -> FloatArray:
        """Return the response to an impulse; empty where the observer has no filter."""
        b, a = self._observer.lag_filter(h, joint)
        if len(b) == len(a) == 1:
            return np.empty(0)
        count = max(2, min(round(_RESPONSE_S / h), _LONGEST))
        return np.asarray(impulse_response(np.asarray(b, float), np.asarray(a, float), count))


@compiled
def impulse_response(b: FloatArray, a: FloatArray, count: int) -> FloatArray:
    """
    Return the first samples of the response of b(z) / a(z) to an impulse (count,).

    a_0 g_k = b_k - a_1 g_{k-1} - a_2 g_{k-2} - ... As lfilter of SciPy, whose import is half of
    the start of observer_node.
    """
    g = np.zeros(count)
    for k in range(count):
        g[k] = b[k] if k < len(b) else 0.0
        for j in range(1, min(k + 1, len(a))):
            g[k] -= a[j] * g[k - j]
        g[k] /= a[0]
    return g


def _settled(g: FloatArray) -> int:
    """Return after how many samples a step has settled."""
    step = np.cumsum(g)
    off = np.flatnonzero(np.abs(step - step[-1]) > _LEFT * abs(step[-1]))
    return int(off[-1]) + 1 if len(off) else 0


@compiled
def _settled_error(
    t_s: float, known: BoolArray, since: FloatArray, settling: FloatArray, value: FloatArray
) -> FloatArray:
    """
    Return the error (n,), NaN of a joint that is not known or settles.

    :param since: when each became known (n,) [s], NaN where it is not; written.
    :param settling: how long it takes (n,) [s].
    """
    error = np.full(len(value), np.nan)
    for i in range(len(value)):
        if not known[i]:
            since[i] = np.nan
        elif math.isnan(since[i]):
            since[i] = t_s
        if t_s - since[i] >= settling[i]:
            error[i] = value[i]
    return error
