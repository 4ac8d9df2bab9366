# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Do several recordings obey one law, and if not, which differs in what."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.jackknife import t_95
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_stack import OWN, LawStack
from sosml_friction.identification.parameter_interval import LAW_PARAMETERS
from sosml_friction.model.laws import law_definition, unit_of
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.kinds.fading_term import fade, fade_slopes
from sosml_friction.regression.column_norms import column_norms, told_beside

#: Significance level: the share of agreeing bags that may be reported to differ.
_ALARM = 0.01
_GRID = 30


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

    @property
    def differing(self) -> tuple[str, ...]:
        """Return the parameters in which bags differ, in the order of the law."""
        found = {entry.parameter for entry in self.disagreements}
        return tuple(name for name in LAW_PARAMETERS if name in found)


def find_agreement(
    stack: LawStack, labels: Sequence[str], effort_unit: str, fit: LawFit
) -> Agreement:
    """
    Hold the bags of a stack against one law for all.

    The deviation of one parameter in one bag that explains most is accepted if it is beyond its
    error, with room for the number of those that were tried (1 % of false alarms in all); then
    the next beside it, until none is. Errors are by clusters.

    :param labels: of the bags, in the order of the stack.
    :param fit: the law fitted to all, for its terms and the width of its sign.
    """
    return _Comparison(stack, labels, effort_unit, fit).result()


class _Comparison:
    """The linearised regression of all bags, to which deviations are added."""

    def __init__(self, stack: LawStack, labels: Sequence[str], unit: str, fit: LawFit) -> None:
        rows = stack.rows
        keep = rows.keep & np.isfinite(rows.y) & np.isfinite(rows.mean_v)
        self.keep, self.rows, self.unit = keep, rows, unit
        self.y, self.bag = rows.y[keep], stack.bag[keep]
        self.unsure = None if rows.unsure is None else rows.unsure[keep]
        self.groups = np.unique(rows.clusters[keep], return_inverse=True)[1]
        self.labels = labels
        self.present = np.unique(self.bag)
        self.v = np.nan_to_num(rows.v)
        self.sign = smooth_sign(self.v, fit.smoothing_velocity)
        found = fit.parameters.get('exponent')
        fixed = law_definition(fit.law).fixed.get('exponent', 1.0)
        self.power = fixed if found is None else found.value
        self.columns = {
            name: rows.lag(column)[keep]
            for name, column in (
                ('coulomb', self.sign),
                ('viscous', self.v),
                ('bias', np.ones_like(self.v)),
            )
        }
        if 'viscous_asymmetry' in fit.parameters:
            self.columns['viscous_asymmetry'] = rows.lag(np.abs(self.v))[keep]
        beside = []
        if 'stribeck' in fit.law:
            v_s = self._search()
            faded = fade(self.v, v_s, self.power)
            self.columns['stribeck'] = rows.lag(self.sign * faded)[keep]
            terms = list(self.columns)
            if 'stribeck_asymmetry' in fit.parameters:
                self.columns['stribeck_asymmetry'] = rows.lag(faded)[keep]
            theta = self._solve(np.column_stack(list(self.columns.values())))[0]
            S = float(theta[terms.index('stribeck')])
            slope, bend = fade_slopes(self.v, v_s, self.power)
            self.columns['stribeck_velocity'] = rows.lag(S * self.sign * slope)[keep]
            if found is not None:
                beside.append(rows.lag(S * self.sign * bend)[keep])
        self.base = np.column_stack([*self.columns.values(), *beside])

    def _search(self) -> float:
        """Return the v_s of the least cost, without bounds on anything else."""
        speeds = np.abs(self.rows.mean_v[self.keep])
        slowest = max(float(np.quantile(speeds, 0.02)), 1e-3 * float(speeds.max()))
        grid = np.geomspace(slowest / 3.0, speeds.max(), _GRID)

        def cost(v_s: float) -> float:
            peak = self.rows.lag(self.sign * fade(self.v, v_s, self.power))[self.keep]
            rest = self._solve(np.column_stack([*self.columns.values(), peak]))[1]
            return float(rest @ rest)

        costs = [cost(v_s) for v_s in grid]
        best = int(np.argmin(costs))
        ends = np.log(grid[[max(best - 1, 0), min(best + 1, _GRID - 1)]])
        found = minimize_scalar(lambda u: cost(float(np.exp(u))), bounds=ends, method='bounded')
        return float(np.exp(found.x)) if found.fun < costs[best] else float(grid[best])

    def _solve(self, X: FloatArray) -> tuple[FloatArray, FloatArray]:
        norms = column_norms(X)
        theta = np.linalg.lstsq(X / norms, self.y, rcond=1e-10)[0]
        return theta / norms, self.y - (X / norms) @ theta

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
        return Agreement(chi_square, degrees, p_value, found, self._own(sorted(own)))

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
            X = np.column_stack([self.base, *(self._deviation(c) for c in accepted)])
            basis = np.linalg.qr(X / column_norms(X))[0]
            residual = self.y - basis @ (basis.T @ self.y)
            best, best_gain = None, 0.0
            for candidate in candidates:
                column = self._deviation(candidate)
                rest = column - basis @ (basis.T @ column)
                if candidate in accepted or not told_beside(column, basis):
                    continue
                size = float(rest @ rest)
                gain = float(rest @ residual) ** 2 / size
                if gain <= best_gain:
                    continue
                value = float(rest @ residual) / size
                error = float(self._errors(rest[:, None], residual - value * rest)[0])
                if abs(value) > float(t_distribution.ppf(level, self._freedom(candidate[1]))) * (
                    error
                ):
                    best, best_gain = candidate, gain
            if best is None:
                break
            accepted.append(best)
        if not accepted:
            return ()
        X = np.column_stack([self.base, *(self._deviation(c) for c in accepted)])
        theta, residual = self._solve(X)
        errors = self._errors(X, residual)
        found = zip(accepted, theta[-len(accepted) :], errors[-len(accepted) :], strict=True)
        return tuple(self._told(*entry) for entry in found)

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

    def _own(self, names: Sequence[str]) -> dict[str, dict[str, Parameter]]:
        own = [self._deviation((name, int(b))) for name in names for b in self.present]
        shared = [self.columns[name] for name in self.columns if name not in names]
        X = np.column_stack([*own, *shared])
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
