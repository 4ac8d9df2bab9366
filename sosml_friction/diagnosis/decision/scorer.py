# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The evidence for every candidate, at the point of its grid that explains most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import f as f_distribution

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.effect import Effect, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.regression.evidence import CandidateColumns, Fit, Score
from sosml_friction.regression.laboratory import Laboratory

FloatArray = NDArray[np.float64]

#: First step of the refinement: of a frequency in units of 2.5 cycles over the joint's range, of
#: any other parameter as a logarithm. About the distance of two grid points; no measurement.
_CYCLES, _FREQUENCY_STEP, _LOG_STEP = 2.5, 0.4, 0.3


class Scorer:
    """
    Score candidates beside a fit.

    ``refused``: effect and joint of candidates that are impossible whatever their amplitude, and
    why.
    """

    def __init__(self, laboratory: Laboratory) -> None:
        self.laboratory = laboratory
        self.refused: dict[tuple[str, int], str] = {}
        self._trials = sum(len(c.grid) for c in laboratory.candidates)

    def ranked(self, fit: Fit, columns: Sequence[CandidateColumns]) -> list[Finding]:
        """Return every candidate at the best point of its grid, best first."""
        found = []
        for candidate, its in zip(self.laboratory.candidates, columns, strict=True):
            s = fit.score(its)
            inner, grid = candidate.grid[s.best], its.C.shape[2]
            found.append(self._finding(candidate.effect, candidate.joint, inner, s, its, grid))
        return sorted(found, key=lambda finding: -finding.delta_bic)

    def _finding(
        self,
        effect: Effect,
        joint: int,
        inner: Inner,
        s: Score,
        columns: CandidateColumns,
        grid: int,
    ) -> Finding:
        """
        Return a candidate with BIC and F test.

        Of N rows and k parameters, the gain G has delta BIC = G - k ln N - 2 ln(grid points), and
        F = (G / k) / ((N - G) / N) with k and N degrees of freedom.
        """
        rows = float(self.laboratory.known[columns.rows].sum())
        k = max(int((s.amplitude != 0.0).sum()) + len(effect.refined), 1)
        bic = s.gain - k * np.log(rows) - 2.0 * np.log(grid)
        residual = max(rows - s.gain, 1.0)
        statistic = max(s.gain, 0.0) / k / (residual / rows)
        p = float(f_distribution.sf(statistic, k, rows)) * self._trials
        fit = Fitted(self.laboratory.signals[0], joint, inner, s.amplitude, s.error)
        return Finding(
            effect, joint, inner, s, columns, float(bic), min(p, 1.0),
            objection=effect.implausible(fit) or self.refused.get((effect.identifier, joint), ''),
            reduced=effect.reduces_to(fit),
        )  # fmt: skip

    def refine(self, fit: Fit, finding: Finding) -> Finding:
        """Return a finding with its continuous inner parameters where the cost is least."""
        effect, joint = finding.effect, finding.joint
        known = effect.inner_bounds(self.laboratory.signals[0], joint)
        bounds = {name: known[name] for name in effect.refined if name in known}
        if not bounds:
            columns = self._columns(fit, finding, finding.inner)
            return replace(finding, columns=columns)
        inner = self._least_cost(fit, finding, bounds)
        columns = self._columns(fit, finding, inner)
        s = fit.score(columns)
        if s.gain < finding.score.gain:
            inner = dict(finding.inner)
            columns = self._columns(fit, finding, inner)
            s = fit.score(columns)
        grid = next(len(c.grid) for c in self.laboratory.candidates if c.key == finding.key)
        return self._finding(effect, joint, inner, s, columns, grid)

    def _columns(self, fit: Fit, finding: Finding, inner: Inner) -> CandidateColumns:
        single = self.laboratory.single(finding.effect, finding.joint, inner)
        return single.beside(fit.system)

    def _least_cost(
        self, fit: Fit, finding: Finding, bounds: dict[str, tuple[float, float]]
    ) -> dict[str, float]:
        """Return the inner parameters of the largest gain within their bounds, by Nelder-Mead."""
        names = list(bounds)
        start = np.array([float(finding.inner[name]) for name in names])
        low, high = np.array(list(bounds.values())).T
        periodic = names == ['frequency']
        span = float(self.laboratory.signals[0].scales.span[finding.joint])
        seen: dict[tuple[float, ...], float] = {}

        def inner_of(u: FloatArray) -> dict[str, float]:
            # A frequency is looked for in cycles over the range, the others in relative size.
            x = start + u * _CYCLES / span if periodic else start * np.exp(u)
            x = np.clip(x, low, high)
            return {**finding.inner, **dict(zip(names, x.tolist(), strict=True))}

        def cost(u: FloatArray) -> float:
            inner = inner_of(u)
            key = tuple(inner[name] for name in names)
            if key not in seen:
                seen[key] = -fit.score(self._columns(fit, finding, inner)).gain
            return seen[key]

        size = _FREQUENCY_STEP if periodic else _LOG_STEP
        origin = np.zeros(len(names))
        simplex = np.vstack([origin, size * np.eye(len(names))])
        found = minimize(
            cost, origin, method='Nelder-Mead',
            options={'initial_simplex': simplex, 'maxfev': 25 * len(names), 'xatol': 0.01,
                     'fatol': 0.5},
        )  # fmt: skip
        return inner_of(found.x)
