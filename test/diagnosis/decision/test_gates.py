# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Each gate at its limit, the gain of each fold by hand, and floors and null simulations."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.diagnosis.decision import gates, null_recordings
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.gates import candidate_floor, failed_gates
from sosml_friction.model.terms.spring import Spring
from sosml_friction.regression.evidence import (
    CandidateColumns,
    Fit,
    Score,
    System,
    make_blocks,
)
from sosml_friction.regression.settings import DiagnosisSettings

SETTINGS = DiagnosisSettings()
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
SCORE = Score(0, 90.0, np.ones(1), np.ones(1), np.zeros(1), 0.2, 0.1, 50.0, np.ones(1))
PASSING = Finding(Spring(), 0, {}, SCORE, COLUMNS, 50.0, floor=0.1)


def scored(**changes):
    return replace(PASSING, score=replace(SCORE, **changes))


def test_what_is_beyond_every_limit_passes_all_gates():
    assert failed_gates(PASSING) == ()


@pytest.mark.parametrize(
    ('above', 'below', 'sentence'),
    [
        (scored(cv_gain=0.1001), scored(cv_gain=0.1), 'within the floor of 10.0 %'),
        (scored(cv_se=0.2), scored(cv_se=0.2001), 'within its standard error over the folds'),
        (PASSING, replace(PASSING, objection='no such mass'), 'no such mass'),
    ],
)
def test_a_gate_passes_just_above_its_limit_and_fails_just_below(above, below, sentence):
    assert failed_gates(above) == ()
    (failed,) = failed_gates(below)
    assert failed.endswith(sentence)


def test_another_harmonic_of_a_named_cause_may_be_missing_in_some_folds():
    some = scored(cv_se=0.5)
    assert len(failed_gates(some)) == 1
    assert failed_gates(some, known=True) == ()
    assert len(failed_gates(replace(some, floor=0.3), known=True)) == 1


def test_unknown_evidence_passes_no_gate():
    nan = float('nan')
    assert len(failed_gates(scored(cv_gain=nan))) == 1


def floor_of(monkeypatch, targets, settings, grid=1):
    """Return the floor of a constant in one joint whose null simulations are ``targets``."""
    asked = []

    def nulls(laboratory, system, x, beside, seed):
        asked.append(seed)
        yield from (y[:, None] for y in targets)
        raise AssertionError('more null simulations were drawn than the settings say')

    monkeypatch.setattr(gates, 'null_recordings', nulls)
    own = system()
    columns = candidate(own, *[np.ones(len(FOLD))] * grid)
    laboratory = SimpleNamespace(settings=replace(settings, nulls=len(targets)))
    fit = Fit.make(own, targets[0][:, None])
    best = replace(PASSING, columns=candidate(own, np.ones(len(FOLD))))
    floor = candidate_floor(laboratory, fit, best, columns, 2)
    assert asked == [[settings.seed, 2]]
    return floor


def test_the_floor_is_the_stated_multiple_of_the_largest_null(monkeypatch):
    targets = [of_levels(*levels) for levels in LEVELS]
    gains = [by_hand(y).sum() / float(y @ y) for y in targets]
    assert gains[0] == max(gains) > 0.5
    for order in (targets, targets[::-1]):
        floor = floor_of(monkeypatch, order, SETTINGS)
        assert floor == pytest.approx(1.5 * gains[0], rel=1e-6)


def test_a_floor_is_never_below_its_least_and_the_choice_of_a_grid(monkeypatch):
    """Of nulls in which a constant predicts nothing: 0.5 % (1 + ln g)."""
    nothing = [of_levels(*LEVELS[2])]
    assert by_hand(nothing[0]).sum() < 0.0
    for grid in (1, 8):
        floor = floor_of(monkeypatch, nothing, SETTINGS, grid)
        assert floor == pytest.approx(0.005 * (1.0 + np.log(grid)))


def made(monkeypatch, Z, bound, x, seed, variant=None, y=None):
    """Return the endless null simulations of one joint without standstill."""
    shape = (len(Z), 1)
    variant = np.zeros(shape) if variant is None else variant
    monkeypatch.setattr(null_recordings, '_friction_variant', lambda *_: variant)
    laboratory = SimpleNamespace(
        robot=SimpleNamespace(n=1), nominal=SimpleNamespace(bound=bound),
        whitening=SimpleNamespace(standstill=None), y=np.zeros(shape) if y is None else y,
    )  # fmt: skip
    own = System.make(Z, bound, bound, BLOCKS)
    return null_recordings.null_recordings(laboratory, own, x, own, [seed])


def test_null_simulations_draw_bounded_parameters_anew_and_keep_the_others(monkeypatch):
    """
    Uniform within 0.9 of the bound, and white noise of variance 1.

    Columns of norm 1e4 tell each parameter to 1e-4; of 300 draws the largest is within 1 % of
    its end with a probability of 1 - 0.99^300 = 0.95, here of a fixed seed.
    """
    rng = np.random.default_rng(1)
    Z = 1e4 * np.linalg.qr(rng.normal(size=(len(FOLD), 3)))[0][:, None]
    bound, x = np.array([0.5, 2.0, np.inf]), np.array([0.1, 0.1, 7.0])
    drawn = np.array([*islice(made(monkeypatch, Z, bound, x, 3), 300)])[:, :, 0]
    found = drawn @ Z[:, 0] / 1e8
    for k, limit in enumerate((0.45, 1.8)):
        assert 0.98 * limit < found[:, k].max() < limit + 1e-3
        assert -0.98 * limit > found[:, k].min() > -limit - 1e-3
        # Of a uniform distribution: half its width over sqrt(3).
        assert found[:, k].std() == pytest.approx(limit / np.sqrt(3.0), rel=0.1)
    assert found[:, 2] == pytest.approx(7.0, abs=1e-3)
    noise = drawn - found @ Z[:, 0].T
    assert noise.var() * len(FOLD) / (len(FOLD) - 3) == pytest.approx(1.0, abs=0.02)


def test_null_simulations_are_those_of_their_seed(monkeypatch):
    Z, bound = np.ones((len(FOLD), 1, 1)), np.array([1.0])
    one, same, other = (next(made(monkeypatch, Z, bound, np.zeros(1), seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.5


@pytest.mark.parametrize(('shown', 'size'), [(0.0, 0.0), (-0.5, 0.6), (1.0, 1.2), (4.0, 1.5)])
def test_friction_that_turns_around_otherwise_is_as_large_as_the_data_show_it(
    monkeypatch, shown, size
):
    """1.2 times what they show, 1.5 times Coulomb friction at most, less what a column takes."""
    ones, turn = np.ones(len(FOLD)), np.where(FOLD % 2, 30.0, -30.0)
    turn -= turn.mean()
    arguments = ones[:, None, None], np.zeros(1), np.zeros(1), 5
    beyond = turn[:, None]
    without = next(made(monkeypatch, *arguments))
    with_it = next(made(monkeypatch, *arguments, variant=beyond + 11.0, y=shown * beyond + 2.0))
    assert with_it - without == pytest.approx(size * beyond, abs=1e-5)
