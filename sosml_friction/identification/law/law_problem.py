# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The regression of a friction law: linear at each v_s and exponent, and v0 of its sign."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr
from scipy.optimize import lsq_linear

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.identification.law.jackknife import jackknife_covariance, jackknife_freedom
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.parameter_interval import NON_NEGATIVE
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.kinds.fading_term import broad_fade, fade, fade_slopes
from sosml_friction.model.terms.nonlinear_viscous import POWERS, NonlinearViscous, power_columns
from sosml_friction.model.terms.viscous_asymmetry import ViscousAsymmetry
from sosml_friction.regression.column_norms import column_norms, told_beside
from sosml_friction.regression.kernels import ROWS_AT_ONCE

#: Iterations for Huber's weights end when no weight changes by more than the first number, or
#: after the second. Chosen, no measurement.
_SAME_WEIGHTS, MOST_SOLVED = 1e-6, 20
_HUBER = 1.345  # 95 % efficient on normal noise
#: Laws are compared at this many speeds. So many powers of speed, over their whole range, make any
#: to 1e-8, which test/identification/law/test_reduction.py asks for.
_SPEEDS, _POWERS = 200, 12
#: Others stand for a column if they leave less than this share of the largest one: the square root
#: of rounding, so that sums of squares are exact.
_LEFT = 1e-8
#: So few rows are solved as they are: a triangle of 50 takes about as long as their solution.
#: Chosen, no measurement.
_FEW = 100
#: Parameters that may be found beside v_s or without it, none of them linear.
SIGN_WIDTH, EXPONENT, POWER = 'smoothing_velocity', 'exponent', 'power'
#: Names, and a column (K,) of each.
_Slopes = tuple[tuple[str, ...], FloatArray]


@dataclass(frozen=True)
class LawSolution:
    """
    Hold the best law for a v_s, None without Stribeck term, and a v0 of the sign, 0 for itself.

    ``alpha``: exponent of the Stribeck term, NaN of the broad one, which has none. ``theta``
    (P,): linear parameters, in the order of the problem's names; ``weights`` and ``residual``
    (K,) of the rows; ``cost``: sum of w r^2.
    """

    theta: FloatArray
    v_s: float | None
    v0: float
    alpha: float
    weights: FloatArray
    residual: FloatArray
    cost: float


class LawProblem:
    """
    Pose y = L [s(v) (C + S exp(-(|v| / v_s)^alpha)) + B v + bias] for any v_s, alpha and v0 of s.

    The arguments are those of :func:`~sosml_friction.identification.law.law_search.search_law`, y
    and ``extra`` those of the rows that take part; ``made`` is L, and of its result these rows.
    """

    def __init__(
        self,
        v: FloatArray,
        y: FloatArray,
        groups: IndexArray,
        lag: Callable[[FloatArray], FloatArray],
        keep: BoolArray,
        form: LawForm,
        extra: FloatArray,
        unsure: FloatArray,
    ) -> None:
        self.v, self.y, self.groups, self.form = v, y, groups, form
        self.unsure = unsure[keep]
        self.made: Callable[[FloatArray], FloatArray] = lambda column: lag(column)[keep]
        self.speed, self.count = np.abs(v), int(groups.max()) + 1
        self.extra = tuple(f'extra_{k}' for k in range(extra.shape[1]))
        self.power: float | None = None
        self.base = (
            'coulomb',
            'viscous',
            'bias',
            *(() if form.symmetric else ('viscous_asymmetry',)),
            *self.extra,
        )
        self.knee = ('stribeck',) if form.symmetric else ('stribeck', 'stribeck_asymmetry')
        constant = [v, np.ones_like(v)] + ([] if form.symmetric else [self.speed])
        self._constant = np.column_stack(
            [self.made(column) for column in constant] + [extra[keep]]
        )
        self.forget()

    def forget(self) -> None:
        """Forget the columns that span laws, and sign and derivatives that were asked for last."""
        self._spanned: tuple[LawProblem, FloatArray, FloatArray] | None = None
        self._signs: tuple[float, FloatArray, FloatArray] | None = None
        self._slopes: tuple[LawSolution, tuple[str, ...], _Slopes] | None = None

    def bent(self, power: float) -> LawProblem:
        """Return the problem with nonlinear viscous friction of a power of speed besides."""
        (name,) = NonlinearViscous.amplitudes
        result = self._with(name, power_columns(self.v, power)[0])
        result.power = power
        return result

    def asymmetric(self) -> LawProblem:
        """Return the problem of a symmetric law with viscous friction that does differ."""
        (name,) = ViscousAsymmetry.amplitudes
        return self._with(name, self.speed)

    def made_by(self, made: Callable[[FloatArray], FloatArray]) -> LawProblem:
        """Return the problem with rows made in another way of what is dry friction."""
        result = copy(self)
        result.made = made
        result.forget()
        return result

    def less(self, effort: FloatArray) -> LawProblem:
        """Return the problem of what is left beside an effort at all velocities."""
        result = copy(self)
        result.y = self.y - self.made(effort)
        return result

    def _with(self, name: str, column: FloatArray) -> LawProblem:
        """Return the problem with one more column, at all velocities."""
        result = copy(self)
        result.base = (*self.base, name)
        result.forget()
        result._constant = np.column_stack([self._constant, self.made(column)])
        return result

    def span(self, laws: Sequence[tuple[float, float, float]], slowest: float) -> None:
        """
        Find a few columns that those of ``laws``, each v_s, v0 and alpha, are combinations of.

        So are those of any power of speed. Laws are smooth over the logarithm of speed:
        combinations are the same at all velocities as at some speeds from ``slowest`` on.
        """
        speeds = np.geomspace(slowest, self.speed.max(), _SPEEDS)
        at = copy(self)
        at.v = speeds if self.form.symmetric else np.concatenate([-speeds[::-1], [0.0], speeds])
        at.forget()
        at.speed, at.made = np.abs(at.v), lambda column: column
        at._constant = np.empty((len(at.v), 0))
        if len(self.y) <= len(at.v):
            # Its rows are few as they are.
            return
        of_laws = np.column_stack([at.columns(*law) for law in laws])
        count, of_law = of_laws.shape[1], of_laws.shape[1] // len(laws)
        fastest, powers = speeds[-1], np.geomspace(POWERS[0], POWERS[-1], _POWERS).tolist()
        drags = [power_columns(at.v / fastest, power)[0] for power in powers]
        columns = np.column_stack([of_laws, *drags])
        picked = spanning(columns)
        own = np.empty((len(self.y), len(picked)))
        for j, k in enumerate(picked.tolist()):
            if k < count:
                (v_s, v0, alpha), column = laws[k // of_law], k % of_law
                # The first column of a law is the sign, then come those of the knee.
                sign = smooth_sign(self.v, v0)
                whole = self._knees(sign, v_s, alpha)[column - 1] if column else sign
            else:
                whole = power_columns(self.v / fastest, powers[k - count])[0]
            own[:, j] = self.made(whole)
        combination = np.asarray(np.linalg.pinv(columns[:, picked]))
        self._spanned = (at, combination, own)

    def reduced(self, weights: FloatArray) -> LawProblem:
        """
        Return a regression of few rows with the same solutions and costs, at these weights.

        With the rows sqrt(w) [columns that span the laws, columns that do not change, y] = Q R, it
        has the rows of R.
        """
        root, few = np.sqrt(weights)[:, None], copy(self)
        few.forget()
        if self._spanned is None:
            few.y, few._constant = self.y * root[:, 0], self._constant * root
            few.made = lambda column: self.made(column) * root[:, 0]
            return few
        at, combination, own = self._spanned
        R = triangle(root[:, 0], own, self._constant, self.y[:, None])
        rows = R[:, : own.shape[1]] @ combination
        few.v, few.speed, few.made = at.v, at.speed, lambda column: np.array(rows @ column)
        few.y, few._constant = R[:, -1], R[:, own.shape[1] : -1]
        return few

    def names(self, v_s: float | None) -> tuple[str, ...]:
        """Return the linear parameters, in the order of the columns."""
        return self.base if v_s is None else (*self.base, *self.knee)

    def values_of(self, solution: LawSolution) -> dict[str, float]:
        """Return the parameters of a law by name, v_s and exponent with those it is linear in."""
        values = dict(zip(self.names(solution.v_s), solution.theta.tolist(), strict=True))
        if self.power is not None:
            values[POWER] = self.power
        if solution.v_s is None:
            return values
        values['stribeck_velocity'] = solution.v_s
        return values if np.isnan(solution.alpha) else {**values, EXPONENT: solution.alpha}

    def _sign(self, v0: float) -> tuple[FloatArray, FloatArray]:
        if self._signs is None or self._signs[0] != v0:
            sign = smooth_sign(self.v, v0)
            self._signs = (v0, sign, np.column_stack([self.made(sign), self._constant]))
        return self._signs[1:]

    def columns(self, v_s: float | None, v0: float, alpha: float) -> FloatArray:
        """Return the columns of the linear parameters (K, P)."""
        sign, fixed = self._sign(v0)
        if v_s is None:
            return fixed
        knees = self._knees(sign, v_s, alpha)
        return np.column_stack([fixed, *(self.made(each) for each in knees)])

    def _knees(self, sign: FloatArray, v_s: float, alpha: float) -> list[FloatArray]:
        """Return what the sizes of the knee are multiplied with, at all velocities."""
        broad = np.isnan(alpha)
        peak = sign * (broad_fade(self.speed, v_s) if broad else fade(self.speed, v_s, alpha))
        return [peak] if self.form.symmetric else [peak, np.abs(peak)]

    def solve(
        self, v_s: float | None, v0: float, alpha: float, weights: FloatArray | None = None
    ) -> LawSolution:
        """Solve for the linear parameters: Huber weights of its own where none are given."""
        X = self.columns(v_s, v0, alpha)
        names = self.names(v_s)
        lower = np.array([0.0 if name in NON_NEGATIVE else -np.inf for name in names])
        scale = column_norms(X)
        like = X / scale
        # A fit with p parameters leaves sqrt((n - p) / n) of the noise.
        left = np.sqrt(max(self.count - len(names) - (v_s is not None), 1) / self.count)
        w = np.ones(len(self.y)) if weights is None else weights
        for _ in range(MOST_SOLVED):
            root = np.sqrt(w)
            if len(w) > _FEW:
                # The bounds need only the triangle: a long recording is reduced to it first.
                whole = triangle(root, like, self.y[:, None])
                R, moment = whole[: len(names), :-1], whole[: len(names), -1]
            else:
                R, moment = like * root[:, None], self.y * root
            if self.form.ridge > 0.0:
                drawn = [float(name == 'bias') for name in names]
                R = np.vstack([R, np.sqrt(self.form.ridge) * np.diag(drawn)])
                moment = np.append(moment, np.zeros(len(names)))
            theta = np.asarray(np.linalg.lstsq(R, moment, rcond=1e-12)[0], dtype=np.float64)
            if (theta < lower).any():
                theta = bounded(R, moment, lower, theta)
            theta = theta / scale
            residual = self.y - X @ theta
            if weights is not None:
                break
            spread = 1.4826 * float(np.median(np.abs(residual))) / left
            if spread == 0.0:
                break
            last, w = w, np.minimum(1.0, _HUBER * spread / np.maximum(np.abs(residual), 1e-300))
            if np.max(np.abs(w - last)) < _SAME_WEIGHTS:
                break
        return LawSolution(theta, v_s, v0, alpha, w, residual, float(np.sum(w * residual**2)))

    @property
    def ones(self) -> FloatArray:
        """Return the weights of rows that have theirs in them already, (K,)."""
        return np.ones(len(self.y))

    def jacobian(self, solution: LawSolution, found: tuple[str, ...]) -> _Slopes:
        """
        Return the derivatives of the law (K, P) and what by.

        Here and below, ``found``: which of ``SIGN_WIDTH``, ``EXPONENT`` and ``POWER`` were found
        besides v_s.
        """
        last = self._slopes
        if last is None or last[0] is not solution or last[1] != found:
            last = self._slopes = (solution, found, self._slopes_at(solution, found))
        return last[2]

    def _slopes_at(self, solution: LawSolution, found: tuple[str, ...]) -> _Slopes:
        v_s, v0, alpha = solution.v_s, solution.v0, solution.alpha
        X, names = self.columns(v_s, v0, alpha), self.names(v_s)
        p = dict(zip(names, solution.theta, strict=True))
        size: FloatArray | float = p['coulomb']
        way = np.sign(self.v)
        if v_s is not None:
            amount = p['stribeck'] + p.get('stribeck_asymmetry', 0.0) * way
            slopes = fade_slopes(self.speed, v_s, alpha)
            own = ('stribeck_velocity', *([EXPONENT] if EXPONENT in found else []))
            peak = self._sign(v0)[0] * amount
            X = np.column_stack([X, *(self.made(peak * s) for s in slopes[: len(own)])])
            names = (*names, *own)
            size = size + amount * fade(self.speed, v_s, alpha)
        if POWER in found and self.power is not None:
            size_of_it = p[next(iter(NonlinearViscous.amplitudes))]
            slope = self.made(power_columns(self.v, self.power)[1])
            X = np.column_stack([X, size_of_it * slope])
            names = (*names, POWER)
        if SIGN_WIDTH in found:
            u = self.v / v0
            slope = -size * u / np.cosh(np.clip(u, -300.0, 300.0)) ** 2 / v0
            X = np.column_stack([X, self.made(slope)])
            names = (*names, SIGN_WIDTH)
        return names, X

    def covariance(
        self, solution: LawSolution, found: tuple[str, ...], without: tuple[str, ...] = ()
    ) -> dict[tuple[str, str], float]:
        """
        Return the covariance of all parameters but those in ``without``.

        That of the jackknife, and for each column of what y may be off by, as a whole, d d^T.
        """
        kept, X, norms = self._scaled(solution, found, without)
        w = solution.weights
        # The slope of Huber's psi is 0 where a residual is clipped, not w.
        clipping = np.mean(w) / np.mean(w >= 1.0)
        C = jackknife_covariance(X, solution.residual, self.groups, w)
        root = np.sqrt(w)[:, None]
        d = np.linalg.lstsq(X * root, self.unsure * root, rcond=1e-12)[0]
        C = (C * clipping**2 + d @ d.T) / np.outer(norms, norms)
        return {
            (one, two): float(C[i, j]) for i, one in enumerate(kept) for j, two in enumerate(kept)
        }

    def beside(
        self, solution: LawSolution, found: tuple[str, ...], more: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """
        Fit more columns (K, M) beside all parameters, linearised.

        Return the steps of these and the factors of the columns after them (P + M,), their
        covariance and degrees of freedom, and what is left (K,).
        """
        X = np.column_stack([self.jacobian(solution, found)[1], more])
        norms, w = column_norms(X), solution.weights
        X, root = X / norms, np.sqrt(w)
        theta = np.linalg.lstsq(X * root[:, None], solution.residual * root, rcond=1e-10)[0]
        left = solution.residual - X @ theta
        C = jackknife_covariance(X, left, self.groups, w) / np.outer(norms, norms)
        return theta / norms, C, jackknife_freedom(X, self.groups, w), left

    def freedom(
        self, solution: LawSolution, found: tuple[str, ...], without: tuple[str, ...] = ()
    ) -> dict[str, float]:
        """Return the degrees of freedom of the variance of all parameters but ``without``."""
        kept, X, _ = self._scaled(solution, found, without)
        freedom = jackknife_freedom(X, self.groups, solution.weights)
        return dict(zip(kept, freedom.tolist(), strict=True))

    def _scaled(
        self, solution: LawSolution, found: tuple[str, ...], without: tuple[str, ...]
    ) -> tuple[list[str], FloatArray, FloatArray]:
        """Return parameters, the law's derivatives by them in units of their norms, and these."""
        names, X = self.jacobian(solution, found)
        used = [k for k, name in enumerate(names) if name not in without]
        norms = column_norms(X[:, used])
        return [names[k] for k in used], X[:, used] / norms, norms

    def tells(self, solution: LawSolution, found: tuple[str, ...], name: str) -> bool:
        """Tell whether a parameter is no combination of the others."""
        kept, X, _ = self._scaled(solution, found, ())
        X, k = X * np.sqrt(solution.weights)[:, None], kept.index(name)
        return told_beside(X[:, k], np.linalg.qr(np.delete(X, k, axis=1))[0])

    def curvature(
        self, solution: LawSolution, found: tuple[str, ...], without: tuple[str, ...], name: str
    ) -> float:
        """Return the variance of a parameter where the cost is one above its least."""
        kept, X, norms = self._scaled(solution, found, without)
        X, k = X * np.sqrt(solution.weights)[:, None], kept.index(name)
        return float(np.linalg.pinv(X.T @ X)[k, k] / norms[k] ** 2)

    def free_step(self, solution: LawSolution, found: tuple[str, ...], name: str) -> float:
        """Return how far a parameter would move if no bound held it."""
        names, X = self.jacobian(solution, found)
        norms = column_norms(X)
        root = np.sqrt(solution.weights)
        step = np.linalg.lstsq(X / norms * root[:, None], solution.residual * root, rcond=1e-12)[0]
        k = names.index(name)
        return float(step[k] / norms[k])

    def stribeck_at(self, solution: LawSolution) -> float:
        """Return S of a law with a Stribeck term."""
        return float(solution.theta[self.names(solution.v_s).index('stribeck')])


def bounded(R: FloatArray, moment: FloatArray, lower: FloatArray, free: FloatArray) -> FloatArray:
    """
    Return the least-squares solution of R x = moment with x >= lower, which is 0 or -inf.

    If one element alone of the ``free`` solution is below its bound, it is 0 and the others are
    solved for beside it, unless this moves one of them below its own: the cost is convex and falls
    on the line from there to the free solution, so the bound holds it.
    """
    kept = free >= lower
    if np.count_nonzero(kept) == len(kept) - 1:
        x = np.zeros(len(kept))
        x[kept] = np.linalg.lstsq(R[:, kept], moment, rcond=1e-12)[0]
        if (x >= lower).all():
            return x
    return np.asarray(lsq_linear(R, moment, bounds=(lower, np.inf), method='bvls').x)


def spanning(columns: FloatArray) -> IndexArray:
    """
    Return which of the columns (M, F) all others are combinations of.

    By QR with pivoting (the interpolative decomposition); the rest is below 1e-8 of the largest.
    """
    R, order = qr(columns, mode='r', pivoting=True)
    size = np.abs(np.diag(R))
    return np.asarray(order[: int(np.sum(size > _LEFT * size[0]))])


def triangle(root: FloatArray, *columns: FloatArray) -> FloatArray:
    """Return R of the QR decomposition of root (M,) times columns, from blocks of their rows."""
    ends = np.cumsum([0, *(each.shape[1] for each in columns)]).tolist()
    R = np.zeros((ends[-1], ends[-1]))
    for first in range(0, len(root), ROWS_AT_ONCE):
        rows = slice(first, first + ROWS_AT_ONCE)
        # As LAPACK has it, so that nothing is copied.
        block = np.empty((len(R) + len(root[rows]), len(R)), order='F')
        block[: len(R)] = R
        for each, (begin, end) in zip(columns, itertools.pairwise(ends), strict=True):
            np.multiply(each[rows], root[rows, None], out=block[len(R) :, begin:end])
        R = qr(block, mode='raw', overwrite_a=True, check_finite=False)[1]
    return np.asarray(R)
