# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Find the friction law that fits pairs of velocity and friction best."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import f as f_distribution

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.exceptions import DataError, MotionError
from sosml_friction.identification.law.law_form import ALPHAS, LawForm
from sosml_friction.identification.law.law_problem import (
    EXPONENT,
    MOST_SOLVED,
    SIGN_WIDTH,
    LawProblem,
    LawSolution,
)
from sosml_friction.model.terms.kinds.fading_term import EXPONENTS
from sosml_friction.model.terms.nonlinear_viscous import POWERS, NonlinearViscous
from sosml_friction.regression.chance import CHANCE
from sosml_friction.regression.rival import rival_probability
from sosml_friction.regression.signals import WIDEST_SIGN

#: Share of the friction level that is no S.
_NOTHING = 1e-9
#: Share of the sum of squares that is a rounding error.
_ROUNDING = 1e-20
LEVEL = 0.95
#: v_s is searched anew until no weight changes by more than this. Chosen, no measurement.
_LIKE_WEIGHTS = 1e-3
#: Laws are compared from this share of the least v_s on: there they are flat.
_FLAT = 1e-3
#: Number of speeds of the profile, of the coarse search over v_s, and of that over v0.
_GRID, _COARSE, _SIGNS = 36, 12, 5
#: Number of exponents that are tried at each v_s; the reduced columns are made for as many, at
#: every fourth v_s and v0. Chosen, no measurement, as are the next.
_ALPHAS, _FEWER = 8, 4
#: v_s is searched from this part of the slowest speed on, and what may hide is told from a third.
_BELOW, HIDDEN = 8.0, 3.0
#: A knee has faded at this many times v_s, to exp(-2) or less. Chosen, no measurement.
_FADED = 2.0
#: A search leaves 1e-6 of its ends; what is as near as this is at one.
_AT_END = 1e-3
#: v0 is searched between these multiples of the slowest speed, and where it is at the end of that,
#: on to the widest that is a sign.
_LEAST_V0, _LARGEST_V0 = 0.08, 2.0
#: Where searches of the exponent begin, to both sides of the usual one, 1.
_BENDS = (0.7, 1.6)


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

    For a given v_s (and alpha, and v0 of the sign s, where they are to be found) the law is
    linear: these are searched, the rest solved with Huber weights. The estimates' covariance is
    that of the delete-one-cluster jackknife of the linearised fit, all parameters together, so
    that noise may be correlated within a cluster and of any size in each, times (E w / E psi')^2
    (the variance of Huber's estimate is larger than least squares with his weights w says).
    Intervals are 95 % with Student's t of as many degrees of freedom as the clusters that tell a
    parameter leave (:func:`~.jackknife.jackknife_freedom`). That of v_s
    is where the profile of the cost is below a limit, which is scaled so that the width agrees
    with the standard error of the jackknife.

    The Stribeck term is kept if an F test at 95 % says that it explains more than its two
    parameters would by chance; v0 of the sign, and another alpha than 1, if one of one parameter
    does. What fits better by less than that may be true all the same: what it moves the parameters
    by is in their covariance, V + d d^T.
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


def within(value: float, ends: tuple[float, float]) -> bool:
    """Tell whether a search ended within its ends, and not at one of them."""
    return (1.0 + _AT_END) * ends[0] < value < (1.0 - _AT_END) * ends[1]


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
        self.finds_alpha = self.form.alpha is None and self.form.law != 'coulomb_viscous'
        self.coarse = self.grid[:: 2 if v0 is not None else _GRID // _COARSE]
        self.widest = _LARGEST_V0 * self.slowest
        best = self._searched(v0)
        if self.finds_v0 and self._is_endless(best) and self.widest < WIDEST_SIGN * self.fastest:
            self.widest = WIDEST_SIGN * self.fastest
            best = self._searched(v0)
        # What fits better than ``full`` and ``plain``, but not by enough to be shown.
        self.full, unshown = self._settled(self.whole(best))
        self.plain, without = self._settled(self.whole(self._plain()))
        self._refused = {True: unshown, False: without}
        # All that follows is of the reduced rows, or of one law.
        problem.forget()

    def _searched(self, v0: float | None) -> LawSolution:
        """Return the best law with a v0 up to the widest, and take the weights of its rows."""
        problem, usual = self.problem, self.form.usual
        signs = [v0] if v0 is not None else self._signs(_SIGNS, _LEAST_V0)
        signs_of_span = signs if v0 is not None else self._signs(_GRID // 3, 0.5 * _LEAST_V0)
        laws = [(v_s, sign, usual) for sign in signs_of_span for v_s in self.grid[::2]]
        if self.finds_alpha:
            bends = np.geomspace(*EXPONENTS, _ALPHAS)
            laws += [
                (v_s, sign, float(alpha))
                for sign in signs_of_span[::_FEWER]
                for v_s in self.grid[::_FEWER]
                for alpha in bends
            ]
            laws += [(v, sign, np.nan) for sign in signs_of_span[::_FEWER] for v in self.grid[::2]]
        problem.span(laws, _FLAT * self.grid[0])
        middle = float(np.median(self.coarse))
        # One set of weights for what is compared, or an outlier would count more in the poorer
        # model.
        first_fits = (problem.solve(middle, sign, usual) for sign in signs[:2])
        self._weigh(min(first_fits, key=_cost).weights)
        tried = [self.solve(v_s, sign, usual) for sign in signs for v_s in self.coarse]
        # A search that begins at the sign itself does not leave it: begin beside it as well.
        starts = [[fit for fit in tried if (fit.v0 > 0.0) == soft] for soft in (True, False)]
        refined = [self._refined(min(some, key=_cost)) for some in starts if some]
        best = self._reweighed(min(refined, key=_cost))
        if self._is_bare(best):
            best = self.solve(middle, best.v0, usual)
        return best

    def _signs(self, count: int, least: float) -> list[float]:
        """
        Return widths of the sign: itself, and from a multiple of the slowest speed to the widest.

        ``count`` of them up to the usual end, as near to each other beyond it.
        """
        usual = np.log(_LARGEST_V0 / least)
        more = np.log(self.widest / (_LARGEST_V0 * self.slowest)) / usual
        number = count + round((count - 1) * float(more))
        return [0.0, *np.geomspace(least * self.slowest, self.widest, number)]

    def found(self, solution: LawSolution) -> tuple[str, ...]:
        """Return which parameters that are not linear were found beside v_s."""
        width = self.finds_v0 and solution.v0 > 0.0
        bent = self.finds_alpha and solution.v_s is not None
        bent = bent and solution.alpha != self.form.usual and not np.isnan(solution.alpha)
        return (*([SIGN_WIDTH] if width else []), *([EXPONENT] if bent else []))

    def _is_bare(self, solution: LawSolution) -> bool:
        """Tell whether the best S is none: then any v_s is as good, and rounding would choose."""
        return self.problem.stribeck_at(solution) <= _NOTHING * self.level

    def _reweighed(self, best: LawSolution) -> LawSolution:
        """Return the best law near one at weights of its own, and take these."""
        for _ in range(MOST_SOLVED):
            bare, last = self._is_bare(best), self.weights
            v_s = None if bare else best.v_s
            self._weigh(self.problem.solve(v_s, best.v0, best.alpha).weights)
            if bare:
                at = (self.solve(v_s, best.v0, best.alpha) for v_s in self.coarse)
                best = min(at, key=_cost)
            best = self._refined(best)
            if np.max(np.abs(self.weights - last)) < _LIKE_WEIGHTS:
                break
        return best

    def _weigh(self, weights: FloatArray) -> None:
        """Take the weights of the rows in what is searched from here on."""
        self.weights, self.few = weights, self.problem.reduced(weights)

    def solve(self, v_s: float | None, v0: float, alpha: float) -> LawSolution:
        """Return the best law of the reduced rows."""
        return self.few.solve(v_s, v0, alpha, self.few.ones)

    def whole(self, fit: LawSolution) -> LawSolution:
        """Return a law with what it leaves of every row."""
        return self.problem.solve(fit.v_s, fit.v0, fit.alpha, self.weights)

    def at(self, v_s: float) -> LawSolution:
        """
        Return the best law of the reduced rows at a v_s, of any exponent that it may have.

        One that the data do not show is from 1 to 2, as published. It is the best of some, or
        where a parabola through it and its neighbours is least.
        """
        v0, alpha = self.full.v0, self.full.alpha
        if not self.finds_alpha:
            return self.solve(v_s, v0, alpha)
        low, high = np.log(self.exponents)
        u = np.linspace(low, high, _ALPHAS)
        tried = [self.solve(v_s, v0, each) for each in (*np.exp(u).tolist(), alpha)]
        costs = [one.cost for one in tried[:_ALPHAS]]
        k = int(np.argmin(costs))
        if 0 < k < _ALPHAS - 1:
            before, least, after = costs[k - 1 : k + 2]
            by = 0.5 * (before - after) / max(before - 2.0 * least + after, np.finfo(float).tiny)
            tried.append(self.solve(v_s, v0, float(np.exp(u[k] + by * (u[1] - u[0])))))
        return min(tried, key=_cost)

    def _refined(self, near: LawSolution) -> LawSolution:
        """Return the best fit near a start: v_s and what is found of it move."""
        ends, found = [], self.found(near)
        if near.v_s is not None:
            ends.append((near.v_s, self.grid[0], self.grid[-1]))
        if SIGN_WIDTH in found:
            ends.append((near.v0, 0.5 * _LEAST_V0 * self.slowest, self.widest))
        if EXPONENT in found:
            ends.append((near.alpha, *EXPONENTS))
        if not ends:
            return near
        start, low, high = np.log(np.array(ends)).T
        size = max(float(np.linalg.norm(self.problem.y)), 1e-300)

        def at(u: FloatArray) -> LawSolution:
            moved = iter(np.exp(u).tolist())
            v_s = None if near.v_s is None else next(moved)
            v0 = next(moved) if SIGN_WIDTH in found else near.v0
            return self.solve(v_s, v0, next(moved) if EXPONENT in found else near.alpha)

        middle = 0.5 * np.log(self.slowest * self.fastest)
        pull = np.sqrt(self.form.ridge if near.v_s is not None else 0.0)

        def misfit(u: FloatArray) -> FloatArray:
            residual = at(u).residual / size
            drawn = pull * float(np.linalg.norm(residual)) * (u[0] - middle)
            return np.append(residual, drawn) if pull > 0.0 else residual

        best = least_squares(
            misfit,
            np.clip(start, low + 1e-6, high - 1e-6),
            bounds=(low, high),
            x_scale=1.0,
            xtol=1e-10,
            ftol=1e-14,
            gtol=1e-14,
            max_nfev=30,
        )
        return at(best.x)

    def _plain(self) -> LawSolution:
        usual = self.form.usual
        if not self.finds_v0:
            return self.solve(None, self.full.v0, usual)
        tried = [self.solve(None, v0, usual) for v0 in self._signs(_SIGNS, _LEAST_V0)]
        return self._refined(min(tried, key=_cost))

    def _settled(self, best: LawSolution) -> tuple[LawSolution, list[LawSolution]]:
        """
        Return a law with the sign itself and the usual exponent, or what the data show of both.

        And laws that fit better by less than what shows it. What explains most is taken first,
        the other beside it.
        """
        if self.form.law == 'coulomb_viscous' and best.v_s is not None:
            return best, []
        taken, asked = best, []
        if SIGN_WIDTH in self.found(best):
            taken = self.whole(self._refined(replace(best, v0=0.0)))
            asked.append(SIGN_WIDTH)
        if self.finds_alpha and best.v_s is not None and not self._is_bare(taken):
            asked.append(EXPONENT)
        while asked:
            tried = {name: self._with(name, taken, best.v0) for name in asked}
            name = min(tried, key=lambda one: tried[one].cost)
            if not self._is_shown(name, tried[name], taken):
                return taken, [x for x in tried.values() if x.cost < taken.cost]
            taken = tried[name]
            asked.remove(name)
            if name == EXPONENT:
                # The rows of the knee did not count as they should.
                taken = self.whole(self._reweighed(taken))
        return taken, []

    def _with(self, name: str, taken: LawSolution, v0: float) -> LawSolution:
        """Return the best law with one parameter more, v0 from a start."""
        if name == SIGN_WIDTH:
            return self.whole(self._refined(replace(taken, v0=v0)))
        starts = (
            min((self.solve(v_s, taken.v0, alpha) for v_s in self.coarse), key=_cost)
            for alpha in _BENDS
        )
        return self.whole(min(map(self._refined, starts), key=_cost))

    def _is_shown(self, name: str, more: LawSolution, less: LawSolution) -> bool:
        """
        Tell whether a law explains more, by one parameter, than chance would.

        The width of a sign as if all clusters told it: one that is found by chance, of few
        clusters, is no result and makes the others no surer, while one that is missed moves S.
        """
        # A knee at an end of its search is a bend, whatever its exponent.
        if self._is_endless(more) or (name == EXPONENT and not self._has_knee(more)):
            return False
        if not self.problem.tells(more, self.found(more), name):
            return False
        freedom = None
        if name == SIGN_WIDTH:
            freedom = max(self.problem.count - len(self.problem.base) - 2, 1)
        # Below this, differences of cost are rounding errors.
        least = _ROUNDING * float(np.sum(less.weights * self.problem.y**2))
        return less.cost - more.cost > max(self.limit(more, name, freedom=freedom), least)

    def _is_endless(self, solution: LawSolution) -> bool:
        """Tell whether the sign is as wide as is searched: a bend that the law does not have."""
        return solution.v0 > (1.0 - _AT_END) * self.widest

    @property
    def exponents(self) -> tuple[float, float]:
        """Return the ends of the exponents that the law may have, published ones if not found."""
        return EXPONENTS if EXPONENT in self.found(self.full) else ALPHAS

    def _ends(self, solution: LawSolution) -> bool:
        """Tell whether a search ended at one of its ends: what is there is none found."""
        if self._is_endless(solution):
            return True
        if EXPONENT in self.found(solution) and not within(solution.alpha, EXPONENTS):
            return True
        return not self._has_knee(solution)

    def _has_knee(self, solution: LawSolution) -> bool:
        """Tell whether v_s is within its search, or not asked for; at an end it is a bend."""
        v_s = solution.v_s
        return v_s is None or within(v_s, (self.grid[0], self.grid[-1]))

    def limit(
        self,
        solution: LawSolution,
        name: str,
        without: tuple[str, ...] = (),
        parameters: int = 1,
        freedom: float | None = None,
        level: float = LEVEL,
    ) -> float:
        """
        Return which fall of the cost by some parameters chance exceeds, in 5 % or 1 - level.

        The fall that one jackknife standard error of ``name``, one of them, makes, times a
        quantile of F, whose degrees of freedom are those of that standard error.

        :param freedom: these degrees of freedom instead.
        """
        unit = self._unit(solution, name, without)
        if not unit > 0.0:
            return 0.0
        if freedom is None:
            freedom = self.problem.freedom(solution, self.found(solution), without)[name]
        return parameters * float(f_distribution.ppf(level, parameters, freedom)) * unit

    @property
    def last_knee(self) -> float:
        """Return the largest v_s of which a term has faded at the fastest speed."""
        return self.fastest / _FADED

    @staticmethod
    def is_smooth(law: LawSolution) -> bool:
        """Tell whether a Stribeck term is no wider than its sign."""
        return law.v_s is not None and law.v0 >= law.v_s

    def is_knee(self, law: LawSolution) -> bool:
        """Tell whether a Stribeck term is one: it fades within the data to Coulomb friction."""
        if law.v_s is None or self.is_smooth(law):
            return False
        return law.v_s <= self.last_knee and self.problem.values_of(law)['coulomb'] > 0.0

    def _unit(self, solution: LawSolution, name: str, without: tuple[str, ...] = ()) -> float:
        """Return how much the cost rises by one jackknife standard error of a parameter."""
        found = self.found(solution)
        curvature = self.problem.curvature(solution, found, without, name)
        if not curvature > 0.0:
            return 0.0
        return self.problem.covariance(solution, found, without)[name, name] / curvature

    def probability(self, rival: LawSolution, law: LawSolution | None = None) -> float:
        """Return how probable a law of as many numbers is beside another, the best by default."""
        unit = max(self._unit(self.full, 'stribeck'), np.finfo(float).tiny)
        return rival_probability((rival.cost - (law or self.full).cost) / unit)

    @cached_property
    def bends(self) -> dict[float, LawProblem]:
        """Return the problems of the reduced rows with a power of speed besides."""
        return {power: self.few.bent(power) for power in POWERS}

    def bent(
        self, law: LawSolution, named: LawSolution
    ) -> tuple[LawSolution, dict[str, float]] | None:
        """
        Return a law with the power of speed that explains most beside it, and its parameters.

        The width of its sign may have stood for that: then with the sign itself. None if it
        explains no more than its size and power would by chance, in 1 %, as the law that is
        ``named`` knows it.
        """
        tried = {
            (power, v0): its.solve(law.v_s, v0, law.alpha, its.ones)
            for power, its in self.bends.items()
            for v0 in dict.fromkeys((law.v0, 0.0))
        }
        power, v0 = min(tried, key=lambda one: tried[one].cost)
        best = tried[power, v0]
        least = _ROUNDING * float(np.sum(law.weights * self.problem.y**2))
        limit = self.limit(named, 'coulomb', parameters=2, level=1.0 - CHANCE)
        if law.cost - best.cost <= max(limit, least):
            return None
        return replace(law, v0=v0), self.bends[power].values_of(best)

    def unfaded(self, law: LawSolution) -> tuple[LawSolution, dict[str, float], float] | None:
        """
        Return the best law with a power of speed in place of the Stribeck term of ``law``.

        With its parameters and its probability beside ``law``, which has as many. None if that
        power would drive the joint.
        """
        (name,) = NonlinearViscous.amplitudes
        usual, found = self.form.usual, []
        for its in self.bends.values():
            for v0 in dict.fromkeys((law.v0, self.plain.v0, 0.0)):
                one = its.solve(None, v0, usual, its.ones)
                found.append((one, its.values_of(one)))
        best, values = min(found, key=lambda one: one[0].cost)
        if values[name] <= 0.0:
            return None
        return best, values, self.probability(best, law)

    @cached_property
    def knee_limit(self) -> float:
        """Return what the Stribeck term lowers the cost by at most if chance does, in 5 %."""
        # The direction of S: that of v_s is not defined where S is small.
        parameters = 1 + len(self.problem.knee) + (EXPONENT in self.found(self.full))
        limit = self.limit(self.full, 'stribeck', ('stribeck_velocity',), parameters)
        # Below this, differences of cost are rounding errors.
        return max(limit, _ROUNDING * float(np.sum(self.full.weights * self.problem.y**2)))

    def shows_stribeck(self) -> bool:
        """Tell whether the extra term explains more than its parameters would by chance."""
        if self.form.law != 'auto':
            return self.form.law == 'stribeck' and self.problem.stribeck_at(self.full) > 0.0
        if self.problem.stribeck_at(self.full) <= 0.0:
            return False
        if self._is_driving():
            return False
        if self.plain.cost - self.full.cost <= self.knee_limit:
            return False
        return not self.form.symmetric or self._shows_beside_direction(self.knee_limit)

    def _shows_beside_direction(self, limit: float) -> bool:
        """
        Tell whether the term explains as much where viscous friction differs by direction.

        That changes with speed and is no knee, but what is left of it by chance may look like one.
        """
        free = self.problem.asymmetric()
        full, plain = (
            free.solve(law.v_s, law.v0, law.alpha, law.weights) for law in (self.full, self.plain)
        )
        return plain.cost - full.cost > limit

    def _is_driving(self) -> bool:
        """Tell whether S drives in one direction and is large below the data only: no knee."""
        p = dict(zip(self.problem.names(self.full.v_s), self.full.theta.tolist(), strict=True))
        below = self.full.v_s is not None and self.full.v_s < self.slowest / HIDDEN
        return below and abs(p.get('stribeck_asymmetry', 0.0)) > p['stribeck']

    def unshown(self, shown: bool) -> list[LawSolution]:
        """Return laws that fit better by too little to be named, none at an end of its search."""
        unshown = list(self._refused[shown])
        asked = self.form.law == 'auto' and not shown and not self._is_driving()
        if asked and self.problem.stribeck_at(self.full) > 0.0:
            unshown.append(self.full)
        return [x for x in unshown if not self._ends(x)]

    def broad(self) -> tuple[LawSolution, float] | None:
        """Return the best law with the broad knee and its probability; None if it has none."""
        if not self.finds_alpha:
            return None
        tried = [self.solve(v_s, self.full.v0, np.nan) for v_s in self.coarse]
        law = self.whole(self._refined(min(tried, key=_cost)))
        if self._ends(law):
            return None
        return law, self.probability(law)
