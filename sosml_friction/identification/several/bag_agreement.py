# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Do several recordings obey one law, and if not, which differs in what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.jackknife import t_95
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_problem import POWER
from sosml_friction.identification.law.law_stack import OWN, LawStack
from sosml_friction.identification.parameter_interval import LAW_PARAMETERS
from sosml_friction.model.laws import law_definition, unit_of
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.kinds.fading_term import fade, fade_slopes
from sosml_friction.model.terms.nonlinear_viscous import power_columns
from sosml_friction.regression.column_norms import column_norms, told_beside

#: Significance level: the share of agreeing bags that may be reported to differ.
_ALARM = 0.01
_GRID = 30
_V_S = 'stribeck_velocity'
#: Steps to the v_s of a bag that differs, and the factor that each may change it by: 2^5 is more
#: than v_s and the speeds of a recording span. Chosen, no measurement.
_STEPS, _STEP = 5, 2.0


@dataclass(frozen=True)
class Disagreement:
    """
    Say in what one recording differs from all others beyond the errors of both.

    ``difference`` +- ``std_error``: what ``bag`` says of ``parameter`` minus what the others say,
    in ``unit``; ``sigmas`` is their ratio, positive. ``sentence`` says it in words, without stop.
    With two recordings either could be the one that differs.
    """

    parameter: str
    bag: str
    difference: float
    std_error: float
    sigmas: float
    unit: str
    sentence: str


@dataclass(frozen=True)
class Agreement:
    """
    Hold how far bags agree.

    ``chi_square`` of ``degrees`` of freedom: how far C, B, bias (and S) of single bags are from
    each other, in their errors; ``p_value``: how often that would be as large by chance. ``own``:
    what each bag says of a parameter, by name and label: of the bias, and of those of Coulomb and
    viscous friction in which bags differ, the rest of the law common.
    """

    chi_square: float
    degrees: int
    p_value: float
    disagreements: tuple[Disagreement, ...]
    own: dict[str, dict[str, Parameter]]

    def odds(self) -> dict[str, float]:
        """Return chi-square, its degrees of freedom and its p-value by name."""
        return {'chi_square': self.chi_square, 'degrees': self.degrees, 'p_value': self.p_value}

    def with_variance(self, variance: Mapping[str, float]) -> Agreement:
        """Return the same with a variance added to what bags say, which all of them share."""
        own = {
            name: {label: p.with_variance(variance.get(name, 0.0)) for label, p in bags.items()}
            for name, bags in self.own.items()
        }
        return replace(self, own=own)

    @property
    def differing(self) -> tuple[str, ...]:
        """Return the parameters in which bags differ, in the order of the law."""
        found = {entry.parameter for entry in self.disagreements}
        return tuple(name for name in LAW_PARAMETERS if name in found)


def find_agreement(
    stack: LawStack, labels: Sequence[str], effort_unit: str, fits: Sequence[LawFit]
) -> Agreement:
    """
    Hold the bags of a stack against one law for all.

    A deviation is one parameter in one bag. The one that explains most is accepted if it is beyond
    its error at a level that allows for all that were tried (1 % of false alarms in all). The next
    one is then sought beside it, until none is accepted. Errors are by clusters.

    :param labels: of the bags, in the order of the stack.
    :param fits: laws of all bags and of single ones. Width of the sign and exponent are taken from
        one of them: the one that explains most when each bag has all other parameters of its own.
        Where bags differ, a law fitted to all would take their difference for a bend.
    """
    return _Comparison(stack, labels, effort_unit, fits).result()


def _shape(fit: LawFit) -> tuple[float, float, float | None]:
    """
    Return what a law is not linear in beside v_s.

    v0 of the sign, the exponent, and the power of speed of a law that has no Stribeck term. The
    exponent is the one drawn: a bag alone may not know any.
    """
    exponent = fit.drawn.get('exponent', law_definition(fit.law).fixed.get('exponent', 1.0))
    return fit.smoothing_velocity, exponent, fit.drawn.get(POWER)


class _Comparison:
    """The linearised regression of all bags, to which deviations are added."""

    def __init__(
        self, stack: LawStack, labels: Sequence[str], unit: str, fits: Sequence[LawFit]
    ) -> None:
        rows, keep = stack.rows, stack.rows.known
        self.keep, self.rows, self.unit = keep, rows, unit
        self.y, self.bag = rows.y[keep], stack.bag[keep]
        self.unsure = None if rows.unsure is None else rows.unsure[keep]
        self.groups = np.unique(rows.clusters[keep], return_inverse=True)[1]
        self.labels = labels
        self.present = np.unique(self.bag)
        self.v = np.nan_to_num(rows.v)
        self.faded = any('stribeck' in fit.law for fit in fits)
        self.bent = self.faded and any('exponent' in fit.parameters for fit in fits)
        asymmetric = any('viscous_asymmetry' in fit.parameters for fit in fits)
        found = [self._nearest(*shape, asymmetric) for shape in dict.fromkeys(map(_shape, fits))]
        best = min(found, key=lambda one: one[0])
        _, self.sign, self.power, v_s, self.columns, self.bend = best
        # A power of speed stands in place of a Stribeck term, and all bags share it.
        self.faded = self.faded and not self.bend
        self.bent = self.bent and self.faded
        # By bag; one without rows has a v_s as well, of which nothing is asked.
        self.common_v_s, self.v_s = v_s, np.full(len(labels), v_s)
        if self.faded:
            way = ['stribeck_asymmetry'] if asymmetric else []
            self.columns |= dict.fromkeys(['stribeck', *way, 'stribeck_velocity'], np.empty(0))
        self._linearise(())

    def _nearest(
        self, v0: float, power: float, bend: float | None, asymmetric: bool
    ) -> tuple[float, FloatArray, float, float, dict[str, FloatArray], list[FloatArray]]:
        """
        Return the least cost, sign, exponent, v_s and columns of a law of this shape.

        The last are those of a power of speed, and of its logarithm, none without.
        """
        sign = smooth_sign(self.v, v0)
        shapes = {'coulomb': sign, 'viscous': self.v, 'bias': np.ones_like(self.v)}
        if asymmetric:
            shapes['viscous_asymmetry'] = np.abs(self.v)
        columns = {name: self._lag(column) for name, column in shapes.items()}
        shared = list(columns.values())
        if bend is not None:
            both = [self._lag(column) for column in power_columns(self.v, bend)]
            return self._cost([*shared, both[0]]), sign, power, np.nan, columns, both
        if not self.faded:
            return self._cost(shared), sign, power, np.nan, columns, []

        def cost(v_s: float) -> float:
            return self._cost([*shared, self._lag(sign * fade(self.v, v_s, power))])

        speeds = np.abs(self.rows.mean_v[self.keep])
        slowest = max(float(np.quantile(speeds, 0.02)), 1e-3 * float(speeds.max()))
        grid = np.geomspace(slowest / 3.0, speeds.max(), _GRID)
        costs = [cost(v_s) for v_s in grid]
        best = int(np.argmin(costs))
        ends = np.log(grid[[max(best - 1, 0), min(best + 1, _GRID - 1)]])
        found = minimize_scalar(lambda u: cost(float(np.exp(u))), bounds=ends, method='bounded')
        if found.fun < costs[best]:
            return float(found.fun), sign, power, float(np.exp(found.x)), columns, []
        return costs[best], sign, power, float(grid[best]), columns, []

    def _cost(self, columns: Sequence[FloatArray]) -> float:
        """Return the sum of squares that is left where each bag has sizes of its own."""
        X, left = np.column_stack(columns), 0.0
        for bag in self.present:
            own = self.bag == bag
            left += float(np.sum(self._solve(X[own], self.y[own])[1] ** 2))
        return left

    def _lag(self, column: FloatArray) -> FloatArray:
        return self.rows.lag(column)[self.keep]

    def _linearise(self, accepted: Sequence[tuple[str, int]]) -> None:
        """
        Take the columns of the Stribeck term at each bag's v_s, and at its S.

        S is that of the fit of all bags with the accepted deviations, so that a bag whose S is
        another has the slope of its own knee.
        """
        self.base = np.column_stack([*(c for c in self.columns.values() if len(c)), *self.bend])
        if not self.faded:
            return
        shapes: dict[float, tuple[FloatArray, ...]] = {}
        for v_s in np.unique(self.v_s).tolist():
            faded = fade(self.v, v_s, self.power)
            slope, bend = fade_slopes(self.v, v_s, self.power)
            made = [self.sign * faded, faded, self.sign * slope, self.sign * bend]
            shapes[v_s] = tuple(map(self._lag, made))
        own = [shapes[v_s] for v_s in self.v_s.tolist()]
        peak, even, slope, bend = (
            np.array(np.choose(self.bag, [one[k] for one in own])) for k in range(4)
        )
        self.columns['stribeck'] = peak
        if 'stribeck_asymmetry' in self.columns:
            self.columns['stribeck_asymmetry'] = even
        linear = [name for name in self.columns if name != 'stribeck_velocity']
        beside = [one for one in accepted if one[0] in linear]
        X = [self.columns[name] for name in linear] + [self._deviation(one) for one in beside]
        theta = self._solve(np.column_stack(X))[0]
        S = np.full(len(self.v_s), theta[linear.index('stribeck')])
        for (name, bag), size in zip(beside, theta[len(linear) :], strict=True):
            S[bag] += size if name == 'stribeck' else 0.0
        self.columns['stribeck_velocity'] = S[self.bag] * slope
        bends = [S[self.bag] * bend] if self.bent else []
        self.base = np.column_stack([*self.columns.values(), *bends])

    def _solve(self, X: FloatArray, y: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        norms = column_norms(X)
        y = self.y if y is None else y
        theta = np.linalg.lstsq(X / norms, y, rcond=1e-10)[0]
        return theta / norms, y - (X / norms) @ theta

    def _errors(self, X: FloatArray, residual: FloatArray) -> FloatArray:
        """Return the standard errors by clusters of a fit with columns X, (P,)."""
        return np.array(np.sqrt(np.diag(self._covariance(X, residual))))

    def _covariance(self, X: FloatArray, residual: FloatArray) -> FloatArray:
        """
        Return the sandwich by clusters of a fit with columns X, (P, P).

        With what the bodies may be off by, which all bags share and see in other postures.
        """
        norms = column_norms(X)
        X = X / norms
        count = int(self.groups.max()) + 1
        scores = np.zeros((count, X.shape[1]))
        np.add.at(scores, self.groups, X * residual[:, None])
        bread = np.linalg.pinv(X.T @ X, rcond=1e-12, hermitian=True)
        factor = count / max(count - X.shape[1], 1)
        covariance = factor * bread @ (scores.T @ scores) @ bread
        if self.unsure is not None:
            moved = bread @ (X.T @ self.unsure)
            covariance += moved @ moved.T
        return np.array(covariance / np.outer(norms, norms))

    def _freedom(self, bag: int) -> int:
        own = len(np.unique(self.groups[self.bag == bag]))
        return max(own - len(self.columns), 1)

    def result(self) -> Agreement:
        chi_square, degrees, p_value = self._wald()
        found = self._disagreements()
        own = {'bias', *(entry.parameter for entry in found if entry.parameter in OWN)}
        return Agreement(chi_square, degrees, p_value, found, self._own(sorted(own), found))

    def _wald(self) -> tuple[float, int, float]:
        """
        Return chi-square, its degrees of freedom and its p-value (Wald, errors by clusters).

        Each bag has C, B, bias and S of its own, at one v_s, as far as it can tell them; what is
        tested is whether they are the same. The p-value is Hotelling's: the covariance is itself
        estimated, from as many clusters as there are.
        """
        names = [name for name in self.columns if name != 'stribeck_velocity']
        X = self.base
        for b in self.present[1:]:
            for name in names:
                column = self._deviation((name, int(b)))
                basis = np.linalg.qr(X / column_norms(X))[0]
                if told_beside(column, basis):
                    X = np.column_stack([X, column])
        degrees = X.shape[1] - self.base.shape[1]
        left = int(self.groups.max()) + 1 - X.shape[1]
        if degrees == 0 or left <= degrees:
            return 0.0, 0, 1.0
        theta, residual = self._solve(X)
        covariance = self._covariance(X, residual)[-degrees:, -degrees:]
        scale = np.sqrt(np.diag(covariance))
        shift = theta[-degrees:] / np.where(scale > 0.0, scale, 1.0)
        inner = covariance / np.outer(scale, scale) if (scale > 0.0).all() else np.eye(degrees)
        chi_square = float(shift @ np.linalg.pinv(inner, rcond=1e-10, hermitian=True) @ shift)
        freedom = left - degrees + 1
        hotelling = chi_square * freedom / (left * degrees)
        return chi_square, degrees, float(f_distribution.sf(hotelling, degrees, freedom))

    def _disagreements(self) -> tuple[Disagreement, ...]:
        if len(self.present) < 2:
            return ()
        candidates = [
            (name, int(b))
            for name in self.columns
            # Of two bags the difference is one, whichever it is told of.
            for b in (self.present if len(self.present) > 2 else self.present[1:])
        ]
        level = 1.0 - 0.5 * _ALARM / len(candidates)
        accepted: list[tuple[str, int]] = []
        while len(accepted) < len(candidates):
            best = self._next(candidates, accepted, level)
            if best is None:
                break
            accepted.append(best)
            self._settle(accepted)
        while accepted:
            values, errors = self._sizes(accepted)
            limits = np.array([self._limit(one, level) for one in accepted])
            shown = np.abs(values) / np.maximum(errors * limits, np.finfo(float).tiny)
            if shown.min() > 1.0:
                return tuple(map(self._told, accepted, values.tolist(), errors.tolist()))
            # What was taken for it is told by those that came later.
            del accepted[int(np.argmin(shown))]
            self._settle(accepted)
        return ()

    def _limit(self, candidate: tuple[str, int], level: float) -> float:
        return float(t_distribution.ppf(level, self._freedom(candidate[1])))

    def _next(
        self, candidates: Sequence[tuple[str, int]], accepted: Sequence[tuple[str, int]],
        level: float,
    ) -> tuple[str, int] | None:  # fmt: skip
        """Return the deviation that explains most beside others, None if none is shown."""
        X = self._with(accepted)
        basis = np.linalg.qr(X / column_norms(X))[0]
        residual = self.y - basis @ (basis.T @ self.y)
        best, best_gain = None, 0.0
        for candidate in candidates:
            column = self._deviation(candidate)
            if candidate in accepted or not told_beside(column, basis):
                continue
            rest = column - basis @ (basis.T @ column)
            size = float(rest @ rest)
            gain = float(rest @ residual) ** 2 / size
            if gain <= best_gain:
                continue
            value = float(rest @ residual) / size
            error = float(self._errors(rest[:, None], residual - value * rest)[0])
            if abs(value) > self._limit(candidate, level) * error:
                best, best_gain = candidate, gain
        return best

    def _settle(self, accepted: Sequence[tuple[str, int]]) -> None:
        """Take the columns where the accepted deviations are: at S and v_s of their bags."""
        if not self.faded:
            return
        moving = [(k, bag) for k, (name, bag) in enumerate(accepted) if name == _V_S]
        self.v_s[:] = self.common_v_s
        self._linearise(accepted)
        for _ in range(_STEPS if moving else 0):
            theta = self._solve(self._with(accepted))[0]
            step = np.full(len(self.v_s), theta[list(self.columns).index(_V_S)])
            for k, bag in moving:
                step[bag] += theta[self.base.shape[1] + k]
            self.v_s = np.clip(self.v_s + step, self.v_s / _STEP, self.v_s * _STEP)
            self._linearise(accepted)

    def _with(self, accepted: Sequence[tuple[str, int]]) -> FloatArray:
        return np.column_stack([self.base, *(self._deviation(one) for one in accepted)])

    def _sizes(self, accepted: Sequence[tuple[str, int]]) -> tuple[FloatArray, FloatArray]:
        """Return how large accepted deviations are, and their standard errors."""
        X = self._with(accepted)
        theta, residual = self._solve(X)
        values = theta[-len(accepted) :].copy()
        moved = [bag for name, bag in accepted if name == _V_S]
        others = np.setdiff1d(self.present, moved)
        for k, (name, bag) in enumerate(accepted):
            if name == _V_S:
                values[k] += self.v_s[bag] - self.v_s[others[0]]
        return values, self._errors(X, residual)[-len(accepted) :]

    def _deviation(self, candidate: tuple[str, int]) -> FloatArray:
        name, bag = candidate
        return self.columns[name] * (self.bag == bag)

    def _told(self, candidate: tuple[str, int], value: float, error: float) -> Disagreement:
        name, bag = candidate
        unit = unit_of(name, self.unit)
        sigmas = abs(value) / error if error > 0.0 else np.inf
        label = self.labels[bag]
        others = 'the others say'
        if len(self.present) == 2:
            others = f'{self.labels[int(self.present[0])]} says'
        words = name.replace('_', ' ')
        sentence = (
            f'{label} differs in {words}: {abs(value):.2g} {unit} '
            f'{"more" if value > 0.0 else "less"} than {others}, {sigmas:.1f} standard errors'
        )
        return Disagreement(name, label, float(value), float(error), float(sigmas), unit, sentence)

    def _own(
        self, names: Sequence[str], found: Sequence[Disagreement]
    ) -> dict[str, dict[str, Parameter]]:
        own = [self._deviation((name, int(b))) for name in names for b in self.present]
        shared = [self.columns[name] for name in self.columns if name not in names]
        beside = [
            self._deviation((entry.parameter, self.labels.index(entry.bag)))
            for entry in found
            if entry.parameter not in names
        ]
        X = np.column_stack([*own, *shared, *beside, *self.bend])
        theta, residual = self._solve(X)
        errors = iter(zip(theta, self._errors(X, residual), strict=True))
        result: dict[str, dict[str, Parameter]] = {}
        for name in names:
            for bag in self.present.tolist():
                value, error = map(float, next(errors))
                result.setdefault(name, {})[self.labels[bag]] = Parameter.estimated(
                    value, unit_of(name, self.unit), error, t_95(self._freedom(bag))
                )
        return result
