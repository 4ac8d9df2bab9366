# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Each gate at its limit, and the gain of each fold by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.model.terms.spring import Spring
from sosml_friction.regression.evidence import (
    CandidateColumns,
    Fit,
    Score,
    System,
    make_blocks,
)

FOLDS, ROWS = 7, 20
BLOCKS = make_blocks(2 * FOLDS * ROWS, 2 * FOLDS, FOLDS)
#: The fold of each row: two blocks of 20 rows in each fold.
FOLD = np.tile(np.repeat(np.arange(FOLDS), ROWS), 2)
NOTHING = np.zeros((len(FOLD), 1, 1))


def system(Z=NOTHING, bound=0.0):
    """Return the equations of one nominal parameter of one joint."""
    p = Z.shape[2]
    return System.make(Z, np.full(p, bound), np.full(p, np.inf), BLOCKS)


def candidate(of, *grid):
    """Return the columns (rows,) of a candidate in the only joint, one for each grid point."""
    C = np.stack(grid, axis=1)[:, None, :, None]
    return CandidateColumns.make(of, np.array([0]), C)


def by_hand(y):
    """
    Return the energy that a constant removes of each fold, predicted by the mean of the others.

    sum y^2 - sum (y - m)^2 = N (2 mean(y) m - m^2) over the N rows of the fold.
    """
    removed = []
    for f in range(FOLDS):
        m, own = y[f != FOLD].mean(), y[f == FOLD]
        removed.append(len(own) * (2.0 * own.mean() * m - m**2))
    return np.array(removed)


def of_levels(*levels):
    """Return a target that is constant over each fold, and a little beside it."""
    return np.array(levels)[FOLD] + 0.3 * np.where(np.arange(len(FOLD)) % 2, 1.0, -1.0)


LEVELS = (
    (1.0, 1.2, 0.8, 1.1, 0.9, 1.0, 1.0),
    (1.0, -0.2, 0.9, 1.4, 0.1, 0.2, 0.5),
    (0.10, -0.11, 0.12, -0.09, 0.08, -0.13, 0.05),
)


@pytest.mark.parametrize('levels', LEVELS)
def test_the_gain_of_a_fold_is_what_the_mean_of_the_others_removes_of_it(levels):
    own, y = system(), of_levels(*levels)
    s = Fit.make(own, y[:, None]).score(candidate(own, np.ones(len(y))))
    removed, energy = by_hand(y), float(y @ y)
    assert s.gain == pytest.approx(len(y) * y.mean() ** 2, rel=1e-6)
    assert s.amplitude == pytest.approx([y.mean()], rel=1e-6)
    assert s.energy == pytest.approx(removed.sum(), rel=1e-6)
    assert s.cv_gain == pytest.approx(removed.sum() / energy, rel=1e-6)
    spread = np.std(removed, ddof=1) * np.sqrt(FOLDS) / energy
    assert s.cv_se == pytest.approx(spread, rel=1e-6)
    least = (removed.sum() - removed.max()) / energy
    assert s.cv_least == pytest.approx(least, rel=1e-6)


def test_a_fold_is_predicted_at_the_grid_point_that_the_others_choose():
    """A bump in fold 3 explains most of all data, and no other fold: there nothing is gained."""
    own, y = system(), of_levels(*np.full(FOLDS, 0.5))
    bump = np.where(FOLD == 3, 1.0, 0.0)
    y = y + 6.0 * bump
    s = Fit.make(own, y[:, None]).score(candidate(own, np.ones(len(y)), bump))
    assert s.best == 1
    # Fold 3 is predicted by the constant 0.5 of the others; these by a bump that is zero there.
    assert s.energy == pytest.approx(2 * ROWS * (2.0 * 6.5 * 0.5 - 0.5**2), rel=1e-6)


def test_a_nominal_parameter_takes_what_its_bound_allows_before_a_candidate():
    """Of 1.0 the parameter takes 0.25 at no cost: a candidate that is the same gains the rest."""
    ones = np.ones(len(FOLD))
    own = system(ones[:, None, None], bound=0.25)
    fit = Fit.make(own, ones[:, None])
    assert fit.baseline.x == pytest.approx([0.25])
    assert fit.baseline.cost == pytest.approx(0.75**2 * len(ones), rel=1e-6)
    s = fit.score(candidate(own, ones))
    assert s.gain == pytest.approx(0.75**2 * len(ones), rel=1e-6)
    assert s.cv_gain == pytest.approx(1.0, rel=1e-6)


EMPTY = np.zeros((1, 1, 1, 1))
COLUMNS = CandidateColumns(np.array([0]), EMPTY, EMPTY, EMPTY)
SCORE = Score(0, 90.0, np.ones(1), np.ones(1), np.zeros(1), 0.2, 0.1, 0.1, 50.0, np.ones(1))
PASSING = Finding(Spring(), 0, {}, SCORE, COLUMNS, 50.0, floor=0.1)


def scored(**changes):
    return replace(PASSING, score=replace(SCORE, **changes))


def test_what_is_beyond_every_limit_passes_all_gates():
    assert PASSING.judged().failed == ()


@pytest.mark.parametrize(
    ('above', 'below', 'sentence'),
    [
        (scored(cv_gain=0.1001), scored(cv_gain=0.1), 'within the floor of 10.0 %'),
        (PASSING, replace(PASSING, objection='no such mass'), 'no such mass'),
    ],
)
def test_a_gate_passes_just_above_its_limit_and_fails_just_below(above, below, sentence):
    assert above.judged().failed == ()
    (failed,) = below.judged().failed
    assert failed.endswith(sentence)


def test_unknown_evidence_passes_no_gate():
    nan = float('nan')
    assert len(scored(cv_gain=nan).judged().failed) == 1
