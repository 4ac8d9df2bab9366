# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Ask one criterion, the evidence of whole models, in the place of the rules that rank and accept.

    python -m validation.evidence_criterion --seed 1 --trials 24 --out OUT

The trials are those of ``campaign``; both decisions see the same rows and columns, and what
follows (sizes, simulation, what is left, verdict) is the same. A model is the nominal deviations
b, some causes with amplitudes a, and free curves d of every joint:

    y = Z b + sum_m X_m a_m + sum_g D_g d_g + e,   e ~ N(0, 1),
    b uniform within its tolerance,  a ~ N(0, A^2),  d_g ~ N(0, tau_g^2 K),  p(tau) ~ tau^-4,

A such that the effect has 0.3 of the joint's effort, tau by MacKay's updates beside each model,
inner parameters alike over their grid, and odds of 0.01 for each cause. What is physically
impossible is left out. A few models are extended at a time; the best is the answer, with rivals
until they have 0.95 of its place together, and the probability of a cause is that of all models
with it. The odds, the exponent and the temperature that probabilities have are those of the study
that proposed the criterion. One file per trial in OUT: a run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.diagnosis import search
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.remainder import free_curves
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.selector import Selector
from sosml_friction.diagnosis.decision.sliding import sliding
from sosml_friction.diagnosis.diagnosis import Diagnosis, diagnose
from sosml_friction.regression.curves.elsewhere import Elsewhere
from sosml_friction.regression.evidence import AT_BOUND, UNIFORM, Fit, joined, solve_bounded
from sosml_friction.regression.evidence_curves import EXPONENT, LEAST, standard
from sosml_friction.regression.whitened import WhitenedRegression
from sosml_friction.report.common.table import print_table, terminal_table
from validation.judge import judge, match
from validation.plan import make_plan
from validation.trial import Spec, build, nominal_model

KINDS = ('single', 'null', 'outside', 'double')
#: Logarithm of the odds of a cause, and by what the logarithms of evidences are divided.
ODDS, TEMPERATURE = math.log(0.01 / 0.99), 2.0
#: Standard deviation of an effect, as a share of the effort of its joint.
SHARE = 0.3
#: Models that are extended at once, by so many candidates each, up to so many causes.
BEAM, TRIED, MOST = 3, 8, 5
#: A model so much behind the best one before is extended, too [nats].
BEHIND = 5.0
#: Sizes of curves are settled at such a change of their logarithm, or after so many rounds.
SETTLED, ROUNDS = 0.05, 40
#: Probability that the answer and its rivals have together.
COVERED = 0.95
#: Ends of the bins of the reliability table.
BINS = (0.0, 0.5, 0.9, 0.99, 0.999, 1.0)
Key = tuple[str, int]


class ModelEvidence:
    """Compute the logarithm of the evidence of models, but for a constant."""

    def __init__(self, laboratory: WhitenedRegression) -> None:
        self.laboratory = laboratory
        self._hats = self._curves(sliding(laboratory))
        p = len(laboratory.nominal.bound)
        ends = p + np.cumsum([0, *(hats.shape[1] for _, hats in self._hats)])
        self._parts = [np.arange(a, b) for a, b in itertools.pairwise(ends)]
        Z = laboratory.system.Z
        fixed = np.pad(Z, ((0, 0), (0, 0), (0, ends[-1] - p)))
        for (joint, hats), part in zip(self._hats, self._parts, strict=True):
            fixed[:, joint, part] = hats
        self._fixed = fixed.reshape(-1, fixed.shape[2])
        self._y = laboratory.y.reshape(-1)
        self._G, self._r = self._fixed.T @ self._fixed, self._fixed.T @ self._y
        free = 1e-10 * np.diag(self._G)[:p] + 1e-12
        self._prior = laboratory.system.prior_weight() / UNIFORM + free
        self._effort = np.sqrt(np.nanmean(laboratory.measured() ** 2, axis=0))

    def _curves(self, far: BoolArray) -> list[tuple[int, FloatArray]]:
        """Return joint and hats of each curve, of size 1 and independent, away from reversals."""
        joints = np.flatnonzero((self.laboratory.known > 0.0) & far.any(axis=0)).tolist()
        elsewhere = Elsewhere(self.laboratory.signals)
        found = []
        for i in joints:
            for hats in free_curves(self.laboratory, elsewhere, i):
                seen = hats * far[:, i, None]
                found.append((i, seen @ standard(seen.T @ seen, int(seen.any(axis=1).sum()))))
        return found

    def _amplitudes(self, finding: Finding) -> FloatArray:
        """Return the standard deviation of amplitudes, in their units."""
        own = self.laboratory.own_columns(finding.effect, finding.joint, finding.inner)
        size = np.sqrt(np.mean(own**2, axis=0))
        with np.errstate(divide='ignore'):
            widest = np.where(size > 0.0, SHARE * self._effort[:, None] / size, np.inf).min(axis=0)
        return np.where(np.isfinite(widest), widest, 1.0)

    def of(self, model: Sequence[Finding]) -> float:
        """Return the evidence of a model, the sizes of curves at their best."""
        p, first = len(self._prior), len(self._r)
        own = np.zeros((len(self._y), 0))
        if model:
            n = self.laboratory.robot.n
            own = joined([f.columns for f in model], n).reshape(len(self._y), -1)
        cross = self._fixed.T @ own
        G = np.block([[self._G, cross], [cross.T, own.T @ own]])
        r = np.concatenate([self._r, own.T @ self._y])
        prior = np.concatenate([self._prior, *(self._amplitudes(f) ** -2 for f in model)])
        causes = np.arange(first, first + own.shape[1])
        size, alive = np.full(len(self._parts), 0.1), list(range(len(self._parts)))
        for _ in range(ROUNDS):
            parts = [self._parts[g] for g in alive]
            kept = np.concatenate([np.arange(p), causes, *parts])
            sizes = np.repeat(size[alive], [len(part) for part in parts])
            precision = np.concatenate([prior, sizes**-2.0])
            bound = np.full(len(kept), np.inf)
            bound[:p] = self.laboratory.nominal.bound
            A = G[np.ix_(kept, kept)] + np.diag(precision)
            x = solve_bounded(A, r[kept], -bound, bound)
            free = np.flatnonzero(np.abs(x) < AT_BOUND * bound)
            scale = 1.0 / np.sqrt(np.diag(A)[free])
            L = np.linalg.cholesky(A[np.ix_(free, free)] * scale * scale[:, None])
            variance = np.zeros(len(kept))
            variance[free] = np.sum(np.linalg.inv(L) ** 2, axis=0) * scale**2
            evidence = -0.5 * (x @ A @ x - 2.0 * r[kept] @ x)
            evidence += 0.5 * np.sum(np.log(precision[free])) + np.sum(np.log(scale))
            evidence -= np.sum(np.log(np.diag(L)))
            # tau^-4 from the least on, of the integral 1, times the width of its peak of about 1.
            evidence += float(
                np.sum(np.log(3.0 / math.sqrt(2.0 * math.pi) * (LEAST / size[alive]) ** 3))
            )
            before, at = size.copy(), p + len(causes)
            for g, part in zip(alive, parts, strict=True):
                mine = slice(at, at + len(part))
                told = len(part) - np.sum(variance[mine]) / size[g] ** 2
                size[g] = np.sqrt(x[mine] @ x[mine] / (told + EXPONENT))
                at += len(part)
            seen = [g for g in alive if size[g] >= LEAST]
            if seen == alive and np.all(np.abs(np.log(size[seen] / before[seen])) < SETTLED):
                break
            alive = seen
        return float(evidence)


@dataclass(frozen=True)
class Weighed:
    """Hold a model with the logarithm of its probability, but for a constant."""

    model: tuple[Finding, ...]
    weight: float

    @property
    def keys(self) -> frozenset[Key]:
        """Return which causes it has."""
        return frozenset(finding.key for finding in self.model)


class EvidenceSelector(Selector):
    """Select causes by the evidence of models; ``told`` has the probability of each."""

    told: dict[Key, float]

    def run(self) -> Selection:
        """Return the most likely model, without causes that turn out to be impossible."""
        fit = Fit.make(self.laboratory.system, self.laboratory.y)
        self.scorer.refused.clear()
        while True:
            found = self.settled(self._most_likely(Selection(fit.baseline, fit)))
            if self._without_impossible(found) is found:
                return found

    def _most_likely(self, nothing: Selection) -> Selection:
        evidence = ModelEvidence(self.laboratory)
        models = {frozenset(): Weighed((), evidence.of(()))}
        frontier = list(models.values())
        while frontier:
            best, longer = max(own.weight for own in models.values()), []
            for own in frontier:
                for finding in self._extensions(nothing, own):
                    model = (*own.model, finding)
                    weighed = Weighed(model, evidence.of(model) + sum(map(self._prior, model)))
                    if weighed.keys not in models:
                        models[weighed.keys] = weighed
                        longer.append(weighed)
            longer.sort(key=lambda own: -own.weight)
            if not longer or longer[0].weight < best:
                break
            frontier = [
                own
                for own in longer[:BEAM]
                if own.weight > best - BEHIND and len(own.model) < MOST
            ]
        return self._answered(nothing, list(models.values()))

    def _extensions(self, nothing: Selection, own: Weighed) -> list[Finding]:
        """Return candidates that may join a model, refined beside it."""
        fit = nothing.refitted(self.laboratory, own.model)
        columns = [its.beside(fit.system) for its in self.laboratory.columns]
        result: list[Finding] = []
        for finding in self.scorer.ranked(fit.fit, columns):
            if finding.delta_bic < 0.0 or len(result) == TRIED:
                break
            if finding.key not in own.keys:
                refined = self.scorer.refine(fit.fit, finding)
                if not refined.objection and refined.delta_bic > 0.0:
                    result.append(refined)
        return result

    def _prior(self, finding: Finding) -> float:
        """Return the logarithm of the odds of a cause, times the share of its grid that is it."""
        grid = next(len(c.grid) for c in self.laboratory.candidates if c.key == finding.key)
        gains = finding.score.gains
        if grid == 1:
            return ODDS
        share = np.mean(np.exp(0.5 * (gains - gains.max()))) if len(gains) == grid else 1.0 / grid
        return ODDS + float(np.log(share))

    def _answered(self, nothing: Selection, models: Sequence[Weighed]) -> Selection:
        weights = np.array([own.weight for own in models])
        p = np.exp((weights - weights.max()) / TEMPERATURE)
        p /= p.sum()
        top = models[int(np.argmax(p))]
        self.told, chosen = {}, []
        for finding in top.model:
            rest = top.keys - {finding.key}
            swaps = [
                (share, next(f for f in own.model if f.key not in rest))
                for share, own in zip(p, models, strict=True)
                if rest < own.keys and len(own.keys) == len(top.keys) and own is not top
            ]
            whole = p.max() + sum(share for share, _ in swaps)
            rivals, covered = [], p.max() / whole
            for share, other in sorted(swaps, key=lambda own: -own[0]):
                if covered >= COVERED:
                    break
                rivals.append(other)
                covered += share / whole
            chosen.append(replace(finding, rivals=tuple(rivals)))
            holds = [finding.key in own.keys for own in models]
            self.told[finding.key] = float(p[holds].sum())
        chosen.sort(key=lambda finding: -finding.score.gain)
        return nothing.refitted(self.laboratory, chosen)


def asked(spec: Spec) -> dict[str, Any]:
    """Return what both decisions answer to a trial, and what that is worth."""
    trial = build(spec)
    made: list[EvidenceSelector] = []

    def selector(*given: Any) -> EvidenceSelector:
        made.append(EvidenceSelector(*given))
        return made[-1]

    def answer() -> tuple[str, Diagnosis]:
        found = diagnose([trial.log], nominal_model(), trial.holdout, without=spec.without)
        causes = [
            {'effect': c.effect, 'joint': c.joint, 'rivals': list(c.rivals)} for c in found.causes
        ]
        told = judge(spec.kind, trial.truths, {'verdict': found.verdict, 'causes': causes})
        return told.outcome, found

    rules, _ = answer()
    with patch.object(search, 'Selector', selector):
        outcome, found = answer()
    names = found.names
    stated = []
    for (effect, joint), p in made[-1].told.items():
        one = {'effect': effect, 'rivals': []}
        where = (names[joint], '*')
        right = any(match({**one, 'joint': place}, t) for place in where for t in trial.truths)
        stated.append((p, right))
    level = spec.name.rsplit('-', 1)[0]
    return {'kind': level, 'rules': rules, 'criterion': outcome, 'stated': stated}


def main() -> int:
    """Ask the trials that are not there yet, and print both tables."""
    parser = argparse.ArgumentParser(
        prog='python -m validation.evidence_criterion', description=__doc__
    )
    parser.add_argument('--seed', type=int, required=True, help='of all that is drawn')
    parser.add_argument(
        '--trials', type=int, default=24, help='single effects of SNR 0.6 and more'
    )
    parser.add_argument('--out', type=Path, default=Path('evidence_criterion'))
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for spec in make_plan(given.seed, given.trials):
        if spec.kind not in KINDS:
            continue
        file = given.out / f'{spec.name}.json'
        if not file.is_file():
            file.write_text(json.dumps(asked(spec)))
            print(spec.name, file.read_text(), flush=True)
        rows.append(json.loads(file.read_text()))
    table = []
    for kind in dict.fromkeys(row['kind'] for row in rows):
        own = [row for row in rows if row['kind'] == kind]
        counts = (Counter(row[by] for row in own) for by in ('rules', 'criterion'))
        said = [', '.join(f'{n} {name}' for name, n in sorted(c.items())) for c in counts]
        table.append((kind, f'{len(own)}', *said))
    print_table(terminal_table({'trials': '', 'n': 'n', 'rules': '', 'criterion': ''}, table))
    stated = [(p, right) for row in rows for p, right in row['stated']]
    bins = []
    for low, high in itertools.pairwise(BINS):
        own = [right for p, right in stated if low < p <= high]
        share = f'{np.mean(own):.2f}' if own else '-'
        bins.append((f'{low:g} to {high:g}', f'{len(own)}', share))
    print_table(terminal_table({'probability stated': '', 'causes': 'n', 'true': 'n'}, bins))
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
