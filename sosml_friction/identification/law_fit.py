# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fit the Stribeck law (17) to pairs of velocity and friction, with honest uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear, minimize_scalar
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from sosml_friction.exceptions import DataError
from sosml_friction.model.friction_law import unit_of
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.smooth_sign import smooth_sign

FloatArray = NDArray[np.float64]

#: Columns of the regression, linear parameters of the law for a given stribeck_velocity.
LINEAR = ('coulomb', 'viscous', 'bias', 'stribeck')
_HUBER = 1.345  # 95 % efficient on normal noise
_LEVEL = 0.95


@dataclass(frozen=True)
class LawFit:
    """
    Hold a fitted law.

    ``law`` is ``stribeck`` where the data show the extra term, else ``coulomb_viscous``: then
    ``stribeck`` and ``stribeck_velocity`` are flagged and their ``value`` is NaN; the ``interval``
    of ``stribeck`` is what the data leave open for any ``stribeck_velocity`` from a third of the
    slowest speed up (below that, nothing of S can be seen). ``residual_std`` [Nm or N] and
    ``relative_error`` [%] = 100 |y - law| / |y| are over the pairs fitted. ``smoothing_velocity``
    [rad/s or m/s] is what the caller knew of the sign, 0 for the sign itself.
    """

    law: str
    parameters: Mapping[str, Parameter]
    residual_std: float
    relative_error: float
    pairs: int
    clusters: int
    smoothing_velocity: float = 0.0


def fit_law(
    v: FloatArray,
    y: FloatArray,
    clusters: NDArray[np.int64],
    effort_unit: str,
    lag: Callable[[FloatArray], FloatArray] = lambda column: column,
    keep: NDArray[np.bool_] | None = None,
    smoothing_velocity: float = 0.0,
    mean_v: FloatArray | None = None,
) -> LawFit:
    """
    Fit y = s(v) (C + S exp(-|v| / v_s)) + B v + bias with C, B, S >= 0.

    For a given v_s the law is linear: v_s is searched, the rest solved with Huber weights.
    Standard errors are the delete-one-cluster jackknife of the linearised fit, so that noise may
    be correlated within a cluster and of any size in each, times E w / E psi' (Huber's estimate
    is less sure than least squares with his weights w would say); intervals are 95 % with
    Student's t of (clusters - parameters) degrees of freedom. The Stribeck term is kept if an F
    test at 95 % says that it explains more than its two parameters would by chance. The interval
    of v_s, and that of S where the term is not kept, is where the profile of the cost at fixed
    weights stays below its 95 % limit (that of v_s widened where the jackknife is less sure than
    the profile); v_s is searched from a third of the slowest speed to the fastest, and is not
    identifiable where the interval reaches either end: that end is then 0 or infinite.

    :param v: velocity (N,) [rad/s or m/s]; it says where friction is, in full order.
    :param y: friction torque (N,) [Nm or N], positive for positive velocity.
    :param clusters: which of the pairs share their noise (N,), numbers of any value.
    :param lag: what the observer did to friction on its way to y: applied to each column. It may
        make K numbers of N: y, ``clusters``, ``keep`` and ``mean_v`` then have K.
    :param keep: which pairs take part (N,), all of them if None.
    :param smoothing_velocity: v0 of the sign s, known; 0 for the sign itself.
    :param mean_v: velocity of each pair (K,), where ``lag`` makes K numbers of N.
    :raises DataError: if there are too few clusters, or motion in one direction or at one speed
        only.
    """
    mean_v = v if mean_v is None else mean_v
    keep = np.isfinite(y) & np.isfinite(mean_v) & (True if keep is None else keep)
    v = np.nan_to_num(v)
    labels, groups = np.unique(clusters[keep], return_inverse=True)
    speeds = np.abs(mean_v[keep])
    if len(labels) < 6:
        raise DataError(
            f'only {len(labels)} separate pieces of steady motion: six or more are needed; record '
            'several speeds in both directions'
        )
    if not ((mean_v[keep] > 0.0).any() and (mean_v[keep] < 0.0).any()):
        raise DataError('the joint moved in one direction only: record motion in both directions')
    if np.ptp(speeds) < 0.1 * speeds.max():
        raise DataError(
            f'the joint moved at one speed only ({speeds.max():.3g}): viscous and Coulomb '
            'friction need at least two; record a speed ladder'
        )
    problem = _Problem(v, y[keep], groups, lag, keep, smoothing_velocity)
    # Outside these ends exp(-|v| / v_s) is 0 or straight.
    slowest = float(np.quantile(speeds, 0.02))
    grid = np.geomspace(max(slowest, 1e-3 * speeds.max()) / 3.0, speeds.max(), 40)
    # One set of weights for what is compared, or an outlier would count more in the poorer model.
    weights = min((problem.solve(v_s) for v_s in grid[::2]), key=lambda fit: fit.cost).weights
    profile = np.array([problem.solve(v_s, weights).cost for v_s in grid])
    best = int(np.argmin(profile))
    around = np.log(grid[[max(best - 1, 0), min(best + 1, len(grid) - 1)]])
    found = minimize_scalar(
        lambda u: problem.solve(float(np.exp(u)), weights).cost,
        bounds=tuple(around),
        method='bounded',
        options={'xatol': 1e-8},
    )
    v_s = float(np.exp(found.x)) if found.fun < profile[best] else float(grid[best])
    full, plain = problem.solve(v_s, weights), problem.solve(None, weights)

    freedom = len(labels) - 5
    variance = problem.variance(full, freedom)
    limit = full.cost + variance * float(f_distribution.ppf(_LEVEL, 1, freedom))
    # Below this, differences of cost are rounding errors.
    rounding = 1e-20 * float(np.sum(weights * problem.y**2))
    needed = max(2.0 * variance * float(f_distribution.ppf(_LEVEL, 2, freedom)), rounding)
    if full.theta[3] <= 0.0 or not plain.cost - full.cost > needed:
        parameters = problem.linear_parameters(plain, effort_unit, LINEAR[:3])
        parameters['stribeck'] = Parameter(
            np.nan,
            effort_unit,
            interval=(0.0, max(problem.largest_stribeck(x, weights, limit) for x in grid)),
            flags=(NOT_IDENTIFIABLE, AT_BOUND) if full.theta[3] <= 0.0 else (NOT_IDENTIFIABLE,),
        )
        parameters['stribeck_velocity'] = Parameter(
            np.nan, unit_of('stribeck_velocity', effort_unit), flags=(NOT_IDENTIFIABLE,)
        )
        return problem.result('coulomb_viscous', plain, parameters)

    parameters = problem.linear_parameters(full, effort_unit, LINEAR)
    std_error = float(problem.std_errors(full)[4])
    # The profile takes all pairs for equally noisy; the jackknife does not, and may know better.
    wider = max(1.0, std_error / problem.profile_error(full, variance)) if variance > 0.0 else 1.0
    room, excess, u = (limit - full.cost) * wider**2, profile - full.cost, float(np.log(v_s))
    below = _crossing(u, np.log(grid), excess, room, -1)
    above = _crossing(u, np.log(grid), excess, room, 1)
    flags = () if below is not None and above is not None else (NOT_IDENTIFIABLE,)
    parameters['stribeck_velocity'] = Parameter(
        v_s,
        unit_of('stribeck_velocity', effort_unit),
        std_error,
        (
            0.0 if below is None else float(np.exp(below)),
            np.inf if above is None else float(np.exp(above)),
        ),
        flags,
    )
    if flags:
        parameters['stribeck'] = replace(parameters['stribeck'], flags=flags)
    return problem.result('stribeck', full, parameters)


def jackknife_errors(
    X: FloatArray,
    residual: FloatArray,
    groups: NDArray[np.int64],
    weights: FloatArray | None = None,
) -> FloatArray:
    """
    Return the delete-one-cluster jackknife standard errors of a linear least-squares fit, (P,).

    :param X: columns of the regression (N, P), of like sizes.
    :param residual: what the fit leaves (N,).
    :param groups: cluster of each row (N,), 0 to the number of clusters - 1, each in use.
    :param weights: of the rows (N,), all 1 if None.
    """
    w = np.ones(len(residual)) if weights is None else weights
    N = X.T @ (w[:, None] * X)
    count = int(groups.max()) + 1
    shifts = []
    for g in range(count):
        own = groups == g
        Xg, wg = X[own], w[own]
        rest = N - Xg.T @ (wg[:, None] * Xg)
        moment = Xg.T @ (wg * residual[own])
        shifts.append(np.linalg.pinv(rest, rcond=1e-12) @ -moment)
    spread = np.array(shifts)
    variance = (count - 1) / count * np.sum((spread - spread.mean(0)) ** 2, axis=0)
    return np.array(np.sqrt(variance))


def _crossing(
    u: float, grid: FloatArray, excess: FloatArray, limit: float, way: int
) -> float | None:
    """Return where ``excess``, 0 at ``u``, exceeds ``limit`` on one side of it, or None."""
    root = 0.0
    for k in np.flatnonzero((grid - u) * way > 0.0)[::way]:
        # A cost is a parabola about its minimum: its root is nearly straight.
        next_root = float(np.sqrt(max(excess[k], 0.0)))
        if excess[k] > limit:
            return float(u + (grid[k] - u) * (np.sqrt(limit) - root) / (next_root - root))
        u, root = float(grid[k]), next_root
    return None


@dataclass(frozen=True)
class _Solution:
    theta: FloatArray  # LINEAR, the last zero without Stribeck term
    v_s: float | None
    weights: FloatArray
    residual: FloatArray
    cost: float


class _Problem:
    """The regression for any v_s, its columns cached where they do not depend on it."""

    def __init__(
        self,
        v: FloatArray,
        y: FloatArray,
        groups: NDArray[np.int64],
        lag: Callable[[FloatArray], FloatArray],
        keep: NDArray[np.bool_],
        smoothing_velocity: float,
    ) -> None:
        self.v, self.y, self.groups, self.lag, self.keep = v, y, groups, lag, keep
        self.smoothing_velocity = smoothing_velocity
        self.sign = smooth_sign(v, smoothing_velocity)
        self.fixed = np.column_stack(
            [lag(column)[keep] for column in (self.sign, v, np.ones_like(v))]
        )
        self.count = int(groups.max()) + 1

    def columns(self, v_s: float | None) -> FloatArray:
        if v_s is None:
            return self.fixed
        peak = self.lag(self.sign * np.exp(-np.abs(self.v) / v_s))[self.keep]
        return np.column_stack([self.fixed, peak])

    def solve(self, v_s: float | None, weights: FloatArray | None = None) -> _Solution:
        """Solve for LINEAR at one v_s: Huber weights of its own where none are given."""
        X = self.columns(v_s)
        size = X.shape[1]
        lower = np.array([0.0, 0.0, -np.inf, 0.0])[:size]
        scale = np.linalg.norm(X, axis=0)
        scale[scale == 0.0] = 1.0
        # What a fit of so many parameters leaves of the noise.
        left = np.sqrt(max(self.count - size - (v_s is not None), 1) / self.count)
        w = np.ones(len(self.y)) if weights is None else weights
        for _ in range(10):
            root = np.sqrt(w)
            # The bounds need only the triangle: a long recording is reduced to it first.
            Q, R = np.linalg.qr(X / scale * root[:, None])
            moment = Q.T @ (self.y * root)
            theta = np.linalg.lstsq(R, moment, rcond=1e-12)[0]
            if (theta < lower).any():
                theta = lsq_linear(R, moment, bounds=(lower, np.inf), method='bvls').x
            theta = theta / scale
            residual = self.y - X @ theta
            if weights is not None:
                break
            spread = 1.4826 * float(np.median(np.abs(residual))) / left
            if spread == 0.0:
                break
            last, w = w, np.minimum(1.0, _HUBER * spread / np.maximum(np.abs(residual), 1e-300))
            if np.max(np.abs(w - last)) < 1e-3:
                break
        full = np.zeros(4)
        full[:size] = theta
        return _Solution(full, v_s, w, residual, float(np.sum(w * residual**2)))

    def variance(self, solution: _Solution, freedom: int) -> float:
        """Return the rise of the cost at fixed weights that one standard error makes."""
        w, r = solution.weights, solution.residual
        if solution.cost == 0.0:
            return 0.0
        # Huber's estimate varies by E psi^2 / (E psi')^2, psi = w r; the weighted cost would say
        # E w r^2 / E w, which is less: the weights take residuals for smaller than they are.
        scale = np.mean(w) * np.mean((w * r) ** 2) / np.mean(w >= 1.0) ** 2 / np.mean(w * r**2)
        return float(solution.cost * scale / freedom)

    def profile_error(self, solution: _Solution, variance: float) -> float:
        """Return the standard error of v_s that the curvature of the cost says."""
        X = self._jacobian(solution)
        norms = np.linalg.norm(X, axis=0)
        X = X / norms * np.sqrt(solution.weights)[:, None]
        return float(np.sqrt(variance * np.linalg.pinv(X.T @ X)[4, 4]) / norms[4])

    def largest_stribeck(self, v_s: float, weights: FloatArray, limit: float) -> float:
        """Return the largest S >= 0 whose cost at this v_s is not above ``limit``."""
        X = self.columns(v_s) * np.sqrt(weights)[:, None]
        y = self.y * np.sqrt(weights)
        # What the other columns cannot explain of the last one and of y.
        rest, target = (
            z - X[:, :3] @ np.linalg.lstsq(X[:, :3], z, rcond=None)[0] for z in (X[:, 3], y)
        )
        size = float(rest @ rest)
        if size <= 1e-24 * float(X[:, 3] @ X[:, 3]):
            return np.inf
        best = float(rest @ target) / size
        room = limit - float(target @ target) + best**2 * size
        return max(best + np.sqrt(room / size), 0.0) if room >= 0.0 else 0.0

    def std_errors(self, solution: _Solution) -> FloatArray:
        """Return the jackknife standard error of LINEAR and v_s, NaN for what was not fitted."""
        X = self._jacobian(solution)
        # A parameter that sits on its bound does not move with the data.
        at_bound = [k for k in (0, 1) if solution.theta[k] <= 0.0]
        columns = [k for k in range(X.shape[1]) if k not in at_bound]
        norms = np.linalg.norm(X[:, columns], axis=0)
        w = solution.weights
        errors = jackknife_errors(X[:, columns] / norms, solution.residual, self.groups, w)
        # The slope of Huber's psi is 0 where a residual is clipped, not w.
        clipping = np.mean(w) / np.mean(w >= 1.0)
        result = np.full(5, np.nan)
        for position, k in enumerate(columns):
            result[k] = clipping * errors[position] / norms[position]
        return result

    def _jacobian(self, solution: _Solution) -> FloatArray:
        # Columns of LINEAR, then of v_s where the law has it.
        X = self.columns(solution.v_s)
        if solution.v_s is None:
            return X
        v_s, S = solution.v_s, solution.theta[3]
        slope = self.sign * np.abs(self.v) * np.exp(-np.abs(self.v) / v_s) * S / v_s**2
        return np.column_stack([X, self.lag(slope)[self.keep]])

    def linear_parameters(
        self, solution: _Solution, effort_unit: str, names: tuple[str, ...]
    ) -> dict[str, Parameter]:
        errors = self.std_errors(solution)
        fitted = len(names) + (solution.v_s is not None)
        quantile = t_distribution.ppf(0.5 + _LEVEL / 2.0, max(self.count - fitted, 1))
        result = {}
        for k, name in enumerate(names):
            value, error = float(solution.theta[k]), float(errors[k])
            at_bound = name != 'bias' and value <= 0.0
            interval = None if at_bound else (value - quantile * error, value + quantile * error)
            result[name] = Parameter(
                value,
                unit_of(name, effort_unit),
                np.nan if at_bound else error,
                interval,
                (AT_BOUND,) if at_bound else (),
            )
        return result

    def result(self, law: str, solution: _Solution, parameters: dict[str, Parameter]) -> LawFit:
        ordered = ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'bias')
        residual = solution.residual
        scale = float(np.linalg.norm(self.y))
        return LawFit(
            law,
            {name: parameters[name] for name in ordered},
            float(np.sqrt(np.mean(residual**2))),
            100.0 * float(np.linalg.norm(residual)) / scale if scale > 0.0 else np.nan,
            len(self.y),
            self.count,
            self.smoothing_velocity,
        )
