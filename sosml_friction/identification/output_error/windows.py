# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Output error without a controller: the measured effort drives the simulation, in windows."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.jackknife import jackknife_errors
from sosml_friction.identification.output_error.output_error_fit import (
    OutputErrorFit,
    estimated,
    relative_error,
)
from sosml_friction.identification.segments import centred_difference
from sosml_friction.model.laws import unit_of
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.observers.momentum_sampler import MomentumSampler
from sosml_friction.simulation.joint_windows import simulate_joint_windows

_NAMES = ('coulomb', 'viscous', 'bias', 'stribeck', 'stribeck_velocity')
_FEWEST_CLUSTERS = 8
#: How long a window is simulated before it starts afresh from the measurement [s]. In a longer one
#: friction moves the joint by more quanta of the encoder, but noise of effort does so, too. Where
#: friction falls with speed, an error of the start grows by exp(T S / (v_s M)) over a window T.
_WINDOW_S = 0.1
#: Length of a cluster [s]: windows in one may share their noise.
_CLUSTER_S = 1.0
#: Time over which position is differenced where velocity was not recorded, and at the start of a
#: window [s].
_SLOPE_S = 0.06
#: Width of the sign that is simulated where none is known, as a share of the top speed.
_SHARPNESS = 1e-3
#: Time constants of the sign's slope in a step of the integration.
_TIME_CONSTANTS = 1.0
#: Iterations for the initial velocity of each window, and the weight of its measured value, as a
#: share of the information that the motion of a free joint has.
_STARTS, _STAYS = 3, 1e-3
#: Widths of the Stribeck term that the search begins at, as shares of the top speed.
_WIDTHS = (0.02, 0.06, 0.2)
#: Most iterations of the search from each of these widths, and of the search from the best.
_FIRST_STEPS, _MOST_STEPS = 4, 15


def fit_windows(
    log: JointLog,
    robot: Robot,
    i: int,
    start: Mapping[str, float],
    smoothing_velocity: float,
    effort_hold: Sequence[str] | str = 'start',
    exponent: float = 1.0,
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
    :param exponent: of the Stribeck term, known.
    :raises DataError: if windows without holes are too few, or the joint does not move.
    """
    task = _Windows(log, robot, i, effort_hold, exponent)
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
        exponent: float,
    ) -> None:
        self.i, self.unit, self.exponent = i, robot.effort_units[i], exponent
        log = log.select(robot.names)
        time = log.time
        steps = np.diff(time)
        step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else np.inf
        half = max(1, round(0.5 * _SLOPE_S / step)) if np.isfinite(step) else 1
        if len(log) < 4 * half:
            raise DataError(f'the recording has {len(log)} samples: record longer')
        log = replace(log, v=centred_difference(time, log.q, half))
        sampler = MomentumSampler(robot, effort_hold)
        length = max(8, round(_WINDOW_S / step))
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
        labels = [int(window[0][0] / _CLUSTER_S) for window in moving]
        clusters, self.groups = np.unique(labels, return_inverse=True)
        if len(clusters) < _FEWEST_CLUSTERS:
            raise DataError(
                f'only {len(clusters)} stretches of {_CLUSTER_S:g} s have motion without '
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
        # Sum of squares by which a joint without friction moves for one unit of initial velocity.
        self.free = np.sum((passed - passed.mean(axis=1, keepdims=True)) ** 2, axis=1)
        self.size = float(np.std(self.q - self.q.mean(axis=1, keepdims=True)))

    def simulate(
        self, theta: FloatArray, x0: FloatArray, w0: FloatArray, width: float, steps: int
    ) -> FloatArray:
        """Return the positions in all windows, (windows, samples)."""
        return simulate_joint_windows(
            theta, x0, w0, self.h, self.forcing, self.m, self.off, self.exponent, width, steps
        )

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
        parameters = self._parameters(full)
        amplitude, size = (parameters[name].interval for name in ('stribeck', 'stribeck_velocity'))
        if amplitude is not None and size is not None and min(amplitude[0], size[0]) > 0.0:
            return self._result(full, parameters, width)
        # What the data leave open of S at the width that fits best.
        high = np.inf if amplitude is None else amplitude[1]
        reason = 'the simulated motion does not show it'
        unit = unit_of('stribeck_velocity', self.unit)
        flagged = {
            'stribeck': Parameter.not_told(self.unit, reason, (0.0, high)),
            'stribeck_velocity': Parameter.not_told(unit, reason),
        }
        return self._result(plain, self._parameters(plain) | flagged, width)

    def _solve(
        self, begin: FloatArray, scale: FloatArray, width: float, count: int, most: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the parameters (5,), what is left, and its slope, with ``count`` of them free."""
        lower = np.array([0.0, 0.0, -np.inf, 0.0, 1e-3 * self.top_speed])[:count]
        upper = np.array([np.inf, np.inf, np.inf, np.inf, 10.0 * self.top_speed])[:count]
        inertia = float(self.m.min())
        level = begin[0] + begin[3] + scale[0]
        slope = (level / width + begin[1] + scale[1]) / inertia
        steps = int(np.clip(np.ceil(float(self.h.max()) * slope / _TIME_CONSTANTS), 1, 100))

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

    def _parameters(
        self, solution: tuple[FloatArray, FloatArray, FloatArray]
    ) -> dict[str, Parameter]:
        """Return those that were free."""
        theta, _, jac = solution
        errors, freedom = self._errors(*solution), max(int(self.groups.max()) + 1 - 5, 1)
        rows = zip(_NAMES[: jac.shape[1]], theta, errors, strict=False)
        return {
            name: estimated(value, unit_of(name, self.unit), error, freedom)
            for name, value, error in rows
        }

    def _result(
        self,
        solution: tuple[FloatArray, FloatArray, FloatArray],
        parameters: Mapping[str, Parameter],
        width: float,
    ) -> OutputErrorFit:
        rest = solution[1].reshape(self.q.shape) * self.size
        centred = self.q - self.q.mean(axis=1, keepdims=True)
        return OutputErrorFit(
            parameters,
            relative_error(centred - rest, centred),
            np.nan,
            int(rest.size),
            int(self.groups.max()) + 1,
            width,
            self.exponent,
        )
