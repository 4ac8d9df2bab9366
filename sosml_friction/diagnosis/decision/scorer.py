# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The evidence for every candidate, at the point of its grid that explains most."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.sliding import clear_of_turns, fit_within, sliding
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.candidate import Candidate
from sosml_friction.regression.chance import BEYOND_CHANCE
from sosml_friction.regression.evidence import CandidateColumns, Fit, Score
from sosml_friction.regression.inner_search import refine
from sosml_friction.regression.placed import Placed
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.whitened import WhitenedRegression

_POSITION = 'position'


class Scorer:
    """
    Score candidates beside a fit.

    How friction turns around is no cause: a joint that sticks has any friction up to that of
    motion, before it moves. So what has no evidence but beside reversals has none, unless it acts
    there; and what is beside reversals is none for an impossible candidate, which would say that
    the model is wrong in a way without a name.
    ``refused``: effect and joint of candidates that are impossible whatever their amplitude, and
    why.
    """

    def __init__(self, laboratory: WhitenedRegression) -> None:
        self.laboratory = laboratory
        self.refused: dict[tuple[str, int], str] = {}
        self._far = sliding(laboratory)
        self._clear = self._far & clear_of_turns(laboratory)
        self._last: tuple[Fit, dict[bool, Fit]] | None = None

    @property
    def choice(self) -> float:
        """Return the price of the choice among all candidates, 2 ln K."""
        return 2.0 * float(np.log(max(len(self.laboratory.candidates), 1)))

    def ranked(self, fit: Fit, columns: Sequence[CandidateColumns]) -> list[Finding]:
        """
        Return every candidate at the best point of its grid, best first.

        But for those that act in joints alone of which nothing is known.
        """
        found = [
            self.finding(fit, candidate, its)
            for candidate, its in zip(self.laboratory.candidates, columns, strict=True)
            if self.laboratory.known[its.rows].any()
        ]
        return sorted(found, key=lambda finding: finding.rank)

    def finding(self, fit: Fit, candidate: Candidate, columns: CandidateColumns) -> Finding:
        """Return a candidate at the best point of its grid beside a fit."""
        s = fit.score(columns, candidate.effect.amplitude_range)
        inner, grid = candidate.grid[s.best], columns.C.shape[2]
        return self._finding(fit, candidate.effect, candidate.joint, inner, s, columns, grid)

    def _finding(
        self,
        beside: Fit,
        effect: Term,
        joint: int,
        inner: Inner,
        s: Score,
        columns: CandidateColumns,
        grid: int,
    ) -> Finding:
        """
        Return a candidate with its BIC and its floor.

        Of N rows, k parameters, K candidates and g points of a grid, the gain G has
        delta BIC = G - k ln N - 2 ln (K g): the best of many explains as much by chance. What
        may choose among g points has to explain more of data left out as well:
        ``floor (1 + ln g)``.
        """
        objection = self.objection(effect, joint, inner, s.amplitude, s.error)
        objection = objection or self.refused.get((effect.key, joint), '')
        rows = float(self.laboratory.known[columns.rows].sum())
        amplitudes = int((s.amplitude != 0.0).sum())
        k = max(amplitudes + len(effect.searched_inner(self.laboratory.signals[0], joint)), 1)
        price = float(k * np.log(rows) + 2.0 * np.log(grid)) + self.choice
        told = not effect.at_reversals or effect.elsewhere_too
        told = told or bool(objection and not effect.reversals_alone)
        if s.gain - price >= VERY_STRONG and told:
            # What is fast over position is in the band where a joint is slow: where it turns.
            clear = effect.axis == _POSITION and not objection
            far = self._without_reversals(beside, s, columns, clear)
            # All rows chose the inner parameters: of those far off amplitudes alone are asked.
            rows_far = self._clear if clear else self._far
            asked = amplitudes * float(np.log(max(rows_far.sum(), 1)))
            s = far if objection or far.gain - asked < VERY_STRONG else s
        bic = s.gain - price
        fit = self._fitted(effect, joint, inner, s.amplitude, s.error)
        return Finding(
            effect, joint, inner, s, columns, float(bic),
            floor=self.laboratory.settings.floor * (1.0 + float(np.log(grid))),
            objection=objection, reduced=effect.reduces_to(fit),
        )  # fmt: skip

    def objection(
        self, effect: Term, joint: int, inner: Inner, found: FloatArray, error: FloatArray
    ) -> str:
        """
        Return why the amplitudes that a fit found are impossible, else ''.

        Of a term that the model states it found the change, and the whole is judged. It may be
        nothing, and beyond its range by chance or by its tolerance.
        """
        if effect.stated is not None:
            slack = self.laboratory.settings.tolerance * np.abs(effect.stated)
            slack = np.maximum(slack, BEYOND_CHANCE * error)
            if (np.abs(effect.whole(found)) <= slack).all():
                return ''
            found = found - np.clip(found, -slack, slack)
        return effect.implausible(self._fitted(effect, joint, inner, found, error))

    def _fitted(
        self, effect: Term, joint: int, inner: Inner, found: FloatArray, error: FloatArray
    ) -> Fitted:
        return Fitted(self.laboratory.signals[0], joint, inner, effect.whole(found), error)

    def _without_reversals(
        self, beside: Fit, s: Score, columns: CandidateColumns, clear: bool
    ) -> Score:
        """
        Return a score with what the rows that are far from reversals say of its gains.

        :param clear: of those that see nothing of a reversal.
        """
        rows = self._clear if clear else self._far
        if self._last is None or self._last[0] is not beside:
            self._last = beside, {}
        fits = self._last[1]
        if clear not in fits:
            fits[clear] = fit_within(beside.system, beside.target.y, rows)
        fit = fits[clear]
        C = columns.C[:, :, s.best : s.best + 1] * rows[:, columns.rows, None, None]
        there = fit.score(CandidateColumns.make(fit.system, columns.rows, C))
        return replace(
            there, best=s.best, amplitude=s.amplitude, error=s.error, x=s.x, gains=s.gains
        )

    def refine(self, fit: Fit, finding: Finding, beside: Sequence[Placed] = ()) -> Finding:
        """
        Return a finding with its continuous inner parameters where the cost is least.

        :param beside: the terms of the fit.
        """
        effect, joint = finding.effect, finding.joint
        effect, inner, s, columns = refine(
            self.laboratory, fit, effect, joint, finding.inner, beside
        )
        if not effect.searched_inner(self.laboratory.signals[0], joint):
            return replace(finding, columns=columns)
        grid = next(len(c.grid) for c in self.laboratory.candidates if c.key == finding.key)
        return self._finding(fit, effect, joint, inner, s, columns, grid)
