# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where evidence cannot tell candidates apart, the first that passes all gates is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.selector import chosen
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.evidence import CandidateColumns, Score

EMPTY = np.zeros((1, 1, 1, 1))
COLUMNS = CandidateColumns(np.array([0]), EMPTY, EMPTY, EMPTY)
SCORE = Score(0, 90.0, np.ones(1), np.ones(1), np.zeros(1), 0.01, 0.001, 0.005, 50.0, np.ones(1))


def finding(name, joint, bic, objection=''):
    return Finding(TERMS[name](), joint, {}, SCORE, COLUMNS, bic, 0.0, objection)


class Round:
    """Candidates of a round of which none is the rival of another."""

    def __init__(self, top):
        self.top = top

    def with_rivals(self, best):
        return best


def named(top, within=()):
    """Return what is chosen of ``top``, of which ``within`` do not exceed their floor."""
    top = [replace(x, floor=1.0) if x.key in within else x for x in top]
    return chosen(Round(top), Finding.judged)


FIRST = finding('encoder_eccentricity', 0, 74.0)
CLOSE = finding('effort_bias', 1, 69.0)
FAR = finding('spring', 1, 63.0)
IMPOSSIBLE = finding('gravity', 0, 72.0, 'no such mass')
TOP = [FIRST, IMPOSSIBLE, CLOSE, FAR]


def test_the_best_is_named_where_it_passes():
    assert named(TOP).key == FIRST.key


def test_the_next_within_ten_of_evidence_is_named_where_only_it_passes():
    assert named(TOP, [FIRST.key]).key == CLOSE.key


def test_what_is_further_behind_or_impossible_is_not_named_in_the_place_of_the_best():
    chosen = named(TOP, [FIRST.key, CLOSE.key])
    assert chosen.key == FIRST.key
    assert chosen.failed == (
        'it removes 1.0 % of what is unexplained on data left out, within the floor of 100.0 %',
    )


def test_where_none_is_possible_the_best_is_rejected_as_impossible():
    chosen = named([IMPOSSIBLE, finding('spring', 1, 63.0, 'negative')])
    assert chosen.key == IMPOSSIBLE.key
    assert chosen.failed == ('no such mass',)
