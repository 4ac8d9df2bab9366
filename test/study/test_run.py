# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The study as a whole: fair, repeatable, and in agreement with the known figures."""

import dataclasses

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.kinds.first_order import FirstOrder
from sosml_friction.study import run as study_run
from sosml_friction.study.condition import Observation, encoder_noise, observe
from sosml_friction.study.run import StudySettings, rmse_mean, run_study
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import StudyTask, run_task


def rmse(study, case, observer, joint=0):
    """Return the mean RMSE in mNm."""
    return 1e3 * rmse_mean(case[1], study.row(case, observer).scores[joint])


@pytest.mark.parametrize(('motion', 'fo', 'sosml'), [('slow', 4.0, 0.6), ('reversal', 60.0, 12.0)])
def test_nominal_errors_are_the_known_ones(tiny_study, motion, fo, sosml):
    """FO with its pole at 300 1/s 4.0 / 60 mNm, SOSML at most 0.6 / 12 (observer study, 3)."""
    case = (motion, 'nominal')
    assert rmse(tiny_study, case, 'first_order_capped') == pytest.approx(fo, rel=0.04)
    gains = tiny_study.row(case, 'first_order_capped').gains
    assert gains['cutoff'][0] == pytest.approx(300.0, rel=0.05)
    assert rmse(tiny_study, case, 'sosml') <= sosml


@pytest.mark.parametrize(('motion', 'known'), [('slow', 208.0), ('reversal', 510.0)])
def test_noisy_errors_of_fo_are_the_known_ones(tiny_study, motion, known):
    """208 / 510 mNm of one seed; 4 % holds its spread and the slightly other inertia."""
    case = (motion, 'noise')
    assert rmse(tiny_study, case, 'first_order_capped') == pytest.approx(known, rel=0.04)
    scores = tiny_study.row(case, 'first_order_capped').scores[0]
    assert len(scores.rmse) == 3
    assert 0.0 < np.std(scores.rmse) < 0.02 * known * 1e-3
    assert rmse(tiny_study, case, 'sosml') < 0.55 * rmse(tiny_study, case, 'first_order_capped')


def test_a_gravity_error_is_a_floor_that_no_gain_removes(tiny_study):
    """100 mNm in slow, 134 in the reversal; both observers within 1 %."""
    for motion, known in (('slow', 100.0), ('reversal', 134.0)):
        case = (motion, 'mismatch')
        floor = 1e3 * tiny_study.floors[case][0]
        assert floor == pytest.approx(known, rel=0.015)
        assert rmse(tiny_study, case, 'sosml') == pytest.approx(floor, rel=0.01)
        assert rmse(tiny_study, case, 'first_order_capped') >= 0.99 * floor
    assert not tiny_study.floors['slow', 'noise'].any()


def test_rows_are_complete_and_shared_gains_are_shared(tiny_study):
    settings = tiny_study.settings
    cases = {(m, c) for m in settings.motions for c in settings.conditions}
    for tuning in ('case', 'shared'):
        rows = [row for row in tiny_study.rows if row.tuning == tuning]
        assert {(row.motion, row.condition) for row in rows} == cases
        assert len(rows) == len(cases) * len(settings.observers)
        gains = [row.gains for row in rows if row.observer == 'sosml']
        assert all(g == gains[0] for g in gains) == (tuning == 'shared')
    noise = encoder_noise(settings.bits)
    told = {
        row.condition: row.gains['position_noise'][0]
        for row in tiny_study.rows
        if (row.observer, row.tuning) == ('kalman', 'case')
    }
    assert told['noise'] == noise
    assert told['nominal'] == told['mismatch'] == 0.01 * noise


def test_gains_of_a_case_are_at_least_as_good_there_as_shared_ones(tiny_study):
    """Of FO, whose search has one dimension and ends in the minimum; seeds differ by 1 %."""
    for motion in ('slow', 'reversal'):
        row = tiny_study.row((motion, 'noise'), 'first_order_capped', 'shared')
        assert rmse(tiny_study, (motion, 'noise'), 'first_order_capped') <= 1.01e3 * rmse_mean(
            'noise', row.scores[0]
        )


def test_an_estimate_is_the_one_that_was_scored(tiny_study):
    row = tiny_study.row(('slow', 'noise'), 'kalman')
    observation = tiny_study.observations['slow', 'noise']
    error = (tiny_study.estimate(row) - observation.friction)[observation.time > 0.5]
    np.testing.assert_array_equal(
        np.sqrt(np.mean(error**2, axis=0)), [score.rmse[0] for score in row.scores]
    )


def test_faster_gains_are_noisier(tiny_study):
    for points in tiny_study.sweeps.values():
        noise = [point.noise_std for point in points]
        assert np.all(np.diff(noise) > 0.0)
        assert points[len(points) // 2].factor == pytest.approx(1.0)
    assert list(tiny_study.sweeps) == list(tiny_study.settings.observers)


def test_noise_of_tuning_is_never_scored():
    for seeds in (1, 5, 100):
        settings = StudySettings(seeds=seeds, tuning_seeds=seeds)
        assert not set(settings.tuning) & set(settings.scoring)
        assert len(settings.scoring) == len(settings.tuning) == seeds


@pytest.fixture(scope='module')
def short_observations(study_arm, study_runs):
    """Return the first 1.5 s of the reversal with two seeds."""
    run = study_runs['reversal']
    log = dataclasses.replace(
        run.log, **{name: getattr(run.log, name)[:1500] for name in ('t_ns', 'q', 'v', 'tau')}
    )
    short = dataclasses.replace(run, log=log, friction=run.friction[:1500])
    return observe(short, study_arm, 'noise', 16, [101, 102])


@pytest.mark.parametrize('name', study_variants())
def test_every_observer_is_tuned_with_the_same_number_of_evaluations(
    short_observations, monkeypatch, name
):
    """Count the runs: gain sets tried times observations of tuning, and those of scoring."""
    runs = []
    estimate = Observation.estimate

    def counted(self, observer):
        runs.append({gain: tuple(values) for gain, values in observer.gains.items()})
        return estimate(self, observer)

    monkeypatch.setattr(Observation, 'estimate', counted)
    case = ('reversal', 'noise')
    task = StudyTask(
        study_variants()[name], [short_observations], {case: short_observations}, 12, 5e-5
    )
    result = run_task(task)
    assert len(runs) == 12 * 2 + 2
    best = result.scores[case][0].rmse
    assert best.shape == (2,)
    assert np.isfinite(best).all()
    assert {k: tuple(v) for k, v in result.gains.items()} == runs[-1]


def test_gains_that_diverge_are_not_chosen(short_observations):
    """The explicit observer, far beyond its limit of stability at half of its range."""
    case = ('reversal', 'noise')
    variant = study_variants()['sosml_explicit']
    task = StudyTask(variant, [short_observations], {case: short_observations}, 24, 5e-5)
    assert np.all(run_task(task).scores[case][0].rmse < 2.0)


def test_the_middle_of_the_search_is_beaten(short_observations):
    variant = study_variants()['first_order']
    task = StudyTask(variant, [short_observations], {}, 16, 5e-5)
    gains = run_task(task).gains
    middle = variant.gains(np.full((2, 1), 0.5), 5e-5)

    def error(values):
        return sum(
            np.mean((o.estimate(FirstOrder(values)) - o.friction)[o.time > 0.5] ** 2, axis=0)
            for o in short_observations
        )

    assert np.all(error(gains) < error(middle))


def test_results_do_not_depend_on_the_number_of_processes():
    settings = StudySettings(
        motions=('slow',),
        conditions=('noise',),
        observers=('first_order', 'linear_second_order'),
        seeds=2,
        tuning_seeds=1,
        evaluations=5,
        plant_step=200e-6,
    )
    shares = []
    one = run_study(settings, 1, lambda what, share: shares.append(share))
    two = run_study(settings, 2)
    assert [row.gains for row in one.rows] == [row.gains for row in two.rows]
    for ours, theirs in zip(one.rows, two.rows, strict=True):
        for a, b in zip(ours.scores, theirs.scores, strict=True):
            np.testing.assert_array_equal(dataclasses.astuple(a)[0], dataclasses.astuple(b)[0])
            np.testing.assert_array_equal(dataclasses.astuple(a)[1:], dataclasses.astuple(b)[1:])
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    # With one motion there is nothing to share gains between, and no reversal no front.
    assert {row.tuning for row in one.rows} == {'case'}
    assert one.sweeps == {}


@pytest.mark.parametrize(
    ('wrong', 'words'),
    [
        ({'motions': ('fast',)}, "motion 'fast' is not in the study: use slow, reversal"),
        ({'conditions': ('rain',)}, "condition 'rain' is not in the study"),
        ({'observers': ('kalmann',)}, "observer 'kalmann' is not in the study"),
        ({'observers': ('sosml', 'sosml')}, 'give each one once'),
        ({'motions': ()}, 'the motions are none'),
        ({'seeds': 0}, 'the number of seeds is 0: use 1 to 100'),
        ({'seeds': 101}, 'the number of seeds is 101'),
        ({'tuning_seeds': 0}, 'the number of tuning seeds is 0'),
        ({'evaluations': 3}, 'the number of evaluations is 3: use 4 to 100000'),
        ({'bits': 7}, 'the number of bits is 7: use 8 to 24'),
    ],
)
def test_settings_that_cannot_be_are_refused(wrong, words):
    with pytest.raises(ConfigurationError) as error:
        StudySettings(**wrong)
    assert words in str(error.value)


def test_every_task_gets_the_same_budget(monkeypatch):
    """Plan a study of everything without running it."""
    seen = []

    def plan_only(pool, function, tasks, done=None):
        if function is study_run.run_task:
            seen.extend(tasks)
            raise KeyboardInterrupt
        return [
            {(name, condition): ([], []) for condition in settings.conditions}
            for name, settings in tasks
        ]

    monkeypatch.setattr(study_run, 'run_all', plan_only)
    with pytest.raises(KeyboardInterrupt):
        run_study(StudySettings(evaluations=77), 1)
    assert {task.evaluations for task in seen} == {77}
    variants = study_variants()
    assert {task.variant.label for task in seen} == {v.label for v in variants.values()}
    # Six cases on their own and the two noisy ones together.
    assert len(seen) == 7 * len(variants)
    assert sorted({len(task.tuned_on) for task in seen}) == [1, 2]
