# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What gains will do, before they are used: noise and settling in a simulated to and fro."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.observers.kinds.kalman_stribeck import SMOOTHING_VELOCITY
from sosml_friction.observers.log_conditions import LogConditions, slope_weights
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.registry import make_observer
from sosml_friction.study.metrics import SETTLED, settled_after

#: Runs with different noise: the fewest, the most, and the standard error of the mean error, as a
#: share of the friction jump, at which they are enough. Chosen, no measurement.
_SEEDS, _MOST_SEEDS, _KNOWN = 6, 32, 0.025
#: Reversals in a run, of which the first half are for learning, and bounds of their spacing [s].
_REVERSALS, _LEARNED, _SHORTEST, _LONGEST = 6, 3, 0.4, 3.0
#: Noise counts late in a way, and all ends before the next reversal begins.
_LATE, _END = 0.6, 0.95


@dataclass(frozen=True)
class Expectation:
    """
    Hold what an observer is expected to do, per joint.

    :param noise: standard deviation over noise, long after a reversal [Nm or N].
    :param settle_s: time from a reversal until the mean error stays below 10 % of the jump; NaN
        where it does not before the next one, or noise hides it.
    """

    noise: FloatArray
    settle_s: FloatArray


def expected_performance(
    gains: Mapping[str, Mapping[str, Sequence[float]]],
    inertia: FloatArray,
    measured: LogConditions,
) -> dict[str, Expectation]:
    """
    Run observers over sinusoidal motion with friction of D / 2 and the noise of the encoders.

    M is constant, gravity none, v_i = V_i sin(pi t / T_i), tau_f = D / 2 tanh(v / v0): what an
    observer is driven by is then known exactly, and everything but noise and lag is left out. The
    velocity has the lag of the slope of ``velocity_span`` positions, or, where that is 0, white
    noise of its own. The first half of the reversals are for the observers to learn from.

    :param inertia: M at the posture, (n, n).
    :param measured: all of it known, and every joint with a top speed.
    """
    n, step, top_speed = len(measured.joints), measured.step, measured.top_speed
    friction_jump = measured.friction_jump
    way = np.clip(measured.reversal_time, _SHORTEST, _LONGEST)
    count = int(np.ceil(_REVERSALS * float(way.max()) / step)) + 1
    t = np.arange(count)[:, None] * step
    omega = np.pi / way
    q = top_speed / omega * (1.0 - np.cos(omega * t))
    v = top_speed * np.sin(omega * t)
    # Where M q' and tau_f are known at all times, the mean forcing of an interval is exact.
    fine = 8
    sub = (np.arange(fine) + 0.5) / fine * step
    friction = np.zeros((count, n))
    for i in range(n):
        inner = top_speed[i] * np.sin(omega[i] * (t[1:] - step + sub))
        friction[1:, i] = 0.5 * friction_jump[i] * smooth_sign(inner, SMOOTHING_VELOCITY).mean(1)
    truth = 0.5 * friction_jump * smooth_sign(v, SMOOTHING_VELOCITY)
    forcing = np.diff(v, axis=0) @ inertia / step + friction[1:]
    fixed = np.broadcast_to(inertia, (count - 1, n, n)).copy()
    h = np.full(count - 1, step)

    @cache
    def measurement(seed: int) -> tuple[FloatArray, MomentumSamples]:
        rng = np.random.default_rng(seed)
        read = q + measured.position_noise * rng.normal(size=q.shape)
        if measured.velocity_span:
            seen = _slope(read, measured.velocity_span, step)
        else:
            seen = v + measured.velocity_noise * rng.normal(size=v.shape)
        samples = MomentumSamples(
            h, seen[1:] @ inertia, np.diff(read, axis=0) @ inertia, forcing, fixed
        )
        return seen[0] @ inertia, samples

    found = {}
    for name, values in gains.items():
        errors: list[FloatArray] = []
        wanted = _SEEDS
        while len(errors) < wanted:
            p_start, samples = measurement(len(errors))
            observer = make_observer(name, values)
            observer.start(p_start)
            errors.append(-observer.run(samples) - truth[1:])
            if len(errors) == _SEEDS:
                noise = _judge(np.array(errors), way, step, friction_jump).noise
                ratio = float(np.nanmax(noise / (_KNOWN * friction_jump), initial=0.0))
                means = _REVERSALS - _LEARNED
                wanted = int(np.clip(np.ceil(ratio**2 / means), _SEEDS, _MOST_SEEDS))
        found[name] = _judge(np.array(errors), way, step, friction_jump)
    return found


def _slope(q: FloatArray, span: int, step: float) -> FloatArray:
    """Return the least-squares slope of the last ``span`` positions; the first one is at rest."""
    padded = np.concatenate([np.repeat(q[:1], span - 1, axis=0), q])
    windows = np.lib.stride_tricks.sliding_window_view(padded, span, axis=0)
    return np.array(windows @ slope_weights(span, step))


def _judge(
    errors: FloatArray, way: FloatArray, step: float, friction_jump: FloatArray
) -> Expectation:
    """Return noise and settling of errors (seeds, N, n) from the second half of the reversals."""
    n = errors.shape[2]
    noise, settle = np.full(n, np.nan), np.full(n, np.nan)
    for i in range(n):
        length = round(_END * way[i] / step)
        starts = [round(k * way[i] / step) for k in range(_LEARNED, _REVERSALS)]
        signs = [1.0 if k % 2 == 0 else -1.0 for k in range(_LEARNED, _REVERSALS)]
        after = np.array(
            [
                sign * errors[:, start : start + length, i]
                for start, sign in zip(starts, signs, strict=True)
            ]
        )
        # Of gains that are not stable it is beyond any number.
        with np.errstate(over='ignore'):
            noise[i] = np.sqrt(np.mean(np.var(after[:, :, int(_LATE * length) :], axis=1, ddof=1)))
        means = after.shape[0] * after.shape[1]
        if noise[i] <= 2.0 * _KNOWN * friction_jump[i] * np.sqrt(means):
            mean = after.mean(axis=(0, 1))
            settle[i] = settled_after(mean, SETTLED * friction_jump[i], step)
    return Expectation(noise, settle)
