# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Forward selection of causes with a floor from simulated recordings without any."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import f as f_distribution

from sosml_friction.diagnosis.decision.adequacy import Leftover, leftovers
from sosml_friction.diagnosis.decision.cause import joint_name
from sosml_friction.diagnosis.decision.null_recordings import null_recordings
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.evidence import (
    Baseline,
    CandidateColumns,
    Score,
    System,
    Target,
    fit_baseline,
    score,
)
from sosml_friction.regression.laboratory import Laboratory

FloatArray = NDArray[np.float64]

#: So many of the best candidates have their inner parameters refined before the best is chosen.
_REFINED = 4
#: Implausible candidates that explain so many times more than the best plausible one forbid it.
_MASKED = 1.25
#: A rival explains what the best explains: beside it, less than this share of its gain is left.
_OVERLAP = 0.5
#: A rival's evidence is within BIC_CLOSE of the best, or within this share of the residual energy
#: that the best leaves beyond noise: what neither explains could have decided between them.
_RIVAL = 0.05
#: A twin's evidence is at least this share of the best's; it needs none where the joint never
#: rests: then reversals alone tell twins apart, and how friction turns around is not known.
_TWIN = 0.8
#: A joint rests where it is slower than this share of its top speed; recordings of less rest than
#: the second share have none.
_AT_REST, _REST_SHARE = 2e-3, 0.02
#: A cause is a constant where its forms without speed explain this share of what it explains.
_CONSTANT = 0.9
#: What keeps so much of its gain beside an impossible candidate does not stand in for it.
_INDEPENDENT = 0.5
BIC_CLOSE = 10.0
#: A cause explains at least so much of what the best impossible one does.
_BELOW_IMPOSSIBLE = 0.5


@dataclass(frozen=True)
class Finding:
    """
    Hold one candidate with its evidence.

    ``delta_bic``: fall of the cost less the price of its parameters and of its grid;
    ``p_adjusted``: of the F test, times the number of all candidates tried; ``floor``: what
    ``score.cv_gain`` has to exceed; ``objection``: why it is physically impossible, or '';
    ``reduced``: the cause that it is where its own part is not seen, or ''.
    """

    effect: Term
    joint: int
    inner: Inner
    score: Score
    columns: CandidateColumns
    delta_bic: float
    p_adjusted: float
    floor: float = np.nan
    objection: str = ''
    reduced: str = ''
    rivals: tuple[Finding, ...] = ()
    failed: tuple[str, ...] = ()

    @property
    def key(self) -> tuple[str, int]:
        """Return effect and joint."""
        return self.effect.identifier, self.joint

    def reported(self, names: tuple[str, ...]) -> tuple[str, str]:
        """Return effect and joint under which it is reported."""
        return self.effect.identifier, joint_name(self.effect, self.joint, names)


@dataclass
class Selection:
    """
    Hold what was accepted, in order, and what the search was left with.

    ``ranking``: the first round's candidates, best first; ``rejected``: the best that was not
    accepted, with the gates it failed; ``structure``: what axes without physics still explain on
    data left out (energy per joint), and their floor; ``leftovers``: what free curves along the
    axes of the accepted still explain. ``before``: the fit without causes; ``after``: with the
    accepted, of ``target`` in ``system``.
    """

    before: Baseline
    after: Baseline
    system: System
    target: Target
    accepted: list[Finding] = field(default_factory=list)
    ranking: list[Finding] = field(default_factory=list)
    rejected: Finding | None = None
    masked: Finding | None = None
    structure_gain: FloatArray = field(default_factory=lambda: np.zeros(0))
    structure_floor: FloatArray = field(default_factory=lambda: np.zeros(0))
    structure_energy: FloatArray = field(default_factory=lambda: np.zeros(0))
    named_energy: float = 0.0
    leftovers: tuple[Leftover, ...] = ()


class Selector:
    """Select causes in a laboratory."""

    def __init__(
        self, laboratory: Laboratory, step: Callable[[str], None] = lambda text: None
    ) -> None:
        self.laboratory = laboratory
        self.settings = laboratory.settings
        self.step = step
        self.trials = sum(len(c.grid) for c in laboratory.candidates)
        self._impossible = 0.0
        #: Term and joint that were accepted and became impossible, and why.
        self._refused: dict[tuple[str, int], str] = {}

    def run(self) -> Selection:
        """Return the causes that passed all gates, after backward elimination."""
        lab = self.laboratory
        target = Target.make(lab.system, lab.y)
        baseline = fit_baseline(lab.system, target)
        result = Selection(baseline, baseline, lab.system, target)
        while True:
            self._search(result)
            # What an impossible one stood for may be named then.
            if not self._eliminate(result):
                break
        self.judge_structure(result)
        self.step('looking for more along the axes of the causes')
        result.leftovers = leftovers(lab, result.accepted)
        return result

    def _search(self, result: Selection) -> None:
        """Accept one cause after the other."""
        result.masked = None
        while True:
            system, target, baseline = result.system, result.target, result.after
            columns = self._columns(system, result.accepted)
            found = self.ranked(system, target, baseline, columns)
            if not result.ranking:
                result.ranking = found[:30]
            self._impossible = self._impossible_energy(found)
            if (
                self._distinct(result.accepted) >= self.settings.most_causes
                or len(result.accepted) >= self.settings.most_terms
            ):
                break
            top = self._refined(system, target, baseline, found)
            if not top:
                break
            best, masked = self._best(system, top, found)
            self.step(f'simulating recordings without a cause beyond {len(result.accepted)}')
            judged = partial(self._judged, result.accepted, system, baseline, columns, found)
            best = judged(best)
            if masked is not None:
                reason = f'{masked.effect.identifier} explains more but is impossible'
                best = replace(best, failed=(*best.failed, f'{reason}: {masked.objection}'))
                result.masked = masked
            else:
                best = self._or_as_good(system, top, found, best, judged)
            if best.failed:
                result.rejected = best
                break
            result.accepted.append(best)
            self._refit(result)
            self.step(f'found {best.effect.identifier}')

    def _judged(
        self,
        accepted: Sequence[Finding],
        system: System,
        baseline: Baseline,
        columns: Sequence[CandidateColumns],
        found: Sequence[Finding],
        finding: Finding,
    ) -> Finding:
        """Return a candidate with its floor, and the gates that it fails beside ``accepted``."""
        floor, _ = self.floors(system, baseline, columns, finding, len(accepted))
        finding = replace(finding, floor=max(floor[finding.key], self._misfit(found, finding)))
        known = any(other.key == finding.key for other in accepted)
        return replace(finding, failed=tuple(self.gates(finding, known)))

    @staticmethod
    def _impossible_energy(found: Sequence[Finding]) -> float:
        """
        Return the largest held-out energy that an impossible candidate removes.

        It shows how wrong the model is in ways that are in no catalogue.
        """
        energies = [
            finding.score.energy
            for finding in found
            if finding.objection and finding.delta_bic > BIC_CLOSE
        ]
        return max(energies, default=0.0)

    def _misfit(self, found: Sequence[Finding], best: Finding) -> float:
        """Return the floor that impossible candidates set: chance explains as much as half."""
        if best.score.energy <= 0.0:
            return 0.0
        share = best.score.cv_gain / best.score.energy
        return _BELOW_IMPOSSIBLE * self._impossible_energy(found) * share

    @staticmethod
    def _distinct(accepted: Sequence[Finding]) -> int:
        return len({finding.key for finding in accepted})

    def _columns(self, system: System, accepted: Sequence[Finding]) -> list[CandidateColumns]:
        if not accepted:
            return self.laboratory.columns
        return [columns.beside(system) for columns in self.laboratory.columns]

    def ranked(
        self,
        system: System,
        target: Target,
        baseline: Baseline,
        columns: Sequence[CandidateColumns],
    ) -> list[Finding]:
        """Return every candidate at the best point of its grid, best first."""
        found = []
        for candidate, its in zip(self.laboratory.candidates, columns, strict=True):
            d = its.products(system, target.y)
            s = score(system, target, baseline, its, d)
            inner = candidate.grid[s.best]
            found.append(
                self._finding(candidate.effect, candidate.joint, inner, s, its, len(its.A[0]))
            )
        return sorted(found, key=lambda finding: -finding.delta_bic)

    def _finding(
        self,
        effect: Term,
        joint: int,
        inner: Inner,
        s: Score,
        columns: CandidateColumns,
        grid: int,
    ) -> Finding:
        rows = float(self.laboratory.known[columns.rows].sum())
        k = int((s.amplitude != 0.0).sum()) + len(effect.refined)
        k = max(k, 1)
        bic = s.gain - k * np.log(rows) - 2.0 * np.log(grid)
        residual = max(rows - s.gain, 1.0)
        statistic = max(s.gain, 0.0) / k / (residual / rows)
        p = float(f_distribution.sf(statistic, k, rows)) * self.trials
        fit = Fitted(self.laboratory.signals[0], joint, inner, s.amplitude, s.error)
        return Finding(
            effect, joint, inner, s, columns, float(bic), min(p, 1.0),
            objection=effect.implausible(fit) or self._refused.get((effect.identifier, joint), ''),
            reduced=effect.reduces_to(fit),
        )  # fmt: skip

    def refine(
        self, system: System, target: Target, baseline: Baseline, finding: Finding
    ) -> Finding:
        """Return a finding with its continuous inner parameters where the cost is least."""
        effect, joint = finding.effect, finding.joint
        bounds = effect.inner_bounds(self.laboratory.signals[0], joint)
        names = [name for name in effect.refined if name in bounds]
        grid = next(
            len(c.grid)
            for c in self.laboratory.candidates
            if c.effect.identifier == effect.identifier and c.joint == joint
        )

        def at(inner: Inner) -> tuple[Score, CandidateColumns]:
            its = self.laboratory.single(effect, joint, inner)
            its = its.beside(system)
            return score(system, target, baseline, its, its.products(system, target.y)), its

        if not names:
            its = self.laboratory.single(effect, joint, finding.inner)
            its = its.beside(system)
            return replace(finding, columns=its)
        periodic = names == ['frequency']
        start = np.array([float(finding.inner[name]) for name in names])
        low = np.array([bounds[name][0] for name in names])
        high = np.array([bounds[name][1] for name in names])
        seen: dict[tuple[float, ...], float] = {}

        def inner_of(u: FloatArray) -> dict[str, float]:
            # A frequency has its own scale, one cycle over the range; the others are sizes.
            if periodic:
                span = float(self.laboratory.signals[0].scales.span[joint])
                x = start + u * 2.5 / span
            else:
                x = start * np.exp(u)
            x = np.clip(x, low, high)
            return {**finding.inner, **dict(zip(names, x.tolist(), strict=True))}

        def cost(u: FloatArray) -> float:
            inner = inner_of(u)
            key = tuple(inner[name] for name in names)
            if key not in seen:
                seen[key] = -at(inner)[0].gain
            return seen[key]

        size = 0.4 if periodic else 0.3
        simplex = np.vstack([np.zeros(len(names)), size * np.eye(len(names))])
        found = minimize(
            cost,
            np.zeros(len(names)),
            method='Nelder-Mead',
            options={'initial_simplex': simplex, 'maxfev': 25 * len(names), 'xatol': 0.01,
                     'fatol': 0.5},
        )  # fmt: skip
        inner = inner_of(found.x)
        s, its = at(inner)
        if s.gain < finding.score.gain:
            inner = dict(finding.inner)
            s, its = at(inner)
        return self._finding(effect, joint, inner, s, its, grid)

    def _refined(
        self, system: System, target: Target, baseline: Baseline, found: Sequence[Finding]
    ) -> list[Finding]:
        """Return the best candidates refined, best first; none if there is no evidence."""
        if found[0].delta_bic < BIC_CLOSE:
            return []
        self.step('refining the best candidates')
        top: list[Finding] = []
        plausible = 0
        for finding in found:
            if finding.delta_bic < BIC_CLOSE:
                break
            if plausible and finding.delta_bic < 0.5 * found[0].delta_bic:
                break
            refined = self.refine(system, target, baseline, finding)
            top.append(refined)
            plausible += not refined.objection
            if plausible >= _REFINED or (plausible and len(top) >= 2 * _REFINED):
                break
        return sorted(top, key=lambda finding: -finding.delta_bic)

    def _best(
        self, system: System, top: Sequence[Finding], found: Sequence[Finding]
    ) -> tuple[Finding, Finding | None]:
        """Return the best plausible candidate of ``top``, with its rivals, and who masks it."""
        possible = [finding for finding in top if not finding.objection]
        if not possible:
            return top[0], top[0]
        impossible = [finding for finding in top if finding.objection]
        best, masked = possible[0], None
        for k, finding in enumerate(possible):
            hides = self._masked_by(system, finding, impossible)
            if hides is None:
                best, masked = finding, None
                break
            if k == 0:
                masked = hides
        return self._with_rivals(system, top, found, best), masked

    def _or_as_good(
        self,
        system: System,
        top: Sequence[Finding],
        found: Sequence[Finding],
        best: Finding,
        judged: Callable[[Finding], Finding],
    ) -> Finding:
        """
        Return the best, or where it fails one that evidence cannot tell from it and that passes.

        What is there may be resembled by what is not, by chance a little better.
        """
        if not best.failed:
            return best
        impossible = [finding for finding in top if finding.objection]
        for finding in top:
            behind = best.delta_bic - finding.delta_bic
            if finding.objection or finding.key == best.key or behind >= BIC_CLOSE:
                continue
            if self._masked_by(system, finding, impossible) is None:
                other = judged(self._with_rivals(system, top, found, finding))
                if not other.failed:
                    return other
        return best

    def _with_rivals(
        self, system: System, top: Sequence[Finding], found: Sequence[Finding], best: Finding
    ) -> Finding:
        """
        Return a candidate with those that explain as much, and the twins of each.

        As much: in evidence, or where nominal parameters within their tolerance cost nothing, or
        but for what neither explains.
        """
        beside = system.extended([best.columns])
        aim = Target.make(beside, self.laboratory.y)
        after = fit_baseline(beside, aim)
        excess = max(after.cost - float(self.laboratory.known.sum()), 0.0)
        free = self._freely(system)
        most = free(best)

        def as_much(other: Finding) -> bool:
            behind = best.delta_bic - other.delta_bic
            if min(behind, most - free(other)) < BIC_CLOSE:
                return True
            if behind >= _RIVAL * excess:
                return False
            its = other.columns.beside(beside)
            left = score(beside, aim, after, its, its.products(beside, aim.y))
            return bool(left.gain < _OVERLAP * other.score.gain)

        # What is not seen to be more than the best is no rival of it, but one of any other.
        rivals = [
            other
            for other in top
            if other is not best
            and (other.reduced not in ('', best.effect.identifier) or not other.objection)
            and as_much(other)
        ]
        rivals.sort(key=lambda other: bool(other.objection))
        unique: dict[tuple[str, int], Finding] = {}
        for finding in (best, *rivals):
            for other in (finding, *self._twins(finding, found)):
                unique.setdefault(other.key, other)
        del unique[best.key]
        return replace(best, rivals=tuple(unique.values()))

    def _twins(self, best: Finding, found: Sequence[Finding]) -> list[Finding]:
        """Return the twins of a candidate that have evidence of their own, where it takes that."""
        # Where a dependence on speed is seen too, a constant alone is no twin.
        constant = best.score.gains.min() > _CONSTANT * best.score.gains.max()
        least = max(_TWIN * best.delta_bic, BIC_CLOSE)
        if constant and not self._rests(best.joint):
            least = -np.inf
        return [
            other
            for other in found
            if other.joint == best.joint
            and other.effect.identifier in best.effect.twins
            and not other.objection
            and other.delta_bic > least
        ]

    def _freely(self, system: System) -> Callable[[Finding], float]:
        """
        Return the evidence of candidates where deviations of the nominal cost nothing.

        Within its bounds a nominal parameter is as likely here as there: that a candidate needs
        more of them to be off speaks against it only as far as it needs more than the tolerance.
        """
        free = replace(system, prior=np.full(system.prior.shape, np.inf))
        target = Target.make(free, self.laboratory.y)
        base = fit_baseline(free, target)

        def evidence(finding: Finding) -> float:
            its = finding.columns.beside(free)
            s = score(free, target, base, its, its.products(free, target.y))
            return finding.delta_bic - finding.score.gain + s.gain

        return evidence

    def _rests(self, joint: int) -> bool:
        """Tell whether a joint stands for some of the time, so that its friction is known."""
        slow = np.concatenate(
            [
                np.abs(signals.v[:, joint]) < _AT_REST * signals.scales.speed[joint]
                for signals in self.laboratory.signals
                if not any(rest.joint == joint for rest in signals.rests)
            ]
            or [np.zeros(1)]
        )
        return bool(slow.mean() > _REST_SHARE)

    def _masked_by(
        self, system: System, finding: Finding, impossible: Sequence[Finding]
    ) -> Finding | None:
        """Return the impossible candidate that explains the same as a finding, and more."""
        for other in impossible:
            # Noise of position, twice differentiated, looks like a gear: of any sign, also alone.
            rows = float(self.laboratory.known[other.columns.rows].sum())
            feigned = self.laboratory.feigned * rows
            if other.score.gain - feigned <= _MASKED * finding.score.gain:
                continue
            beside = system.extended([other.columns])
            aim = Target.make(beside, self.laboratory.y)
            its = finding.columns.beside(beside)
            left = score(beside, aim, fit_baseline(beside, aim), its, its.products(beside, aim.y))
            if left.gain < _INDEPENDENT * finding.score.gain:
                return other
        return None

    def floors(
        self,
        system: System,
        baseline: Baseline,
        columns: Sequence[CandidateColumns],
        best: Finding | None,
        generation: int,
    ) -> tuple[dict[tuple[str, int], float], FloatArray]:
        """
        Return the floor of a candidate and of structure, from simulated recordings.

        Each holds the causes accepted so far, and is scored as the measurement is.

        :param best: the candidate, None for structure alone.
        :param generation: how many causes are accepted, for the seed.
        """
        lab, settings = self.laboratory, self.settings
        wanted = [
            (f'{c.effect.identifier}', c.joint, its)
            for c, its in zip(lab.candidates, columns or lab.columns, strict=True)
            if best is not None and (c.effect.identifier, c.joint) == best.key
        ]
        structures = [s.beside(system) for s in lab.structure_columns]
        # What the candidate explains is not held for friction that turns around in another way.
        beside = system if best is None else system.extended([best.columns])
        largest = {(name, joint): 0.0 for name, joint, _ in wanted}
        structure = np.zeros(lab.robot.n)
        seed = [settings.seed, generation]
        for y in islice(null_recordings(lab, system, baseline.x, beside, seed), settings.nulls):
            target = Target.make(system, y)
            base = fit_baseline(system, target)
            for name, joint, its in wanted:
                s = score(system, target, base, its, its.products(system, y))
                largest[(name, joint)] = max(largest[(name, joint)], s.cv_gain)
            for i, its in enumerate(structures):
                s = score(system, target, base, its, its.products(system, y))
                structure[i] = max(structure[i], s.cv_gain)
        # What may choose among more points has to explain more.
        choice = {(name, joint): 1.0 + np.log(its.C.shape[2]) for name, joint, its in wanted}
        feigned = self.laboratory.feigned
        floor = {
            key: max(settings.floor * float(choice[key]), settings.floor_margin * value, feigned)
            for key, value in largest.items()
        }
        chance = settings.floor_margin * np.maximum(structure, feigned)
        return floor, np.maximum(settings.structure_floor, chance)

    def gates(self, finding: Finding, known: bool = False) -> list[str]:
        """
        Return what speaks against naming a finding.

        :param known: its effect is named in this joint already, and this is another harmonic: it
            has to gain over all folds, but one may lack the part of the turn that shows it.
        """
        settings, s = self.settings, finding.score
        failed = []
        if finding.objection:
            failed.append(finding.objection)
        if not finding.delta_bic > settings.least_bic:
            failed.append(f'delta BIC is {finding.delta_bic:.1f}')
        if not finding.p_adjusted < settings.largest_p:
            failed.append(f'p is {finding.p_adjusted:.2g}')
        if not s.cv_gain > finding.floor:
            failed.append(
                f'it removes {100 * s.cv_gain:.1f} % of what is unexplained on data left out, '
                f'within the floor of {100 * finding.floor:.1f} %'
            )
        if s.improved < self.settings.folds_improved and not known:
            failed.append(f'{100 * s.improved:.0f} % of the folds improve')
        if s.cv_gain < s.cv_se and not known:
            failed.append('the gain is within its standard error over the folds')
        return failed

    def judge_structure(self, result: Selection) -> None:
        """Measure what axes without physics still predict on data left out."""
        lab = self.laboratory
        system, target = result.system, result.target
        _, floor = self.floors(system, result.after, [], None, 100 + len(result.accepted))
        gains, energy = [], []
        for its in lab.structure_columns:
            its = its.beside(system)
            s = score(system, target, result.after, its, its.products(system, target.y))
            gains.append(s.cv_gain)
            energy.append(s.energy)
        result.structure_gain = np.array(gains)
        left = np.maximum(result.after.held_out.sum(axis=1), 1e-300)
        result.structure_floor = np.maximum(floor, _BELOW_IMPOSSIBLE * self._impossible / left)
        result.structure_energy = np.array(energy)
        result.named_energy = float(result.before.held_out.sum() - result.after.held_out.sum())

    def _eliminate(self, result: Selection) -> bool:
        """
        Take out causes that the others, accepted later, have made unnecessary, or impossible.

        Returns whether there were any of the latter.
        """
        lab = self.laboratory
        while len(result.accepted) > 1:
            worst, which = np.inf, -1
            for k, finding in enumerate(result.accepted):
                others = [f.columns for j, f in enumerate(result.accepted) if j != k]
                system = lab.system.extended(others)
                target = Target.make(system, lab.y)
                base = fit_baseline(system, target)
                # Its products are with causes accepted before it, which others may be no more.
                its = finding.columns.beside_first(lab.system.Z.shape[2]).beside(system)
                s = score(system, target, base, its, its.products(system, target.y))
                margin = s.cv_gain - finding.floor
                if margin < worst:
                    worst, which = margin, k
            if worst > 0.0:
                break
            del result.accepted[which]
            self._refit(result)
        return self._drop_impossible(result)

    def _refit(self, result: Selection) -> None:
        lab = self.laboratory
        result.system = lab.system.extended([f.columns for f in result.accepted])
        result.target = Target.make(result.system, lab.y)
        result.after = fit_baseline(result.system, result.target)

    def _drop_impossible(self, result: Selection) -> bool:
        """Take out causes whose amplitude, fitted with all others, is impossible, if any."""
        refused = len(self._refused)
        again = True
        while again:
            again = False
            first = len(self.laboratory.nominal.bound)
            for k, finding in enumerate(result.accepted):
                count = finding.columns.C.shape[3]
                amplitude = result.after.x[first : first + count]
                first += count
                fit = Fitted(
                    self.laboratory.signals[0], finding.joint, finding.inner, amplitude,
                    finding.score.error,
                )  # fmt: skip
                if reason := finding.effect.implausible(fit):
                    result.rejected = replace(finding, objection=reason, failed=(reason,))
                    del result.accepted[k]
                    self._refused[finding.key] = reason
                    self._refit(result)
                    again = True
                    break
        return len(self._refused) > refused
