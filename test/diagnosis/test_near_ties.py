# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where evidence cannot tell candidates apart, the first that passes all gates is named."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.diagnosis.decision.selection import Finding, Selector
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.evidence import CandidateColumns, Score

EMPTY = np.zeros((1, 1, 1, 1))
COLUMNS = CandidateColumns(np.array([0]), EMPTY, EMPTY, EMPTY)
SCORE = Score(0, 90.0, np.ones(1), np.ones(1), np.zeros(1), 0.01, 0.001, 1.0, 50.0, np.ones(1))


def finding(name, joint, bic, objection=''):
    return Finding(TERMS[name](), joint, {}, SCORE, COLUMNS, bic, 0.0, objection=objection)


class Told(Selector):
    """Select among findings that are given, of which ``within`` do not exceed their floor."""

    def __init__(self, top, within=()):
        self.top, self.within = top, within

    def _masked_by(self, system, finding, impossible):
        return None

    def _with_rivals(self, system, top, found, best):
        return best

    def judged(self, finding):
        failed = ('floor',) if finding.key in self.within else ()
        return replace(finding, failed=failed)

    def chosen(self):
        best, _ = self._best(None, self.top, self.top)
        best = self.judged(best)
        return self._or_as_good(None, self.top, self.top, best, self.judged)


FIRST = finding('encoder_eccentricity', 0, 74.0)
CLOSE = finding('effort_bias', 1, 69.0)
FAR = finding('spring', 1, 63.0)
IMPOSSIBLE = finding('gravity', 0, 72.0, 'no such mass')
TOP = [FIRST, IMPOSSIBLE, CLOSE, FAR]


def test_the_best_is_named_where_it_passes():
    assert Told(TOP).chosen().key == FIRST.key


def test_the_next_within_ten_of_evidence_is_named_where_only_it_passes():
    assert Told(TOP, [FIRST.key]).chosen().key == CLOSE.key


def test_what_is_further_behind_or_impossible_is_not_named_in_the_place_of_the_best():
    chosen = Told(TOP, [FIRST.key, CLOSE.key]).chosen()
    assert chosen.key == FIRST.key
    assert chosen.failed == ('floor',)


class Masking(Selector):
    """Weigh one impossible candidate against another that explains the same."""

    def __init__(self, feigned):
        self.laboratory = SimpleNamespace(
            known=np.array([1000.0, 1000.0]), y=None, feigned=feigned
        )


@pytest.mark.parametrize(
    ('feigned', 'masked'), [(0.0, True), (0.01, True), (0.06, False), (0.04, True)]
)
def test_what_noise_of_position_feigns_in_its_own_joint_masks_nothing(
    monkeypatch, feigned, masked
):
    """Of 160 beside 90 more than 1.25 is left while less than 47.5 of its 1000 rows is feigned."""
    for name in ('Target', 'fit_baseline', 'score'):
        nothing = SimpleNamespace(make=lambda *_: SimpleNamespace(y=None))
        monkeypatch.setattr(
            f'sosml_friction.diagnosis.decision.selection.{name}',
            nothing if name == 'Target' else lambda *_: replace(SCORE, gain=0.0),
        )
    columns = SimpleNamespace(
        rows=COLUMNS.rows, beside=lambda _: columns, products=lambda *_: None
    )
    other = replace(
        finding('joint_elasticity', 0, 140.0, 'of the wrong sign'),
        score=replace(SCORE, gain=160.0), columns=columns,
    )  # fmt: skip
    best = replace(finding('effort_delay', 0, 74.0), columns=columns)
    system = SimpleNamespace(extended=lambda _: None)
    assert (Masking(feigned)._masked_by(system, best, [other]) is other) == masked
