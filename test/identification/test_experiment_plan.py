# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Plans of ladders: bounds against published ones and a simulated fit, speeds against all sets."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from fitted_law import TRUTH
from scipy.optimize import curve_fit
from scipy.signal import lfilter

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.experiment_plan import (
    PARAMETERS,
    PlanSettings,
    information,
    ladder_duration,
    plan_experiment,
)
from sosml_friction.model.laws import make_friction_law
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder

T1 = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7)
WANTED = {'coulomb': 0.003, 'stribeck': 0.008, 'stribeck_velocity': 0.001}


def bounds(speeds, level_std):
    covariance = np.linalg.inv(information(speeds, TRUTH, level_std))
    return dict(zip(PARAMETERS, np.sqrt(np.diag(covariance)), strict=True))


def test_information_is_that_of_the_law_by_differences():
    """Against central differences of the law of the package, four plateaus per listed speed."""
    v = np.repeat([*T1, *(-w for w in T1)], 2)

    def level(values):
        return make_friction_law(
            'stribeck', dict(zip(PARAMETERS, values, strict=True)), 0.0
        ).torque(v)

    values = np.array([TRUTH[name] for name in PARAMETERS])
    steps = 1e-6 * np.eye(5)
    columns = [(level(values + h) - level(values - h)) / 2e-6 for h in steps]
    jacobian = np.column_stack(columns)
    wanted = jacobian.T @ jacobian / 0.005**2
    # Central differences: rounding of 1e-16 over 1e-6, and h^2 / 6 of the third derivative.
    found = information(T1, TRUTH, 0.005)
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-8 * found.max())


def test_bounds_are_those_published_for_t1():
    """observer_study, section 5: 5 mNm medians, four per speed from 0.05 to 0.7: sd(S) = 0.093.

    The speeds in between are not printed there: 5 %.
    """
    assert bounds(T1, 0.005)['stribeck'] == pytest.approx(0.093, rel=0.05)


def test_noise_of_a_level_is_that_of_the_mean_of_correlated_noise():
    """4000 plateaus of first-order noise at 1 kHz; their spread is known to 1.1 %, so 4 %."""
    settings = PlanSettings(noise=0.05, correlation_s=0.02, plateau_s=0.5)
    keep = np.exp(-1e-3 / 0.02)
    rng = np.random.default_rng(2)
    white = rng.normal(0.0, 0.05 * np.sqrt(1.0 - keep**2), (4000, 800))
    noise = lfilter([1.0], [1.0, -keep], white, axis=1)[:, 500:]
    assert noise.std() == pytest.approx(0.05, rel=0.02)
    assert settings.level_std == pytest.approx(noise.mean(axis=1).std(), rel=0.04)


def test_a_fit_to_simulated_levels_has_the_standard_errors_of_the_plan():
    """
    600 fits by another solver: standard deviations within 10 %, three times their own 2.9 %.

    The rest is for the fit's curvature, which the bound leaves out.
    """
    settings = PlanSettings(noise=0.05)
    plan = plan_experiment(WANTED, 90.0, TRUTH, settings)
    v = np.repeat([*plan.speeds, *(-w for w in plan.speeds)], 2)

    def law(v, c, b, s, vs, bias):
        return np.sign(v) * (c + s * np.exp(-np.abs(v) / vs)) + b * v + bias

    truth = [TRUTH[name] for name in ('coulomb', 'viscous', 'stribeck')] + [0.03, 0.1]
    rng = np.random.default_rng(4)
    fits = np.array([
        curve_fit(law, v, law(v, *truth) + rng.normal(0.0, plan.level_std, len(v)), truth)[0]
        for _ in range(600)
    ])  # fmt: skip
    bound = [plan.std_errors[name] for name in PARAMETERS]
    np.testing.assert_allclose(fits.std(axis=0), bound, rtol=0.10)
    # No bias beyond a fifth of a standard error; 600 fits know it to a twentieth.
    assert (np.abs(fits.mean(axis=0) - truth) < 0.2 * np.array(bound)).all()


def test_the_duration_is_that_of_the_ladder():
    for speeds in (T1, (0.01, 0.01, 0.02, 0.7, 0.7), (0.02, 2.0)):
        for settings in (PlanSettings(), PlanSettings(plateau_s=2.0, ramp_s=0.5)):
            built = speed_ladder(
                {'a': 0.3}, {'a': 0.3}, speeds, settings.plateau_s, settings.ramp_s
            )
            assert ladder_duration(speeds, settings) == pytest.approx(built.duration)


@pytest.mark.parametrize('wanted', [WANTED, {'coulomb': 1e-4}, {'viscous': 1e-4, 'bias': 1e-4}])
def test_the_speeds_are_as_good_as_the_best_of_all_sets(wanted):
    """Seven speeds of eight candidates: all 3432 ladders; exchange is within 1 % of the best."""
    settings = PlanSettings(candidates=8)
    budget = 50.0
    wanted = {name: 0.01 * error for name, error in wanted.items()}  # never reached
    plan = plan_experiment(wanted, budget, TRUTH, settings)
    assert plan.missed == list(wanted)
    each = np.array([information([w], TRUTH, plan.level_std) for w in settings.speeds])
    chosen = [PARAMETERS.index(name) for name in wanted]
    errors = np.array(list(wanted.values()))
    best = np.inf
    for ladder in itertools.combinations_with_replacement(range(8), len(plan.speeds)):
        if len(set(ladder)) >= 4:
            variances = np.diag(np.linalg.inv(each[list(ladder)].sum(axis=0)))[chosen]
            best = min(best, float(np.max(np.sqrt(variances) / errors)))
    found = max(plan.std_errors[name] / error for name, error in wanted.items())
    assert found <= 1.01 * best
    assert found == pytest.approx(best, rel=0.01)


def test_a_plan_beats_the_usual_ladders_of_the_same_duration():
    """T1 as it is, and speeds evenly apart in the logarithm from 0.01 to 0.7 rad/s."""
    settings = PlanSettings()
    impossible = {name: 1e-6 * error for name, error in WANTED.items()}
    budget = ladder_duration(T1, settings) + 1e-6
    plan = plan_experiment(impossible, budget, TRUTH, settings)
    assert plan.duration_s <= budget
    for usual in (T1, np.geomspace(0.01, 0.7, 6)):
        others = bounds(usual, settings.level_std)
        ratios = [max(e[n] / WANTED[n] for n in WANTED) for e in (plan.std_errors, others)]
        assert ratios[0] < 0.9 * ratios[1]


def test_a_plan_is_no_longer_than_it_has_to_be():
    """It keeps the budget and the wanted errors; what needs longer is told about how long."""
    settings = PlanSettings()
    plan = plan_experiment(WANTED, 120.0, TRUTH, settings)
    assert not plan.missed
    assert plan.needed_s == plan.duration_s <= 120.0
    assert all(plan.std_errors[name] <= error for name, error in WANTED.items())
    shorter = plan_experiment(WANTED, plan.duration_s - 1.0, TRUTH, settings)
    assert shorter.missed
    assert shorter.needed_s == plan.duration_s
    # Beyond an hour by the root of the time: ten times smaller errors take a hundred times longer.
    hard, harder = (
        plan_experiment({'stribeck': error}, 60.0, TRUTH, settings) for error in (1e-4, 1e-5)
    )
    assert harder.needed_s == pytest.approx(100.0 * hard.needed_s, rel=0.01)
    assert hard.needed_s > 3600.0
    assert set(np.round(plan.speeds, 6)) <= {float(f'{w:.4g}') for w in settings.speeds}


@pytest.mark.parametrize('wanted', [{'bias': 5e-4}, {'coulomb': 5e-3}, {'viscous': 0.01}])
def test_a_plan_for_one_parameter_tells_the_others_too(wanted):
    """Every ladder of a length knows the bias alike; other errors are below 10 % of the values."""
    plan = plan_experiment(wanted, 300.0, TRUTH)
    assert not plan.missed
    for name, error in plan.std_errors.items():
        assert error < 0.1 * TRUTH[name]


@pytest.mark.parametrize(
    ('wanted', 'budget', 'assumed', 'words'),
    [
        ({}, 60.0, {}, 'no standard error is wanted'),
        ({'inertia': 1.0}, 60.0, {}, 'inertia=1.0 cannot be used'),
        ({'coulomb': 0.0}, 60.0, {}, 'give a positive number'),
        ({'coulomb': 0.1}, 0.0, {}, 'the budget is 0.0 s'),
        ({'coulomb': 0.1}, 20.0, {}, 'the law needs 4 speeds, and these take 30 s'),
        ({'coulomb': 0.1}, 60.0, {'stribeck_velocity': 0.0}, 'stribeck_velocity is 0.0'),
        ({'coulomb': 0.1}, 60.0, {'viscous': float('nan')}, 'viscous is nan'),
    ],
)
def test_what_cannot_be_planned_is_refused(wanted, budget, assumed, words):
    with pytest.raises(ConfigurationError, match=words):
        plan_experiment(wanted, budget, {**TRUTH, **assumed})


def test_settings_that_cannot_be_are_refused():
    for setting in ({'noise': -1.0}, {'plateau_s': 0.2}, {'slowest': 0.7}, {'candidates': 3}):
        with pytest.raises(ConfigurationError):
            PlanSettings(**setting)
