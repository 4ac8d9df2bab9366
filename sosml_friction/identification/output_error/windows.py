# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Output error without a controller: the measured effort drives the simulation, in windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import t as t_distribution

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.law_fit import jackknife_errors
from sosml_friction.identification.output_error.controlled import OutputErrorFit, Simulated
from sosml_friction.identification.segments import centred_difference
from sosml_friction.model.laws import unit_of
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.observers.momentum_sampler import MomentumSampler

FloatArray = NDArray[np.float64]

_NAMES = ('coulomb', 'viscous', 'bias', 'stribeck', 'stribeck_velocity')
_LEVEL = 0.95
_FEWEST_CLUSTERS = 8
#: Over what velocity is taken where the recording has none, and at the start of a window [s].
_SLOPE_S = 0.06
#: Width of the sign that is simulated where none is known, as a share of the top speed.
_SHARPNESS = 1e-3
#: Share of what is stable at the sign's slope that a step of the integration may be.
_STABLE = 0.5
#: Refinements of how fast each window begins, and the weight of what was measured of it, as a
#: share of what the motion of a free joint says.
_STARTS, _STAYS = 3, 1e-3
#: Widths of the Stribeck term that the search begins at, as shares of the top speed.
_WIDTHS = (0.02, 0.06, 0.2)
#: Steps of the search from each of these, and of the search from the best.
_FIRST_STEPS, _MOST_STEPS = 4, 15


@dataclass(frozen=True)
class WindowSettings:
    """
    Say how long a window is simulated before it starts afresh from the measurement [s].

    In a longer one friction moves the joint farther beyond the resolution of the encoder, but so
    does noise of the effort; and where friction falls with speed an error of the start grows by
    exp(T S / (v_s M)) over a window T. ``cluster_s``: windows in the same stretch of so long are
    taken to share their noise.
    """

    window_s: float = 0.1
    cluster_s: float = 1.0


def fit_windows(
    log: JointLog,
    robot: Robot,
    i: int,
    start: Mapping[str, float],
    smoothing_velocity: float,
    effort_hold: Sequence[str] | str = 'start',
    maximum_gap_s: float = 0.05,
    settings: WindowSettings | None = None,
) -> OutputErrorFit:
    """
    Fit friction so that joint ``i``, driven by its measured effort, moves as it was measured.

        p' = tau + C^T q' - g - tau_f(v),  x' = v = (p - sum_{j != i} M_ij q_j') / M_ii,

    with M, C^T q' and g along the measured motion: only friction sees the simulated velocity. Each
    window begins at a position and a velocity of its own, which are fitted too. Nothing is
    differentiated but for these. The Stribeck term is kept if its amplitude is beyond its 95 %
    interval. Standard errors leave out one stretch of windows after the other; the noise of the
    effort, which the simulation integrates, is in them.

    :param start: first guess of coulomb, viscous and bias; the inertia is the model's.
    :param smoothing_velocity: v0 of the sign; 0 for a thousandth of the top speed [rad/s or m/s].
    :raises DataError: if windows without holes are too few, or the joint does not move.
    """
    task = _Windows(log, robot, i, effort_hold, maximum_gap_s, settings or WindowSettings())
    width = smoothing_velocity if smoothing_velocity > 0.0 else _SHARPNESS * task.top_speed
    return task.fit(start, width)


class _Windows:
    """The windows of one joint, and what drives it in them."""

    def __init__(
        self,
        log: JointLog,
        robot: Robot,
        i: int,
        effort_hold: Sequence[str] | str,
        maximum_gap_s: float,
        settings: WindowSettings,
    ) -> None:
        self.i, self.unit = i, robot.effort_units[i]
        log = log.select(robot.names)
        time = log.time
        steps = np.diff(time)
        step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else np.inf
        half = max(1, round(0.5 * _SLOPE_S / step)) if np.isfinite(step) else 1
        if len(log) < 4 * half:
            raise DataError(f'the recording has {len(log)} samples: record longer')
        v = np.column_stack([centred_difference(time, q, half) for q in log.q.T])
        log = replace(log, v=v)
        sampler = MomentumSampler(robot, effort_hold, 'message', maximum_gap_s)
        length = max(8, round(settings.window_s / step))
        parts: list[tuple[FloatArray, ...]] = []
        for stretch in sampler.stretches(log):
            rows, samples = stretch.rows, stretch.samples
            others = np.delete(np.arange(robot.n), i)
            off = np.einsum('kj,kj->k', samples.inertia[:, i, others], log.v[rows][:, others])
            columns = (
                time[rows], log.q[rows, i], log.v[rows, i], samples.h, samples.forcing[:, i],
                samples.inertia[:, i, i], off,
            )  # fmt: skip
            for first in range(0, len(rows) - length + 1, length):
                window = tuple(column[first : first + length] for column in columns)
                if all(np.isfinite(column).all() for column in window):
                    parts.append(window)
        moving = [window for window in parts if np.ptp(window[1]) > 0.0]
        labels = [int(window[0][0] / settings.cluster_s) for window in moving]
        clusters, self.groups = np.unique(labels, return_inverse=True)
        if len(clusters) < _FEWEST_CLUSTERS:
            raise DataError(
                f'only {len(clusters)} stretches of {settings.cluster_s:g} s have motion without '
                f'a hole in position or effort: {_FEWEST_CLUSTERS} or more are needed, record '
                'longer'
            )
        # (windows, samples of each)
        self.q, velocity, self.h, self.forcing, self.m, self.off = (
            np.array([window[k] for window in moving]) for k in range(1, 7)
        )
        self.first_v = velocity[:, 0]
        self.top_speed = float(np.abs(velocity).max())
        passed = np.cumsum(self.h, axis=1)
        # What a change of velocity at the start would do to a joint without friction.
        self.free = np.sum((passed - passed.mean(axis=1, keepdims=True)) ** 2, axis=1)
        self.size = float(np.std(self.q - self.q.mean(axis=1, keepdims=True)))

    def simulate(
        self, theta: FloatArray, x0: FloatArray, w0: FloatArray, width: float, steps: int
    ) -> FloatArray:
        """Return the positions in all windows, (windows, samples)."""
        return _integrate(theta, x0, w0, self.h, self.forcing, self.m, self.off, width, steps)

    def residual(self, theta: FloatArray, width: float, steps: int) -> FloatArray:
        """Return what is left of the positions when each window begins as fits it best."""
        x0, w0 = self.q[:, 0].copy(), self.first_v.copy()
        nudge = 1e-4 * self.top_speed
        left = np.empty_like(self.q)
        best = np.full(len(w0), np.inf)
        for last in (False,) * _STARTS + (True,):
            run = self.simulate(theta, x0, w0, width, steps)
            rest = self.q - run
            # Position at the start moves all of a window alike.
            rest = rest - rest.mean(axis=1, keepdims=True)
            cost = np.nan_to_num(np.sum(rest**2, axis=1), nan=np.inf)
            better = cost < best
            left[better], best[better] = rest[better], cost[better]
            if last:
                break
            slope = (self.simulate(theta, x0, w0 + nudge, width, steps) - run) / nudge
            slope = slope - slope.mean(axis=1, keepdims=True)
            # Where friction stops the joint at once, how it began is not seen: it stays measured.
            size = np.sum(slope**2, axis=1) + _STAYS * self.free
            w0 = w0 + np.nan_to_num(np.sum(slope * rest, axis=1) / size)
        return np.array(np.nan_to_num(left.ravel() / self.size, nan=1e3, posinf=1e3, neginf=-1e3))

    def fit(self, start: Mapping[str, float], width: float) -> OutputErrorFit:
        """Return the fit, with the Stribeck term where it is beyond its interval."""
        guess = np.array([max(start['coulomb'], 0.0), max(start['viscous'], 0.0), start['bias']])
        floor = 1e-3 * float(np.abs(self.forcing).max())
        if guess[0] == 0.0:
            # A search that begins at a bound stays there: some friction is what drives the motion.
            guess[0] = 0.2 * float(np.sqrt(np.mean(self.forcing**2)))
        scale = np.array([floor + guess[0], floor / self.top_speed + guess[1], floor + guess[0]])
        plain = self._solve(np.append(guess, [0.0, 1.0]), scale, width, 3, _MOST_STEPS)
        found = []
        for share in _WIDTHS:
            v_s = share * self.top_speed
            begin = np.append(plain[0][:3], [0.2 * scale[0], v_s])
            scales = np.append(scale, [scale[0], v_s])
            found.append(self._solve(begin, scales, width, 5, _FIRST_STEPS))
        best = min(found, key=lambda solution: float(solution[1] @ solution[1]))[0]
        full = self._solve(best, np.append(scale, [scale[0], best[4]]), width, 5, _MOST_STEPS)
        free = max(int(self.groups.max()) + 1 - 5, 1)
        quantile = float(t_distribution.ppf(0.5 + _LEVEL / 2.0, free))
        errors = self._errors(*full)
        S, v_s = float(full[0][3]), float(full[0][4])
        known = quantile * errors[3] < S and v_s > quantile * errors[4]
        if known:
            return self._result(full, errors, quantile, width, {})
        # What the data leave open of S at the width that fits best.
        high = S + quantile * float(errors[3]) if np.isfinite(errors[3]) else np.inf
        reason = 'the simulated motion does not show it'
        flagged = {
            'stribeck': Parameter(
                np.nan, self.unit, np.nan, (0.0, high), (NOT_IDENTIFIABLE,), reason
            ),
            'stribeck_velocity': Parameter(
                np.nan, unit_of('stribeck_velocity', self.unit), np.nan, None,
                (NOT_IDENTIFIABLE,), reason,
            ),
        }  # fmt: skip
        return self._result(plain, self._errors(*plain), quantile, width, flagged)

    def _solve(
        self, begin: FloatArray, scale: FloatArray, width: float, count: int, most: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the parameters (5,), what is left, and its slope, with ``count`` of them free."""
        lower = np.array([0.0, 0.0, -np.inf, 0.0, 1e-3 * self.top_speed])[:count]
        upper = np.array([np.inf, np.inf, np.inf, np.inf, 10.0 * self.top_speed])[:count]
        inertia = float(self.m.min())
        level = begin[0] + begin[3] + scale[0]
        slope = (level / width + begin[1] + scale[1]) / inertia
        steps = int(np.clip(np.ceil(float(self.h.max()) * slope / _STABLE), 1, 200))

        def residual(free: FloatArray) -> FloatArray:
            return self.residual(np.append(free, begin[count:]), width, steps)

        found = least_squares(
            residual,
            np.clip(begin[:count], lower + 1e-2 * scale, upper),
            x_scale=scale,
            bounds=(lower, upper),
            diff_step=1e-4,
            ftol=1e-6,
            xtol=1e-5,
            max_nfev=most,
        )
        return np.append(found.x, begin[count:]), found.fun, found.jac

    def _errors(self, theta: FloatArray, left: FloatArray, jac: FloatArray) -> FloatArray:
        """Return the standard errors (5,), NaN where a parameter is at its bound or not free."""
        groups = np.repeat(self.groups, self.q.shape[1])
        norms = np.linalg.norm(jac, axis=0)
        at_bound = np.array([k in (0, 1) and theta[k] < 1e-6 for k in range(jac.shape[1])])
        use = np.flatnonzero(~at_bound & (norms > 0.0))
        errors = np.full(5, np.nan)
        X = -jac[:, use] / norms[use]
        errors[use] = jackknife_errors(X, left, groups) / norms[use]
        return errors

    def _result(
        self,
        solution: tuple[FloatArray, FloatArray, FloatArray],
        errors: FloatArray,
        quantile: float,
        width: float,
        flagged: Mapping[str, Parameter],
    ) -> OutputErrorFit:
        theta, left, jac = solution
        parameters = {}
        for k, name in enumerate(_NAMES):
            if k >= jac.shape[1]:
                continue
            value, half = float(theta[k]), quantile * float(errors[k])
            known = np.isfinite(half)
            parameters[name] = Parameter(
                value,
                unit_of(name, self.unit),
                float(errors[k]),
                (value - half, value + half) if known else None,
                () if known else (AT_BOUND,),
            )
        rest = left.reshape(self.q.shape) * self.size
        simulated = self.q - rest
        centred = self.q - self.q.mean(axis=1, keepdims=True)
        share = 100.0 * float(np.linalg.norm(rest)) / float(np.linalg.norm(centred))
        return OutputErrorFit(
            {**parameters, **flagged},
            share,
            np.nan,
            Simulated(simulated.ravel(), np.full(simulated.size, np.nan)),
            float(np.std(rest)),
            int(simulated.size),
            int(self.groups.max()) + 1,
            width,
        )


@njit(cache=True)
def _integrate(
    theta: FloatArray,
    x0: FloatArray,
    w0: FloatArray,
    h: FloatArray,
    forcing: FloatArray,
    m: FloatArray,
    off: FloatArray,
    width: float,
    steps: int,
) -> FloatArray:
    C, B, bias, S, v_s = theta
    windows, count = h.shape
    x = np.empty((windows, count))
    for k in range(windows):
        x[k, 0] = x0[k]
        v = w0[k]
        position = x0[k]
        for j in range(1, count):
            p = m[k, j - 1] * v + off[k, j - 1]
            step = h[k, j] / steps
            for s in range(steps):
                # Inertia changes little within a sample: it is taken at the sample's share.
                share = (s + 1.0) / steps
                mass = m[k, j - 1] + share * (m[k, j] - m[k, j - 1])
                other = off[k, j - 1] + share * (off[k, j] - off[k, j - 1])
                friction = np.tanh(v / width) * (C + S * np.exp(-abs(v) / v_s)) + B * v + bias
                p_middle = p + 0.5 * step * (forcing[k, j] - friction)
                middle = (p_middle - other) / mass
                friction = (
                    np.tanh(middle / width) * (C + S * np.exp(-abs(middle) / v_s))
                    + B * middle
                    + bias
                )
                p += step * (forcing[k, j] - friction)
                position += step * middle
                v = (p - other) / mass
            x[k, j] = position
    return x
