# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Forward selection of causes, with backward elimination."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.misfit import Misfit
from sosml_friction.diagnosis.decision.rivals import Rivals, same_term
from sosml_friction.diagnosis.decision.scorer import Scorer
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.tones import tone_in_place
from sosml_friction.diagnosis.decision.torque_ripple import torque_ripple_in_place
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.kinds.transmission_term import TransmissionTerm
from sosml_friction.regression.carried_load import fitted_to_carried_load
from sosml_friction.regression.estimate import estimate, refined_again, settle
from sosml_friction.regression.evidence import CandidateColumns, Fit
from sosml_friction.regression.placed import with_amplitudes
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.whitened import WhitenedRegression

#: Candidates of a round whose inner parameters are refined before the best is chosen. Each costs
#: 25 fits per parameter. Halved and doubled, no answer of ``python -m validation.sensitivity
#: --seed 1`` changes.
_REFINED = 4
#: Candidates that the report lists.
_LISTED = 30


class Selector:
    """Select causes in a laboratory."""

    def __init__(
        self, laboratory: WhitenedRegression, step: Callable[[str], None] = lambda text: None
    ) -> None:
        self.laboratory = laboratory
        self.settings = laboratory.settings
        self.step = step
        self.scorer = Scorer(laboratory)
        self._misfit: Misfit

    def run(
        self,
        all_friction: bool = False,
        begin: Iterable[Finding] = (),
        refused: Mapping[tuple[str, int], str] | None = None,
    ) -> Selection:
        """
        Return the causes that passed all gates, after backward elimination.

        :param begin: causes that are accepted at the outset.
        :param refused: candidates that are impossible whatever their amplitude, and why.
        :param all_friction: begin with all numbers of the nominal's friction as causes, instead of
            none: those stay that explain more than their floors beside the others.
        """
        lab = self.laboratory
        fit = Fit.make(lab.system, lab.y)
        result = Selection(fit.baseline, fit).refitted(lab, begin)
        self.scorer.refused = dict(refused or {})
        if all_friction:
            result = self._with_all_friction(result)
        while True:
            searched = self._without_idle(self._search(result), 0 if all_friction else 1)
            result = self._without_impossible(searched)
            # What an impossible one stood for may be named then.
            if result is not searched:
                continue
            settled = self.settled(result)
            result = self._without_impossible(settled)
            if result is settled:
                return result

    def _with_all_friction(self, result: Selection) -> Selection:
        """Return the selection with the friction of every joint accepted, each beside the rest."""
        lab = self.laboratory
        columns = [its.beside(result.system) for its in lab.columns]
        ranking = self.scorer.ranked(result.fit, columns)
        result = replace(result, ranking=tuple(ranking[:_LISTED]))
        of_grid = {c.key: its for c, its in zip(lab.candidates, columns, strict=True)}
        keys = nominal_friction(lab)
        return result.refitted(lab, [self._beside(result, of_grid, key, keys) for key in keys])

    def settled(self, found: Selection) -> Selection:
        """
        Search the inner parameters of the accepted beside one another, as a fit of them does.

        The load is that of the bodies with them, and what is left is judged.
        """
        placed = refined_again(self.laboratory, [f.placed for f in found.accepted])
        placed = settle(self.laboratory, placed, self.step)
        carried, placed = fitted_to_carried_load(self.laboratory, placed)
        accepted = [
            replace(finding, effect=each.term, inner=each.inner, columns=each.columns)
            for finding, each in zip(found.accepted, placed, strict=True)
        ]
        result = replace(found.refitted(self.laboratory, accepted), laboratory=carried)
        self.step('looking for what is left')
        return result.with_remainder(carried)

    def _search(self, result: Selection) -> Selection:
        """Accept one cause after the other."""
        lab = self.laboratory
        while True:
            columns = [its.beside(result.system) for its in lab.columns]
            found = _once(self.scorer.ranked(result.fit, columns), result.accepted)
            if not result.ranking:
                result = replace(result, ranking=tuple(found[:_LISTED]))
            self._misfit = Misfit.make(result.fit, impossible(found))
            if self._enough(result.accepted):
                return result
            top = self._refined(result, found)
            nothing_else = (f for f in top if only_impossible(f, lab.signals[0]))
            result = replace(result, refused=next(nothing_else, None))
            if not top:
                return result
            of_grid = {c.key: its for c, its in zip(lab.candidates, columns, strict=True)}
            if friction := self._wrong_friction(result, of_grid, top[0]):
                result = result.refitted(lab, [*result.accepted, *friction])
                self.step('found the friction of the nominal to be wrong')
                continue
            rivals = Rivals(lab, result.system, top, found)
            best = self._as_stated(result, chosen(rivals, self._judged), rivals)
            if not best.failed and (other := self._in_place(result.fit, best)):
                best = replace(best, instead=other, failed=(f'{other} explains more',))
            if best.failed:
                return replace(result, rejected=best)
            result = result.refitted(lab, [*result.accepted, best])
            self.step(f'found {best.effect.identifier}')

    def _in_place(self, fit: Fit, best: Finding) -> str:
        """Return what without a name is a better reason than a cause, '' for nothing."""
        tone = tone_in_place(self.laboratory, fit, best)
        return tone or torque_ripple_in_place(self.laboratory, fit, best, self.scorer.choice)

    def _enough(self, accepted: Sequence[Finding]) -> bool:
        """Tell whether no more causes are named: each joint has its own."""
        settings, n = self.settings, self.laboratory.robot.n
        distinct = len({finding.key for finding in accepted})
        return distinct >= n * settings.most_causes or len(accepted) >= n * settings.most_terms

    def _refined(self, result: Selection, found: Sequence[Finding]) -> list[Finding]:
        """Return the best candidates refined, best first; none if there is no evidence."""
        if not found or found[0].delta_bic < VERY_STRONG:
            return []
        self.step('refining the best candidates')
        top: list[Finding] = []
        beside = [own.placed for own in result.accepted]
        plausible = 0
        for finding in found:
            if finding.delta_bic < VERY_STRONG:
                break
            if plausible and finding.delta_bic < 0.5 * found[0].delta_bic:
                break
            refined = self.scorer.refine(result.fit, finding, beside)
            top.append(refined)
            plausible += not refined.objection
            if plausible >= _REFINED or (plausible and len(top) >= 2 * _REFINED):
                break
        return sorted(top, key=lambda finding: finding.rank)

    def _judged(self, finding: Finding) -> Finding:
        """Return a candidate with the gates that it fails beside what is impossible."""
        floor = max(finding.floor, self._misfit.floor(finding))
        return replace(finding, floor=floor).judged()

    def _as_stated(self, result: Selection, best: Finding, rivals: Rivals) -> Finding:
        """
        Return a term as the model states it, where a cause is the same but for its error.

        Its inner parameters are those of the model then, as far as these data know them.
        """
        if best.effect.stated is not None or best.failed:
            return best
        for twin in (f for f in rivals.top if f.effect.stated is not None and same_term(f, best)):
            placed = [*(finding.placed for finding in result.accepted), best.placed]
            errors = estimate(self.laboratory, placed).inner_errors[-1]
            off = (abs(best.inner[name] - twin.inner[name]) for name in twin.effect.inner)
            reach = (Z_95 * errors.get(name, 0.0) for name in twin.effect.inner)
            if all(own <= most for own, most in zip(off, reach, strict=True)):
                stated = self._judged(rivals.with_rivals(twin))
                return best if stated.failed else stated
        return best

    def _wrong_friction(
        self,
        result: Selection,
        of_grid: Mapping[tuple[str, int], CandidateColumns],
        best: Finding,
    ) -> list[Finding]:
        """
        Return the parameters of a joint's nominal friction that are off, where they are several.

        They are one candidate: together they explain more than the best alone, and each passes
        its gates beside the others. One after the other, another cause would have stood for all.
        """
        lab, most = self.laboratory, best.delta_bic
        friction: list[tuple[str, int]] = []
        for i in range(lab.robot.n):
            keys = [key for key in nominal_friction(lab) if key[1] == i]
            if any(finding.key in keys for finding in result.accepted):
                continue
            if (evidence := self._together(result, of_grid, keys)) > most:
                most, friction = evidence, keys
        while friction:
            parts = [self._beside(result, of_grid, key, friction).judged() for key in friction]
            if not any(part.failed for part in parts):
                return parts
            friction = [part.key for part in parts if not part.failed]
            if self._together(result, of_grid, friction) <= best.delta_bic:
                break
        return []

    def _together(
        self,
        result: Selection,
        of_grid: Mapping[tuple[str, int], CandidateColumns],
        keys: Sequence[tuple[str, int]],
    ) -> float:
        """Return the evidence of two candidates and more of a joint together, as a BIC."""
        if len(keys) < 2:
            return -np.inf
        C = np.concatenate([of_grid[key].C for key in keys], axis=3)
        columns = CandidateColumns.make(result.system, of_grid[keys[0]].rows, C)
        rows = float(self.laboratory.known[columns.rows].sum())
        price = len(keys) * float(np.log(rows)) + self.scorer.choice
        return result.fit.score(columns).gain - price

    def _beside(
        self,
        result: Selection,
        of_grid: Mapping[tuple[str, int], CandidateColumns],
        key: tuple[str, int],
        keys: Sequence[tuple[str, int]],
    ) -> Finding:
        """Return a candidate without inner parameters, beside others."""
        lab, others = self.laboratory, [of_grid[other] for other in keys if other != key]
        fit = Fit.make(result.system.extended(others), lab.y)
        (finding,) = (
            self.scorer.finding(fit, candidate, of_grid[key])
            for candidate in lab.candidates
            if candidate.key == key
        )
        return finding

    def _without_idle(self, result: Selection, least: int) -> Selection:
        """
        Take out causes that the others, accepted later, have made unnecessary.

        :param least: so many stay: one passed its gates with no other beside it.
        """
        lab = self.laboratory
        nominal = len(lab.nominal.bound)
        while len(result.accepted) > least:
            margins = []
            for k, finding in enumerate(result.accepted):
                fit = result.refitted(lab, result.others(k)).fit
                # Its products are with causes accepted before it, which others may be no more.
                s = fit.score(finding.columns.beside_first(nominal))
                margins.append(s.cv_gain - finding.floor)
            if min(margins) > 0.0:
                break
            result = result.refitted(lab, result.others(int(np.argmin(margins))))
        return result

    def _without_impossible(self, result: Selection) -> Selection:
        """Take out causes whose amplitude, fitted with all others, is impossible, if any."""
        while (found := self._impossible_one(result)) is not None:
            k, reason = found
            taken = replace(result.accepted[k], objection=reason, failed=(reason,))
            self.scorer.refused[taken.key] = reason
            fewer = result.refitted(self.laboratory, result.others(k))
            result = replace(fewer, rejected=taken)
        return result

    def _impossible_one(self, result: Selection) -> tuple[int, str] | None:
        """Return which of the accepted has an impossible amplitude, and why; or None."""
        nominal = len(self.laboratory.nominal.bound)
        efforts: list[tuple[Finding, FloatArray]] = []
        for k, (finding, own) in enumerate(with_amplitudes(result.accepted, nominal)):
            amplitude, error = result.after.x[own], finding.score.error
            place = finding.effect, finding.joint, finding.inner
            if reason := self.scorer.objection(*place, amplitude, error):
                return k, reason
            effort = finding.columns.C[:, :, 0] @ amplitude
            for other, its in efforts:
                if _alike(finding, other) and _cancel(effort, its):
                    name = other.effect.identifier.replace('_', ' ')
                    return k, f'it and the {name} cancel: together they are another curve'
            efforts.append((finding, effort))
        return None


def _alike(one: Finding, other: Finding) -> bool:
    """Tell whether two causes of a joint are one effect, or efforts over position."""
    position = all(cause.effect.free_axis == 'position' for cause in (one, other))
    return one.joint == other.joint and (position or one.key == other.key)


def _once(ranking: Sequence[Finding], accepted: Sequence[Finding]) -> list[Finding]:
    """
    Return the candidates but for accepted terms of a joint's friction law.

    It has each term once: more of one is another law, which no model file holds.
    """
    law = {finding.key for finding in accepted if finding.effect.of_law}
    return [finding for finding in ranking if finding.key not in law]


def _cancel(one: FloatArray, other: FloatArray) -> bool:
    """
    Tell whether two efforts make less together than either does alone.

    Two terms of a series do that where neither is there: of y = x^3 a line and a cosine, of a step
    two exponentials.
    """
    both = float(np.sum((one + other) ** 2))
    return both < min(float(np.sum(one**2)), float(np.sum(other**2)))


def nominal_friction(laboratory: WhitenedRegression) -> list[tuple[str, int]]:
    """Return the candidates that are numbers of the model's own friction laws that are off."""
    return [c.key for c in laboratory.candidates if c.effect.of_law and c.effect.parameter_error]


def only_impossible(finding: Finding, signals: Signals) -> bool:
    """
    Tell whether nothing else speaks against a candidate: it explains something, no chance.

    It explains more than its floor even without the fold in which it removes most: what comes
    once is a disturbance, and what acts in fast or loaded motion alone differs between folds.

    Of what acts at reversals alone, less than nothing is friction that turns around ahead of
    motion: that of a joint that sticks does, and it is no structure. Nor is a stiff gear that
    gives less than nothing: noise of position n makes M n'' less effort than the model expects,
    and -M^2 / K n'''' in its column. Their mean product is below 0.
    """
    s, effect = finding.score, finding.effect
    stiff = isinstance(effect, TransmissionTerm) and effect.is_stiff(
        signals, finding.joint, finding.inner
    )
    less = (effect.reversals_alone or stiff) and bool((effect.whole(s.amplitude) < 0.0).all())
    return bool(finding.objection) and not less and s.cv_least > finding.floor


def impossible(found: Sequence[Finding]) -> list[Finding]:
    """
    Return the candidates with evidence that are impossible.

    Not so another form of a term that is possible as the model states it.
    """
    stated = [f for f in found if f.effect.stated is not None and not f.objection]
    return [
        f
        for f in found
        if f.objection
        and f.delta_bic > VERY_STRONG
        and not any(same_term(f, own) for own in stated)
    ]


def chosen(rivals: Rivals, judged: Callable[[Finding], Finding]) -> Finding:
    """
    Return the candidate of a round to be accepted, or rejected with the gates that it fails.

    The best that is possible. Where it fails a gate, one that evidence cannot tell from it and
    that passes: what is there may be resembled by what is not, by chance a little better. The best
    of all where none is possible.

    :param judged: returns a candidate with the gates that it fails.
    """
    possible = [finding for finding in rivals.top if not finding.objection]
    if not possible:
        return judged(rivals.top[0])
    best = judged(rivals.with_rivals(possible[0]))
    if best.failed:
        for finding in possible[1:]:
            if best.delta_bic - finding.delta_bic >= VERY_STRONG:
                break
            other = judged(rivals.with_rivals(finding))
            if not other.failed:
                return other
    return best
