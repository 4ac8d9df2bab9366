# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How good an estimate of friction is: error, noise, settling after a reversal, loop width."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.study.condition import Observation

#: Everything is judged from this time on [s]: the observers start from zero.
SCORED_FROM_S = 0.5
#: How long after a reversal the error is followed [s], and what counts as settled (of the jump).
SETTLE_WINDOW_S, SETTLED = 0.8, 0.1
#: A mean error whose noise is more than this share of what counts as settled tells nothing.
_HIDDEN = 0.25
#: The true friction is steady if over the first number [s] it changed by at most the second, as a
#: share of its range. Chosen, no measurement.
STEADY_S, STEADY = 0.25, 0.1


@dataclass(frozen=True)
class Score:
    """
    Hold the figures of one joint, torques in Nm; NaN where there is none.

    :param rmse: of each observation on its own, (K,).
    :param noise_std: standard deviation over the seeds, where the truth is steady.
    :param settle_s: time after a reversal from which the mean error stays below 10 % of the jump;
        NaN if it does not within 0.8 s, if noise hides it, or if there is no reversal.
    :param loop_width: estimate while velocity crosses zero downwards minus that upwards.
    """

    rmse: FloatArray
    noise_std: float
    settle_s: float
    loop_width: float


def score(
    observations: Sequence[Observation], estimates: Sequence[FloatArray], joint: int, noisy: bool
) -> Score:
    """
    Return the figures of an ensemble of observations of the same run.

    The RMSE is over t > 0.5 s. The noise is what differs between seeds (variance with K - 1), so
    neither lag nor offset counts as noise. Settling and loop width are of the errors at all
    reversals of all observations: see :func:`settle_time` and :func:`loop_width`.

    :param noisy: whether the observations differ by noise alone; if not, or with one of them, the
        noise is NaN.
    """
    first = observations[0]
    time, truth = first.time, first.friction[:, joint]
    errors = np.array([estimate[:, joint] - truth for estimate in estimates])
    scored = time > SCORED_FROM_S
    rmse = np.sqrt(np.mean(errors[:, scored] ** 2, axis=1))
    noise, anywhere = np.nan, 0.0
    if noisy and len(errors) > 1:
        variance = np.var(errors, axis=0, ddof=1)
        noise = float(np.sqrt(np.mean(variance[scored & is_steady(time, truth)])))
        anywhere = float(np.sqrt(np.mean(variance[scored]) / len(errors)))
    mean = errors.mean(axis=0)
    v = first.velocity[:, joint]
    return Score(
        rmse, noise, settle_time(time, v, truth, mean, anywhere), loop_width(time, v, mean)
    )


def is_steady(time: FloatArray, truth: FloatArray) -> BoolArray:
    """
    Tell where the truth has been steady for 0.25 s, to 10 % of its range, (N,).

    :param time: equidistant (N,) [s].
    """
    count = max(1, round(STEADY_S / (time[1] - time[0])))
    steady = np.zeros(len(truth), dtype=bool)
    past = np.lib.stride_tricks.sliding_window_view(truth, count + 1)
    steady[count:] = np.ptp(past, axis=1) <= STEADY * np.ptp(truth)
    return steady


def reversals(time: FloatArray, velocity: FloatArray) -> IndexArray:
    """Return the last sample before each change of sign of the velocity after 0.5 s."""
    crosses = velocity[:-1] * velocity[1:] < 0.0
    # A sample at zero itself counts once, if the signs on its sides differ.
    at_zero = np.zeros_like(crosses)
    at_zero[1:] = (velocity[1:-1] == 0.0) & (velocity[:-2] * velocity[2:] < 0.0)
    return np.flatnonzero((crosses | at_zero) & (time[:-1] > SCORED_FROM_S))


def settle_time(
    time: FloatArray,
    velocity: FloatArray,
    truth: FloatArray,
    error: FloatArray,
    noise: float = 0.0,
) -> float:
    """
    Return the time after a reversal from which the mean error stays below 10 % of the jump [s].

    The errors after all reversals, each with the sign of its new direction, are averaged; the jump
    is the range of the truth within 0.8 s on either side. NaN if there is no reversal with 0.8 s
    on both its sides, if the mean error is above 10 % until the end of them, or if noise hides it:
    if its standard deviation is not below a quarter of those 10 %.

    :param noise: standard deviation of ``error`` [Nm].
    """
    dt = time[1] - time[0]
    window = round(SETTLE_WINDOW_S / dt)
    found = [k for k in reversals(time, velocity) if window <= k < len(time) - window - 1]
    if not found:
        return float('nan')
    mean = np.zeros(window)
    jump = 0.0
    for k in found:
        mean += np.sign(velocity[k + 1]) * error[k + 1 : k + 1 + window] / len(found)
        jump += float(np.ptp(truth[k - window : k + window])) / len(found)
    limit = SETTLED * jump
    if noise / np.sqrt(len(found)) > _HIDDEN * limit:
        return float('nan')
    return settled_after(mean, limit, dt)


def settled_after(error: FloatArray, limit: float, dt: float) -> float:
    """Return the time after which an error stays below a limit [s], NaN if it does not."""
    # Not "at or above": an error that is not a number has not settled.
    outside = np.flatnonzero(~(np.abs(error) < limit))
    if not len(outside):
        return 0.0
    return float('nan') if outside[-1] == len(error) - 1 else float((outside[-1] + 1) * dt)


def loop_width(time: FloatArray, velocity: FloatArray, error: FloatArray) -> float:
    """
    Return how far the branches of an estimate lie apart where the velocity is zero [Nm].

    The downward crossings minus the upward ones, which is positive for an estimate that lags; the
    true law has one value there, so it is counted in the error. Where a motion crosses zero in one
    direction only, the other branch is taken to mirror it. For this the mean error is
    subtracted: an offset is no width.
    """
    error = error - error[time > SCORED_FROM_S].mean()
    found = reversals(time, velocity)
    if not len(found):
        return float('nan')
    share = velocity[found] / (velocity[found] - velocity[found + 1])
    crossing = error[found] + share * (error[found + 1] - error[found])
    way = np.sign(velocity[found + 1])
    return float(-2.0 * np.mean(way * crossing))
