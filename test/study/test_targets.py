# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The figures the study has to reach, on noise it was not tuned on.

The short version tunes with fewer evaluations, and runs an observer only where a figure depends on
it; ``make validate`` runs the study as ``sosml study`` does and prints it.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from full_runs import FULL

from sosml_friction.report.common.table import print_table
from sosml_friction.report.study.tables import study_tables
from sosml_friction.study import run
from sosml_friction.study.outcome import is_causal
from sosml_friction.study.run import Study, StudySettings, rmse_mean, run_study

SHORT = StudySettings(
    observers=('linear_second_order', 'sosml'),
    evaluations=64,
    tuning_seeds=1,
    plant_step=200e-6,
)
#: Those that are slow to run, in the condition that they are judged in.
NOISE_ALONE = replace(
    SHORT, observers=('kalman_imm', 'kalman_stribeck', 'smoother'), conditions=('noise',)
)
NOISY = ('slow', 'reversal')


@pytest.fixture(scope='module')
def study() -> Study:
    """Return the study; in short without the Pareto front, which no figure here is of."""
    if FULL:
        result = run_study(StudySettings())
        print_table(study_tables(result))
        return result
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, 'SWEPT', None)
        fast, slow = run_study(SHORT), run_study(NOISE_ALONE)
    return replace(fast, rows=[*fast.rows, *slow.rows])


def rmse(study: Study, motion: str, condition: str, observer: str, tuning: str = 'case') -> float:
    """Return the RMSE of joint 1 [mNm], the mean over the scoring seeds."""
    row = study.row((motion, condition), observer, tuning)
    return 1e3 * rmse_mean(condition, row.scores[0])


def best_causal(study: Study, motion: str, condition: str) -> float:
    rows = [
        r for r in study.rows if (r.motion, r.condition, r.tuning) == (motion, condition, 'case')
    ]
    names = [row.observer for row in rows if is_causal(row.observer)]
    return min(rmse(study, motion, condition, name) for name in names)


def test_there_are_five_seeds_of_noise_that_nothing_was_tuned_on(study):
    assert len(study.settings.scoring) >= 5
    assert not set(study.settings.scoring) & set(study.settings.tuning)


@pytest.mark.parametrize(('motion', 'bar'), [('slow', 0.6), ('reversal', 12.0)])
def test_with_exact_signals_sosml_reaches_the_bar(study, motion, bar):
    """Issue 3, nominal: SOSML and the best causal observer <= 0.6 / 12 mNm."""
    assert rmse(study, motion, 'nominal', 'sosml') <= bar
    assert best_causal(study, motion, 'nominal') <= bar


@pytest.mark.parametrize(
    ('motion', 'linear', 'sosml', 'causal', 'offline'),
    [('slow', 36.0, 38.0, 34.0, 4.0), ('reversal', 245.0, 250.0, 150.0, 28.0)],
)
def test_with_noise_the_bars_are_reached(study, motion, linear, sosml, causal, offline):
    """Issue 3, 16-bit noise; the smoother's in the short version within 25 %: 64 evaluations."""
    assert rmse(study, motion, 'noise', 'linear_second_order') <= linear
    assert rmse(study, motion, 'noise', 'sosml') <= sosml
    assert best_causal(study, motion, 'noise') <= causal
    assert rmse(study, motion, 'noise', 'smoother') <= offline * (1.0 if FULL else 1.25)


@pytest.mark.parametrize(('motion', 'floor'), [('slow', 100.0), ('reversal', 134.0)])
def test_with_a_wrong_model_all_end_at_the_offset_floor(study, motion, floor):
    """
    Issue 3, mismatch: within 1 % of 100 / 134 mNm, or of what an ideal observer has.

    From above; those that are told the law may end below it, as they were tuned on the truth.
    """
    ideal = 1e3 * float(study.floors[motion, 'mismatch'][0])
    assert ideal == pytest.approx(floor, rel=0.02)
    for name in ('linear_second_order', 'sosml'):
        assert rmse(study, motion, 'mismatch', name) <= 1.01 * max(ideal, floor)
    assert best_causal(study, motion, 'mismatch') <= 1.01 * max(ideal, floor)


def test_one_causal_observer_serves_both_motions_with_one_gain_set(study):
    """Issue 3: sum of squares below 245^2 required, slow <= 60 and reversal <= 160 aimed at."""
    for name in ('kalman_imm', 'kalman_stribeck'):
        slow, reversal = (rmse(study, motion, 'noise', name, 'shared') for motion in NOISY)
        assert slow**2 + reversal**2 < 245.0**2, name
        assert slow <= 60.0, name
        assert reversal <= 160.0, name


def test_sosml_is_no_better_than_a_linear_observer_under_noise(study):
    """The study's answer, both ways round: within 10 % on both motions."""
    for motion in NOISY:
        linear = rmse(study, motion, 'noise', 'linear_second_order')
        assert rmse(study, motion, 'noise', 'sosml') == pytest.approx(linear, rel=0.1)
