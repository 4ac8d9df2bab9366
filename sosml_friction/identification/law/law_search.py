# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fit a friction law to pairs of velocity and friction, with honest uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import f as f_distribution

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.exceptions import DataError, MotionError
from sosml_friction.identification.identifiability import (
    SPREAD,
    DataReach,
    experiment_for,
    reason_for,
)
from sosml_friction.identification.law.jackknife import jackknife_covariance, t_95
from sosml_friction.identification.law.law_checks import (
    LawCheck,
    dissipation_check,
    odd_even_check,
)
from sosml_friction.identification.law.law_fit import STRIBECK_AT_SLOWEST, LawFit
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_problem import (
    MOST_SOLVED,
    NON_NEGATIVE,
    LawProblem,
    LawSolution,
)
from sosml_friction.identification.law.law_profile import LawProfile
from sosml_friction.identification.parameter_interval import AT_ZERO
from sosml_friction.model.laws import unit_of
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.terms.stribeck import fade
from sosml_friction.regression.column_norms import column_norms

#: Share of the friction level that is no S.
_NOTHING = 1e-9
#: Share of the sum of squares that is a rounding error.
_ROUNDING = 1e-20
_LEVEL = 0.95
#: v_s is searched anew until no weight changes by more than this. Chosen, no measurement.
_LIKE_WEIGHTS = 1e-3
#: Laws are compared from this share of the least v_s on: there they are flat.
_FLAT = 1e-3
#: Number of speeds of the profile, of the coarse search over v_s, and of that over v0.
_GRID, _COARSE, _SIGNS = 36, 12, 5
#: Number of points of the profile near the best fit, and of those at which the other parameters
#: are solved for.
_NEAR, _ALONG = 13, 5
#: v_s counts as known if an interval this many times as wide as that of 95 % is narrow, too:
#: 1.5 * 1.96 = 2.9, about three standard errors.
_SURE = 1.5
#: v_s is searched from this part of the slowest speed on, and what may hide is told from a third.
_BELOW, _HIDDEN = 8.0, 3.0
#: A search leaves 1e-6 of its ends; what is as near as this is at one.
_AT_END = 1e-3
#: v0 is searched between these multiples of the slowest speed.
_LEAST_V0, _LARGEST_V0 = 0.08, 2.0
_NO_COULOMB = (
    'the best fit has no Coulomb friction, the Stribeck term stands in its place: the data do not '
    'tell one from the other'
)


def search_law(
    v: FloatArray,
    y: FloatArray,
    clusters: IndexArray,
    lag: Callable[[FloatArray], FloatArray] = lambda column: column,
    keep: BoolArray | None = None,
    smoothing_velocity: float | None = 0.0,
    mean_v: FloatArray | None = None,
    form: LawForm | None = None,
    extra: FloatArray | None = None,
    unsure: FloatArray | None = None,
) -> LawSearch:
    """
    Return the fit of y = s(v) (C + S exp(-(|v| / v_s)^alpha)) + B v + bias with C, B, S >= 0.

    For a given v_s (and v0 of the sign s, where it is to be found) the law is linear: these are
    searched, the rest solved with Huber weights. The estimates' covariance is that of the
    delete-one-cluster jackknife of the linearised fit, all parameters and v0 together, so that
    noise may be correlated within a cluster and of any size in each, times (E w / E psi')^2
    (the variance of Huber's estimate is larger than least squares with his weights w says).
    Intervals are 95 % with Student's t of (clusters - parameters) degrees of freedom. That of v_s
    is where the profile of the cost is below a limit, which is scaled so that the width agrees
    with the standard error of the jackknife.

    The Stribeck term is kept if an F test at 95 % says that it explains more than its two
    parameters would by chance, v0 of the sign if one of one parameter does. What fits better by
    less than that may be true all the same: what it moves the parameters by is in their
    covariance, V + d d^T.
    :mod:`~sosml_friction.identification.identifiability` says when a parameter is not
    identifiable.

    :param v: velocity (N,) [rad/s or m/s]; it says where friction is, in full order.
    :param y: friction torque (N,) [Nm or N], positive for positive velocity.
    :param clusters: which of the pairs share their noise (N,), numbers of any value.
    :param lag: what the observer did to friction on its way to y: applied to each column. It may
        make K numbers of N: y, ``clusters``, ``keep`` and ``mean_v`` then have K.
    :param keep: which pairs take part (N,), all of them if None.
    :param smoothing_velocity: v0 of the sign s, known; 0 for the sign itself, None to find it.
    :param mean_v: velocity of each pair (K,), where ``lag`` makes K numbers of N.
    :param form: which law, that of the equation if None.
    :param extra: more columns with a factor each (K, E), such as inertial torque.
    :param unsure: what y may be off by (K, U), each column as a whole by one standard deviation.
    :raises DataError: if there are too few clusters, or motion in one direction only.
    :raises MotionError: if the motion is at one speed only.
    """
    mean_v = v if mean_v is None else mean_v
    keep = np.isfinite(y) & np.isfinite(mean_v) & (True if keep is None else keep)
    _check(clusters[keep], mean_v[keep])
    problem = LawProblem(
        np.nan_to_num(v),
        y[keep],
        np.unique(clusters[keep], return_inverse=True)[1],
        lag,
        keep,
        form or LawForm(),
        np.empty((len(y), 0)) if extra is None else extra,
        np.empty((len(y), 0)) if unsure is None else unsure,
    )
    return LawSearch(problem, np.abs(mean_v[keep]), smoothing_velocity)


def _check(clusters: IndexArray, v: FloatArray) -> None:
    speeds, count = np.abs(v), len(np.unique(clusters))
    if count < 6:
        raise DataError(
            f'only {count} separate pieces of steady motion: six or more are needed; record '
            'several speeds in both directions'
        )
    if not ((v > 0.0).any() and (v < 0.0).any()):
        raise DataError('the joint moved in one direction only: record motion in both directions')
    if np.ptp(speeds) < 0.1 * speeds.max():
        raise MotionError(
            f'the joint moved at one speed only ({speeds.max():.3g}): viscous and Coulomb '
            'friction need at least two; record a speed ladder'
        )


def _cost(solution: LawSolution) -> float:
    return solution.cost


class LawSearch:
    """Find v_s and v0, decide what the data show, and say how sure it is."""

    def __init__(self, problem: LawProblem, speeds: FloatArray, v0: float | None) -> None:
        self.problem, self.form = problem, problem.form
        # Rows at rest are no speed of the law.
        self.slowest = float(np.quantile(speeds, 0.02) or np.quantile(speeds[speeds > 0.0], 0.02))
        self.fastest = float(speeds.max())
        self.level = float(np.median(np.abs(problem.y)))
        # Outside these ends exp(-|v| / v_s) is 0 or straight.
        first = max(self.slowest, 1e-3 * self.fastest) / _BELOW
        self.grid = np.geomspace(first, self.fastest, _GRID)
        self.finds_v0 = v0 is None
        signs = [v0] if v0 is not None else self._signs()
        coarse = self.grid[:: 2 if v0 is not None else _GRID // _COARSE]
        near = [0.0, *np.geomspace(0.5 * _LEAST_V0, _LARGEST_V0, _GRID // 3) * self.slowest]
        problem.span(
            [(v_s, sign) for sign in (near if v0 is None else signs) for v_s in self.grid[::2]],
            _FLAT * self.grid[0],
        )
        middle = float(np.median(coarse))
        # One set of weights for what is compared, or an outlier would count more in the poorer
        # model.
        self._weigh(min((problem.solve(middle, sign) for sign in signs[:2]), key=_cost).weights)
        tried = [self._solve(v_s, sign) for sign in signs for v_s in coarse]
        # A search that begins at the sign itself does not leave it: begin beside it as well.
        starts = [[fit for fit in tried if (fit.v0 > 0.0) == soft] for soft in (True, False)]
        refined = [
            self._refined(first.v_s, first.v0)
            for first in (min(some, key=_cost) for some in starts if some)
        ]
        best = min(refined, key=_cost)
        for _ in range(MOST_SOLVED):
            # Without S any v_s is as good, and rounding would choose.
            bare = problem.stribeck_at(best) <= _NOTHING * self.level
            last = self.weights
            self._weigh(problem.solve(None if bare else best.v_s, best.v0).weights)
            if bare:
                best = min((self._solve(v_s, best.v0) for v_s in coarse), key=_cost)
            best = self._refined(best.v_s, best.v0)
            if np.max(np.abs(self.weights - last)) < _LIKE_WEIGHTS:
                break
        if problem.stribeck_at(best) <= _NOTHING * self.level:
            best = self._solve(middle, best.v0)
        self.full = self._whole(best)
        self.plain = self._whole(self._plain())
        # With a smoother sign that fits better, but not by enough to be shown; of the law with a
        # Stribeck term and without.
        self.softer: dict[bool, LawSolution] = {}
        if self.finds_v0:
            self._settle_sign()

    def _signs(self) -> list[float]:
        return [0.0, *np.geomspace(_LEAST_V0, _LARGEST_V0, _SIGNS) * self.slowest]

    def _weigh(self, weights: FloatArray) -> None:
        """Take the weights of the rows in what is searched from here on."""
        self.weights, self.few = weights, self.problem.reduced(weights)

    def _solve(self, v_s: float | None, v0: float) -> LawSolution:
        """Return the best law of the reduced rows."""
        return self.few.solve(v_s, v0, np.ones(len(self.few.y)))

    def _whole(self, fit: LawSolution) -> LawSolution:
        """Return a law with what it leaves of every row."""
        return self.problem.solve(fit.v_s, fit.v0, self.weights)

    def _refined(self, v_s: float | None, v0: float) -> LawSolution:
        """Return the best fit near a start; v0 moves only if it is to be found and not zero."""
        ends = []
        if v_s is not None:
            ends.append((v_s, self.grid[0], self.grid[-1]))
        if self.finds_v0 and v0 > 0.0:
            ends.append((v0, 0.5 * _LEAST_V0 * self.slowest, _LARGEST_V0 * self.slowest))
        start, low, high = np.log(np.array(ends)).T
        size = max(float(np.linalg.norm(self.problem.y)), 1e-300)

        def at(u: FloatArray) -> LawSolution:
            e = np.exp(u)
            return self._solve(
                float(e[0]) if v_s is not None else None,
                float(e[-1]) if self.finds_v0 and v0 > 0.0 else v0,
            )

        middle = 0.5 * np.log(self.slowest * self.fastest)
        pull = np.sqrt(self.form.ridge if v_s is not None else 0.0)

        def misfit(u: FloatArray) -> FloatArray:
            residual = at(u).residual / size
            drawn = pull * float(np.linalg.norm(residual)) * (u[0] - middle)
            return np.append(residual, drawn) if pull > 0.0 else residual

        found = least_squares(
            misfit,
            np.clip(start, low + 1e-6, high - 1e-6),
            bounds=(low, high),
            x_scale=1.0,
            xtol=1e-10,
            ftol=1e-14,
            gtol=1e-14,
            max_nfev=30,
        )
        return at(found.x)

    def _plain(self) -> LawSolution:
        if not self.finds_v0:
            return self._solve(None, self.full.v0)
        tried = [self._solve(None, v0) for v0 in self._signs()]
        best = min(tried, key=_cost)
        return self._refined(None, best.v0) if best.v0 > 0.0 else best

    def _settle_sign(self) -> None:
        """Take the sign itself where the data do not show that it is smoother."""
        # Below this, differences of cost are rounding errors.
        least = _ROUNDING * float(np.sum(self.full.weights * self.problem.y**2))
        sharp = self._whole(self._refined(self.full.v_s, 0.0))
        if self.full.v0 > 0.0 and self.form.law != 'coulomb_viscous':
            limit = self._scale(self.full, 'smoothing_velocity', ()) * self._quantile(1)
            if self._is_endless(self.full) or not sharp.cost - self.full.cost > max(limit, least):
                self.softer[True], self.full = self.full, sharp
        if self.plain.v0 > 0.0:
            limit = self._scale(self.plain, 'smoothing_velocity', ()) * self._quantile(1)
            sharp = self._whole(self._solve(None, 0.0))
            if not sharp.cost - self.plain.cost > max(limit, least):
                self.softer[False], self.plain = self.plain, sharp

    def _is_endless(self, solution: LawSolution) -> bool:
        """
        Tell whether the width of the sign is the largest that is searched.

        Beside a Stribeck term it then stands for a bend that the law does not have.
        """
        return solution.v0 > (1.0 - _AT_END) * _LARGEST_V0 * self.slowest

    def _has_endless_knee(self, solution: LawSolution) -> bool:
        """Tell whether v_s is where its search ends: it stands for a bend, or for nothing."""
        first, last = (1.0 + _AT_END) * self.grid[0], (1.0 - _AT_END) * self.grid[-1]
        return solution.v_s is not None and not first < solution.v_s < last

    def _quantile(self, parameters: int) -> float:
        freedom = max(self.problem.count - len(self.problem.base) - 2, 1)
        return parameters * float(f_distribution.ppf(_LEVEL, parameters, freedom))

    def _scale(self, solution: LawSolution, name: str, without: tuple[str, ...]) -> float:
        """Return the rise of the cost that one jackknife standard error of ``name`` makes."""
        with_v0 = self.finds_v0 and solution.v0 > 0.0
        curvature = self.problem.curvature(solution, with_v0, without, name)
        if not curvature > 0.0:
            return 0.0
        variance = self.problem.covariance(solution, with_v0, without)[name, name]
        return variance / curvature

    def _shows_stribeck(self) -> bool:
        """Tell whether the extra term explains more than its parameters would by chance."""
        if self.form.law != 'auto':
            return self.form.law == 'stribeck' and self.problem.stribeck_at(self.full) > 0.0
        if self.problem.stribeck_at(self.full) <= 0.0:
            return False
        if self._is_driving():
            return False
        # The direction of S: that of v_s is not defined where S is small.
        self.unit = self._scale(self.full, 'stribeck', ('stribeck_velocity',))
        parameters = 1 + len(self.problem.knee)
        # Below this, differences of cost are rounding errors.
        rounding = _ROUNDING * float(np.sum(self.full.weights * self.problem.y**2))
        needed = max(self.unit * self._quantile(parameters), rounding)
        return self.plain.cost - self.full.cost > needed

    def _is_driving(self) -> bool:
        """
        Tell whether the term is below zero in one direction, and only below the data large.

        It then stands for a bend of friction that the law does not have, not for a knee.
        """
        p = dict(zip(self.problem.names(self.full.v_s), self.full.theta.tolist(), strict=True))
        below = self.full.v_s is not None and self.full.v_s < self.slowest / _HIDDEN
        return below and abs(p.get('stribeck_asymmetry', 0.0)) > p['stribeck']

    def _profile(self, unit: float, near: FloatArray | None = None) -> LawProfile:
        """Return the profile over v_s, v0 moving along where it is found."""
        problem, limit = self.few, unit * self._quantile(1)
        least = self._solve(self.full.v_s, self.full.v0).cost
        costs, best, half = [], [], []
        v0 = self.full.v0
        moves = self.finds_v0 and v0 > 0.0
        grid = self.grid
        if near is not None:
            # The grid may be wider than the interval.
            grid = np.sort(np.append(grid, near))
        for v_s in grid:
            fit = self._solve(v_s, v0)
            X = problem.columns(v_s, v0)
            if moves:
                X = np.column_stack([X, problem.jacobian(fit, True)[1][:, -1]])
            rest = fit.residual
            k = problem.names(v_s).index('stribeck')
            others = [j for j in range(X.shape[1]) if j != k]
            Q = np.linalg.qr(X[:, others])[0]
            own = X[:, k] - Q @ (Q.T @ X[:, k])
            left = rest - Q @ (Q.T @ rest) if moves else rest
            size = float(own @ own)
            cost = float(left @ left)
            S = problem.stribeck_at(fit)
            if size > 1e-24 * float(X[:, k] @ X[:, k]):
                # From the bound S >= 0, or with v0 moved, it may go on.
                step = max(float(own @ left) / size, -S)
                S, cost = S + step, cost - step * (2.0 * float(own @ left) - step * size)
                room = least + limit - cost
                half.append(float(np.sqrt(room / size)) if room >= 0.0 else np.nan)
            else:
                half.append(np.inf if least + limit >= cost else np.nan)
            costs.append(cost)
            best.append(S)
        rise = np.array(costs) - min(least, min(costs))
        safe = limit if limit > 0.0 else 1e-300
        return LawProfile(grid, rise / safe, np.array(best), np.array(half))

    def _near(
        self, best: Mapping[str, float], C: Mapping[tuple[str, str], float], quantile: float
    ) -> FloatArray:
        """Return v_s of the best fit, and about where its interval should end."""
        v_s = best['stribeck_velocity']
        half = quantile * float(np.sqrt(C['stribeck_velocity', 'stribeck_velocity'])) / v_s
        # Further than the grid it says nothing.
        half = min(half, float(np.log(self.grid[-1] / self.grid[0])))
        near = v_s * np.exp(half * np.linspace(-1.6, 1.6, _NEAR))
        return np.unique(near[(near > self.grid[0]) & (near < self.grid[-1])])

    def result(self, effort_unit: str) -> LawFit:
        """Return what is known of every parameter."""
        problem = self.problem
        shown = self._shows_stribeck()
        solution = self.full if shown else self.plain
        with_v0 = self.finds_v0 and solution.v0 > 0.0
        names = problem.names(solution.v_s) + (('stribeck_velocity',) if shown else ())
        best = dict(zip(problem.names(solution.v_s), solution.theta.tolist(), strict=True))
        if shown:
            best['stribeck_velocity'] = float(solution.v_s or np.nan)
        # What one that sits on its bound could be is not known either: the others are as unsure as
        # if it were free.
        still = tuple(n for n in names if n in NON_NEGATIVE and best[n] <= 0.0)
        C = problem.covariance(solution, with_v0)
        freedom = max(problem.count - len(names) - with_v0, 1)
        quantile = t_95(freedom)
        reach = DataReach(effort_unit, self.slowest, self.fastest, self.level, best)
        parameters = {}
        for name in names:
            if name == 'stribeck_velocity':
                continue
            parameters[name] = self._linear(
                name,
                best[name],
                None if name in still else C[name, name],
                quantile,
                reach,
                solution,
                with_v0,
            )
        extra = tuple(parameters.pop(name) for name in problem.extra)
        profile, derived = None, {}
        if self.form.law != 'coulomb_viscous':
            if shown:
                unit = self._scale(solution, 'stribeck_velocity', ())
            else:
                unit = getattr(self, 'unit', 0.0)
            if not shown and unit == 0.0:
                unit = self._plain_unit()
            profile = self._profile(unit, self._near(best, C, quantile) if shown else None)
        knee, identified = self._knee(shown, best, C, quantile, reach, profile)
        parameters.update(knee)
        if shown and not identified and profile is not None:
            for name in ('coulomb', 'viscous'):
                parameters[name] = self._along(name, parameters[name], profile, quantile, reach)
        if profile is not None and not identified:
            low, high = profile.stribeck_interval(self.slowest, self.form.alpha)
            value = np.nan
            if not shown:
                # No S at all is what the test did not refuse.
                low = 0.0
            else:
                left = fade(np.asarray(self.slowest), best['stribeck_velocity'], self.form.alpha)
                value = best['stribeck'] * float(left)
            derived[STRIBECK_AT_SLOWEST] = Parameter(
                value if low > 0.0 else np.nan,
                effort_unit,
                interval=(low, high),
                flags=() if low > 0.0 else (NOT_IDENTIFIABLE,),
            )
        if not self.form.symmetric:
            derived.update(self._by_direction(best, C, quantile, effort_unit, identified))
        ordered = [
            n
            for n in (
                'coulomb',
                'viscous',
                'stribeck',
                'stribeck_velocity',
                'bias',
                'viscous_asymmetry',
                'stribeck_asymmetry',
            )
            if n in parameters
        ]
        checked = {n: (best[n], parameters[n].interval) for n in best if n in parameters}
        of = tuple(n for n in names if (n, n) in C and n not in problem.extra)
        residual, scale = solution.residual, float(np.linalg.norm(problem.y))
        drawn_law = self.form.identifier(shown)
        fit = LawFit(
            self.form.identifier(shown and identified),
            {n: parameters[n] for n in ordered},
            float(np.sqrt(np.mean(residual**2))),
            100.0 * float(np.linalg.norm(residual)) / scale if scale > 0.0 else np.nan,
            len(problem.y),
            problem.count,
            solution.v0,
            derived,
            (
                dissipation_check(checked, effort_unit, self.slowest, self.fastest),
                self._odd_even(solution, with_v0, effort_unit),
            ),
            {n: x for n, x in best.items() if n not in problem.extra},
            drawn_law,
            np.array([[C[a, b] for b in of] for a in of]),
            of,
            profile,
            self.slowest,
            self.fastest,
            extra,
        )
        for other in self._unshown(shown):
            names = problem.names(other.v_s)
            values = dict(zip(names, other.theta.tolist(), strict=True))
            if other.v_s is not None:
                values['stribeck_velocity'] = other.v_s
            fit = fit.with_shift({n: values[n] - best[n] for n in of if n in values})
        return fit

    def _unshown(self, shown: bool) -> list[LawSolution]:
        """
        Return laws that fit better than what is named, by too little for it to be named.

        What ends at the end of a search is none found.
        """
        unshown = [self.softer[shown]] if shown in self.softer else []
        asked = self.form.law == 'auto' and not shown and not self._is_driving()
        if asked and self.problem.stribeck_at(self.full) > 0.0:
            unshown.append(self.full)
        return [x for x in unshown if not (self._is_endless(x) or self._has_endless_knee(x))]

    def _linear(
        self,
        name: str,
        value: float,
        variance: float | None,
        quantile: float,
        reach: DataReach,
        solution: LawSolution,
        with_v0: bool,
    ) -> Parameter:
        unit = '1' if name in self.problem.extra else unit_of(name, reach.effort_unit)
        if variance is None:
            # Free to move, it would go below zero: how far up it may be all the same.
            C = self.problem.covariance(solution, with_v0)
            free = self.problem.free_step(solution, with_v0, name)
            high = max(free + quantile * float(np.sqrt(C[name, name])), 0.0)
            reason = reason_for(name, reach, (0.0, high))
            if name == 'coulomb' and solution.v_s is not None:
                # All of the level at standstill may be Coulomb friction as well as S.
                high = max(high, self.problem.stribeck_at(solution))
                reason = _NO_COULOMB
            return Parameter(
                np.nan if reason else 0.0,
                unit,
                interval=(0.0, high),
                flags=(AT_BOUND, NOT_IDENTIFIABLE) if reason else (AT_BOUND,),
                reason=reason or AT_ZERO,
                experiment=experiment_for(name, reach) if reason else '',
            )
        error = float(np.sqrt(variance))
        interval = (value - quantile * error, value + quantile * error)
        reason = '' if name in self.problem.extra else reason_for(name, reach, interval)
        if reason:
            low = max(interval[0], 0.0) if name in NON_NEGATIVE else interval[0]
            return Parameter(
                np.nan,
                unit,
                interval=(low, interval[1]),
                flags=(NOT_IDENTIFIABLE,),
                reason=reason,
                experiment=experiment_for(name, reach),
            )
        return Parameter(value, unit, error, interval)

    def _along(
        self, name: str, found: Parameter, profile: LawProfile, quantile: float, reach: DataReach
    ) -> Parameter:
        """
        Return a parameter with what it may be at every v_s that the data leave open.

        The law is not linear in v_s over so wide a range, so that the jackknife at the best fit
        says too little: what is left of the limit at each v_s is left for the parameter there.
        """
        problem, v0 = self.problem, self.full.v0
        with_v0 = self.finds_v0 and v0 > 0.0
        open_ = np.flatnonzero(profile.excess <= 1.0)
        picked = np.unique(open_[np.linspace(0, len(open_) - 1, _ALONG).astype(int)])
        ends = [] if found.interval is None else [found.interval]
        for k in picked:
            v_s = float(profile.stribeck_velocity[k])
            fit = self._whole(self._solve(v_s, v0))
            value = float(fit.theta[problem.names(v_s).index(name)])
            C = problem.covariance(fit, with_v0, ('stribeck_velocity',))
            room = np.sqrt(max(1.0 - float(profile.excess[k]), 0.0))
            half = quantile * float(np.sqrt(C[name, name])) * room
            ends.append((value - half, value + half))
        interval = (max(min(low for low, _ in ends), 0.0), max(high for _, high in ends))
        reason = reason_for(name, reach, interval)
        if reason or NOT_IDENTIFIABLE in found.flags:
            return Parameter(
                np.nan,
                found.unit,
                interval=interval,
                flags=(*(f for f in found.flags if f == AT_BOUND), NOT_IDENTIFIABLE),
                reason=found.reason or reason,
                experiment=experiment_for(name, reach),
            )
        error = max(found.std_error, 0.5 * (interval[1] - interval[0]) / quantile)
        return replace(found, std_error=error, interval=interval)

    def _plain_unit(self) -> float:
        """Return the rise of the cost of one standard error, where there is no S to judge by."""
        fit = self.full
        with_v0 = self.finds_v0 and fit.v0 > 0.0
        return (
            self._scale(fit, 'stribeck', ('stribeck_velocity',))
            if not with_v0
            else (
                self.problem.covariance(fit, True, ('stribeck_velocity',))['stribeck', 'stribeck']
                / self.problem.curvature(fit, True, ('stribeck_velocity',), 'stribeck')
            )
        )

    def _knee(
        self,
        shown: bool,
        best: Mapping[str, float],
        C: Mapping[tuple[str, str], float],
        quantile: float,
        reach: DataReach,
        profile: LawProfile | None,
    ) -> tuple[dict[str, Parameter], bool]:
        """Return S and v_s, and whether the data give both."""
        units = {n: unit_of(n, reach.effort_unit) for n in ('stribeck', 'stribeck_velocity')}
        if profile is None:
            reason = 'the law that was asked for has no such term'
            return {
                n: Parameter(np.nan, unit, flags=(NOT_IDENTIFIABLE,), reason=reason)
                for n, unit in units.items()
            }, False
        v_s = profile.velocity_interval() if shown else (0.0, np.inf)
        reason = reason_for('stribeck_velocity', reach, v_s)
        if shown and not reason:
            # The interval of 95 % may be closed by chance; at three standard errors it is then
            # open or lopsided.
            wide = profile.velocity_interval(_SURE**2)
            if not (wide[0] > 0.0 and wide[1] <= SPREAD**_SURE * wide[0]):
                reason = reason_for('stribeck_velocity', reach, wide)
        if shown and best['coulomb'] <= 0.0:
            reason = _NO_COULOMB
        if shown and not reason:
            error = float(np.sqrt(C['stribeck', 'stribeck']))
            half = quantile * error
            S = (best['stribeck'] - half, best['stribeck'] + half)
            # S goes with the exponential of 1 / v_s: where that matters its range is lopsided.
            low, high = profile.stribeck_interval()
            reason = reason_for('stribeck', reach, (min(low, S[0]), max(high, S[1])))
            if not reason:
                return {
                    'stribeck': Parameter(best['stribeck'], units['stribeck'], error, S),
                    'stribeck_velocity': Parameter(
                        best['stribeck_velocity'],
                        units['stribeck_velocity'],
                        float(np.sqrt(C['stribeck_velocity', 'stribeck_velocity'])),
                        v_s,
                    ),
                }, True
        # What may fade below the slowest speed may be anything at standstill: no data reach there.
        reaches = v_s[0] >= self.slowest
        low, high = profile.stribeck_interval() if reaches else (0.0, np.inf)
        # C + S is the level at standstill, and C not negative.
        flags: tuple[str, ...] = (NOT_IDENTIFIABLE,)
        if not shown:
            low = 0.0
            high = self._largest_hidden(profile)
            if self.problem.stribeck_at(self.full) <= 0.0:
                flags = (NOT_IDENTIFIABLE, AT_BOUND)
        experiment = experiment_for('stribeck', reach)
        return {
            'stribeck': Parameter(
                np.nan,
                units['stribeck'],
                interval=(low, high),
                flags=flags,
                reason=reason,
                experiment=experiment,
            ),
            'stribeck_velocity': Parameter(
                np.nan,
                units['stribeck_velocity'],
                interval=v_s if shown else None,
                flags=(NOT_IDENTIFIABLE,),
                reason=reason,
                experiment=experiment,
            ),
        }, False

    def _largest_hidden(self, profile: LawProfile) -> float:
        """Return the largest S that may hide, for v_s from a third of the slowest speed up."""
        within = np.isfinite(profile.half) & (profile.stribeck_velocity >= self.slowest / _HIDDEN)
        if not within.any():
            return 0.0
        return float(max(np.max((profile.stribeck + profile.half)[within]), 0.0))

    def _by_direction(
        self,
        best: Mapping[str, float],
        C: Mapping[tuple[str, str], float],
        quantile: float,
        effort_unit: str,
        identified: bool,
    ) -> dict[str, Parameter]:
        pairs = [('coulomb', 'bias'), ('viscous', 'viscous_asymmetry')]
        if identified:
            pairs.append(('stribeck', 'stribeck_asymmetry'))
        result = {}
        for one, two in pairs:
            if (one, one) not in C:
                continue
            for way, side in ((1.0, 'positive'), (-1.0, 'negative')):
                value = best[one] + way * best[two]
                error = float(
                    np.sqrt(max(C[one, one] + C[two, two] + 2.0 * way * C[one, two], 0.0))
                )
                result[f'{one}_{side}'] = Parameter(
                    value,
                    unit_of(one, effort_unit),
                    error,
                    (value - quantile * error, value + quantile * error),
                )
        return result

    def _odd_even(self, solution: LawSolution, with_v0: bool, effort_unit: str) -> LawCheck:
        """Ask whether the even part of friction changes with speed."""
        problem, form = self.problem, self.form
        p = dict(zip(problem.names(solution.v_s), solution.theta.tolist(), strict=True))
        speeds = np.array([self.slowest, self.fastest])
        if form.symmetric:
            names, X = problem.jacobian(solution, with_v0)
            even = [problem.speed]
            if solution.v_s is not None:
                even.append(fade(problem.speed, solution.v_s, form.alpha))
            X = np.column_stack([X, *(problem.made(column) for column in even)])
            norms = column_norms(X)
            w = solution.weights
            root = np.sqrt(w)
            theta = np.linalg.lstsq(
                X / norms * root[:, None], solution.residual * root, rcond=1e-10
            )[0]
            rest = solution.residual - X / norms @ theta
            spread = jackknife_covariance(X / norms, rest, problem.groups, w)
            own = np.arange(X.shape[1] - len(even), X.shape[1])
            found = theta[own] / norms[own]
            C = spread[np.ix_(own, own)] / np.outer(norms[own], norms[own])
            bias = p['bias'] + float((theta / norms)[names.index('bias')])
        else:
            of = ['viscous_asymmetry', *(['stribeck_asymmetry'] if solution.v_s else [])]
            full = problem.covariance(solution, with_v0)
            found = np.array([p[name] for name in of])
            C = np.array([[full[a, b] for b in of] for a in of])
            bias = p['bias']
        shapes = [speeds]
        if solution.v_s is not None:
            shapes.append(fade(speeds, solution.v_s, form.alpha))
        even_at = np.array(shapes).T @ found
        inverse = np.linalg.pinv(C, rcond=1e-10)
        statistic = float(found @ inverse @ found) / len(found)
        freedom = max(problem.count - len(solution.theta) - 2, 1)
        chance = float(f_distribution.sf(statistic, len(found), freedom))
        peak: FloatArray | float = 0.0
        if solution.v_s is not None:
            peak = p['stribeck'] * fade(speeds, solution.v_s, form.alpha)
        odd_at = p['coulomb'] + peak + p['viscous'] * speeds
        return odd_even_check(
            speeds, odd_at, bias + even_at, chance, effort_unit, not form.symmetric
        )
