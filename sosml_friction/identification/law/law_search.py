# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Find the friction law that fits pairs of velocity and friction best."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import f as f_distribution

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.exceptions import DataError, MotionError
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_problem import (
    MOST_SOLVED,
    LawProblem,
    LawSolution,
)

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
#: v_s is searched from this part of the slowest speed on, and what may hide is told from a third.
_BELOW, HIDDEN = 8.0, 3.0
#: A search leaves 1e-6 of its ends; what is as near as this is at one.
_AT_END = 1e-3
#: v0 is searched between these multiples of the slowest speed.
_LEAST_V0, _LARGEST_V0 = 0.08, 2.0


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
    Intervals are 95 % with Student's t of as many degrees of freedom as the clusters that tell a
    parameter leave (:func:`~.jackknife.jackknife_freedom`). That of v_s
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
    """Find v_s and v0, and decide what the data show."""

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
        tried = [self.solve(v_s, sign) for sign in signs for v_s in coarse]
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
                best = min((self.solve(v_s, best.v0) for v_s in coarse), key=_cost)
            best = self._refined(best.v_s, best.v0)
            if np.max(np.abs(self.weights - last)) < _LIKE_WEIGHTS:
                break
        if problem.stribeck_at(best) <= _NOTHING * self.level:
            best = self.solve(middle, best.v0)
        self.full = self.whole(best)
        self.plain = self.whole(self._plain())
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

    def solve(self, v_s: float | None, v0: float) -> LawSolution:
        """Return the best law of the reduced rows."""
        return self.few.solve(v_s, v0, np.ones(len(self.few.y)))

    def whole(self, fit: LawSolution) -> LawSolution:
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
            return self.solve(
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
            return self.solve(None, self.full.v0)
        tried = [self.solve(None, v0) for v0 in self._signs()]
        best = min(tried, key=_cost)
        return self._refined(None, best.v0) if best.v0 > 0.0 else best

    def _settle_sign(self) -> None:
        """
        Take the sign itself where the data do not show that it is smoother.

        As if all clusters told it: a width that is found by chance, of few clusters, is no result
        and makes the others no surer, while one that is missed moves S.
        """
        freedom = max(self.problem.count - len(self.problem.base) - 2, 1)
        # Below this, differences of cost are rounding errors.
        least = _ROUNDING * float(np.sum(self.full.weights * self.problem.y**2))
        sharp = self.whole(self._refined(self.full.v_s, 0.0))
        if self.full.v0 > 0.0 and self.form.law != 'coulomb_viscous':
            limit = self.limit(self.full, 'smoothing_velocity', freedom=freedom)
            if self._is_endless(self.full) or not sharp.cost - self.full.cost > max(limit, least):
                self.softer[True], self.full = self.full, sharp
        if self.plain.v0 > 0.0:
            limit = self.limit(self.plain, 'smoothing_velocity', freedom=freedom)
            sharp = self.whole(self.solve(None, 0.0))
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

    def limit(
        self,
        solution: LawSolution,
        name: str,
        without: tuple[str, ...] = (),
        parameters: int = 1,
        freedom: float | None = None,
    ) -> float:
        """
        Return which fall of the cost by some parameters chance exceeds, in 5 %.

        The fall that one jackknife standard error of ``name``, one of them, makes, times a
        quantile of F, whose degrees of freedom are those of that standard error.

        :param freedom: these degrees of freedom instead.
        """
        with_v0 = self.finds_v0 and solution.v0 > 0.0
        curvature = self.problem.curvature(solution, with_v0, without, name)
        if not curvature > 0.0:
            return 0.0
        variance = self.problem.covariance(solution, with_v0, without)[name, name]
        if freedom is None:
            freedom = self.problem.freedom(solution, with_v0, without)[name]
        quantile = parameters * float(f_distribution.ppf(_LEVEL, parameters, freedom))
        return quantile * variance / curvature

    def shows_stribeck(self) -> bool:
        """Tell whether the extra term explains more than its parameters would by chance."""
        if self.form.law != 'auto':
            return self.form.law == 'stribeck' and self.problem.stribeck_at(self.full) > 0.0
        if self.problem.stribeck_at(self.full) <= 0.0:
            return False
        if self._is_driving():
            return False
        # The direction of S: that of v_s is not defined where S is small.
        parameters = 1 + len(self.problem.knee)
        limit = self.limit(self.full, 'stribeck', ('stribeck_velocity',), parameters)
        # Below this, differences of cost are rounding errors.
        rounding = _ROUNDING * float(np.sum(self.full.weights * self.problem.y**2))
        return self.plain.cost - self.full.cost > max(limit, rounding)

    def _is_driving(self) -> bool:
        """
        Tell whether the term is below zero in one direction, and only below the data large.

        It then stands for a bend of friction that the law does not have, not for a knee.
        """
        p = dict(zip(self.problem.names(self.full.v_s), self.full.theta.tolist(), strict=True))
        below = self.full.v_s is not None and self.full.v_s < self.slowest / HIDDEN
        return below and abs(p.get('stribeck_asymmetry', 0.0)) > p['stribeck']

    def unshown(self, shown: bool) -> list[LawSolution]:
        """
        Return laws that fit better than what is named, by too little for it to be named.

        What ends at the end of a search is none found.
        """
        unshown = [self.softer[shown]] if shown in self.softer else []
        asked = self.form.law == 'auto' and not shown and not self._is_driving()
        if asked and self.problem.stribeck_at(self.full) > 0.0:
            unshown.append(self.full)
        return [x for x in unshown if not (self._is_endless(x) or self._has_endless_knee(x))]
