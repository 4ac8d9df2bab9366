# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The fit of the law: exact on exact data, and as uncertain as it says on noisy data."""

from __future__ import annotations

import numpy as np
import pytest
from fitted_law import TRUTH, fit_law
from full_runs import FULL, in_full, often
from scipy.stats import binom

from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.jackknife import jackknife_covariance
from sosml_friction.identification.law.law_checks import BEND, KNEE
from sosml_friction.identification.law.law_curve import band, fitted_law
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_profile import LawProfile
from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE

#: A third of v_s to 20 v_s: T1 and T3 of the observer study together.
LOW = np.array([0.01, 0.015, 0.02, 0.03, 0.045, 0.07, 0.12, 0.2, 0.35, 0.6])
#: From 4 v_s up: the knee is not in the data.
HIGH = np.array([0.12, 0.16, 0.22, 0.3, 0.38, 0.46, 0.54, 0.62])
#: Data sets with a knee, and without; ``make validate`` has more.
SETS, PLAIN = (200, 200) if FULL else (60, 40)


def law(v, truth):
    level = truth['coulomb'] + truth['stribeck'] * np.exp(-np.abs(v) / truth['stribeck_velocity'])
    return level * np.sign(v) + truth['viscous'] * v + truth['bias']


def plateaus(speeds):
    """Return each speed in both directions, twice, as a ladder up and down does."""
    return np.concatenate([speeds, -speeds, speeds, -speeds])


def data_sets(speeds, truth, noise, pairs=1, count=SETS):
    """
    Yield (v, y, clusters) with one error per plateau from ``noise(rng, size)``.

    With several pairs per plateau 80 % of the variance is common to a plateau.
    """
    for seed in range(count):
        rng = np.random.default_rng(seed)
        v = plateaus(speeds)
        clusters = np.repeat(np.arange(len(v)), pairs)
        common = noise(rng, len(v))[clusters]
        own = noise(rng, len(clusters))
        error = common if pairs == 1 else np.sqrt(0.8) * common + np.sqrt(0.2) * own
        yield v[clusters], law(v[clusters], truth) + error, clusters


def normal(rng, size):
    return 0.01 * rng.normal(size=size)


def fine(rng, size):
    return 0.3 * normal(rng, size)


def heavy(rng, size):
    """Return Student's t with 2.5 degrees of freedom, and one plateau in 30 quite wrong."""
    wrong = rng.random(size) < 1.0 / 30.0
    return 0.01 * rng.standard_t(2.5, size=size) + wrong * rng.normal(size=size)


def coverage(fits, truth, name):
    """Return how many fits gave an interval for ``name``, and how many of those hold the truth."""
    given = [fit.parameters[name].interval for fit in fits]
    given = [interval for interval in given if interval is not None]
    return len(given), sum(low <= truth[name] <= high for low, high in given)


def assert_covers(fits, truth, names, level=0.95):
    """Judge by what 999 of 1000 correct programs would show, and five points of approximation."""
    for name in names:
        count, hits = coverage(fits, truth, name)
        assert count == len(fits), name
        assert hits >= binom.ppf(0.001, count, level - 0.05), f'{name}: {hits} of {count}'


@pytest.fixture(scope='module')
def stribeck_fits():
    return [fit_law(*data, 'Nm') for data in data_sets(LOW, TRUTH, normal)]


@pytest.fixture(scope='module')
def told_fits():
    """Return the fits of the same sets where the exponent is told."""
    form = LawForm(alpha=1.0)
    return [fit_law(*data, 'Nm', form=form) for data in data_sets(LOW, TRUTH, normal)]


@pytest.fixture(scope='module')
def null_fits():
    truth = {**TRUTH, 'stribeck': 0.0}
    return [fit_law(*data, 'Nm') for data in data_sets(HIGH, truth, normal, count=PLAIN)]


def test_exact_data_with_stribeck_are_recovered():
    """To 1e-6: the one-dimensional search of v_s ends at a relative 1e-8."""
    v = plateaus(LOW)
    fit = fit_law(v, law(v, TRUTH), np.arange(len(v)), 'Nm')
    assert fit.law == 'stribeck'
    for name, value in TRUTH.items():
        assert fit.parameters[name].value == pytest.approx(value, rel=1e-6), name
        assert fit.parameters[name].flags == ()
        assert fit.parameters[name].std_error < 1e-6
    assert fit.residual_std < 1e-8
    assert (fit.pairs, fit.clusters) == (40, 40)


@pytest.mark.parametrize('speeds', [LOW, HIGH])
def test_exact_data_without_stribeck_are_recovered_and_none_is_made_of_rounding(speeds):
    truth = {**TRUTH, 'stribeck': 0.0}
    v = plateaus(speeds)
    fit = fit_law(v, law(v, truth), np.arange(len(v)), 'Nm')
    assert fit.law == 'coulomb_viscous'
    for name in ('coulomb', 'viscous', 'bias'):
        assert fit.parameters[name].value == pytest.approx(truth[name], rel=1e-10), name


def test_units_and_order_of_parameters_follow_the_joint():
    v = plateaus(LOW)
    for unit, viscous, velocity in (('Nm', 'Nm s/rad', 'rad/s'), ('N', 'N s/m', 'm/s')):
        p = fit_law(v, law(v, TRUTH), np.arange(len(v)), unit).parameters
        assert list(p) == ['coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'bias']
        assert [x.unit for x in p.values()] == [unit, viscous, unit, velocity, unit]


def test_intervals_hold_the_truth_as_often_as_they_say_with_stribeck(stribeck_fits, told_fits):
    for fits in (stribeck_fits, told_fits):
        assert all('stribeck' in fit.law for fit in fits)
        assert_covers(fits, TRUTH, TRUTH)
    assert all(fit.law == 'stribeck' for fit in told_fits)


def test_another_exponent_is_found_by_chance_as_seldom_as_its_test_says(stribeck_fits):
    """In 5 % of sets; more than that rate has once in 20."""
    found = sum('exponent' in fit.parameters for fit in stribeck_fits)
    assert found <= binom.ppf(0.95, SETS, 0.05)


@pytest.mark.parametrize('alpha', [in_full(0.7), 1.5, 2.0])
def test_the_exponent_is_found_where_the_data_reach_below_the_knee(alpha):
    truth = {**TRUTH, 'exponent': alpha}
    fits = []
    for seed in range(often(25)):
        rng = np.random.default_rng(seed)
        v = plateaus(LOW)
        y = make_friction_law('coulomb+viscous+stribeck+bias', truth, 0.0).torque(v)
        y = y + 0.2 * normal(rng, len(v))
        fits.append(fit_law(v, y, np.arange(len(v)), 'Nm'))
    assert all('exponent' in fit.parameters for fit in fits)
    assert_covers(fits, truth, truth)


@pytest.mark.parametrize(('alpha', 'is_one'), [(0.5, True), (2.5, True), (0.3, False)])
def test_an_exponent_at_the_end_of_its_range_is_one_and_one_beyond_is_none(alpha, is_one):
    """Friction of 0.5 was said to bend as no exponent makes it, though 0.5 left only noise."""
    truth = {**TRUTH, 'exponent': alpha}
    v = plateaus(np.geomspace(0.002, 0.6, 24))
    x = np.abs(v) / truth['stribeck_velocity']
    y = np.sign(v) * (truth['coulomb'] + truth['stribeck'] * np.exp(-(x**alpha)))
    y += truth['viscous'] * v + truth['bias']
    fits = [
        fit_law(v, y + 0.05 * normal(np.random.default_rng(seed), len(v)), np.arange(len(v)), 'Nm')
        for seed in range(often(6))
    ]
    known = [NOT_IDENTIFIABLE not in fit.parameters['stribeck'].flags for fit in fits]
    assert all(known) if is_one else not any(known)
    if is_one:
        assert_covers(fits, truth, truth)
        assert any(AT_BOUND in fit.parameters['exponent'].flags for fit in fits)


@pytest.mark.parametrize('alpha', [1.0, 2.0])
def test_an_exponent_that_the_data_do_not_show_leaves_size_and_velocity_open(alpha):
    """From 2.3 v_s up a Gaussian knee and an exponential one of another size are one curve."""
    truth, fits = {**TRUTH, 'exponent': alpha}, []
    v = plateaus(LOW[LOW > 0.05])
    for seed in range(often(20)):
        y = make_friction_law('coulomb+viscous+stribeck+bias', truth, 0.0).torque(v)
        y = y + 0.1 * normal(np.random.default_rng(seed), len(v))
        fits.append(fit_law(v, y, np.arange(len(v)), 'Nm'))
    assert all(NOT_IDENTIFIABLE in fit.parameters['stribeck'].flags for fit in fits)
    assert_covers(fits, truth, ('coulomb', 'viscous', 'bias'))
    given = [fit.parameters['stribeck'].interval for fit in fits if 'stribeck' in fit.drawn]
    assert given
    assert all(low <= 0.5 <= high for low, high in given)


def test_standard_errors_are_the_spread_of_the_estimates(told_fits):
    """60 sets know a spread to 9 %; delete-one errors from 40 clusters vary: within 20 %."""
    for name in TRUTH:
        values = np.array([fit.parameters[name].value for fit in told_fits])
        errors = np.array([fit.parameters[name].std_error for fit in told_fits])
        # One that is flagged as not identifiable has neither.
        assert np.isnan(values).sum() <= 0.05 * len(values)
        assert np.nanmedian(errors) == pytest.approx(np.nanstd(values, ddof=1), rel=0.2), name
        # No bias beyond half of a standard error.
        assert abs(np.nanmean(values) - TRUTH[name]) < 0.5 * np.nanstd(values), name


def test_intervals_hold_the_truth_as_often_as_they_say_without_stribeck(null_fits):
    truth = {**TRUTH, 'stribeck': 0.0}
    assert_covers(null_fits, truth, ('coulomb', 'viscous', 'bias'))


def test_stribeck_is_not_invented(null_fits):
    """Named by chance in at most 5 %: more would show once in 20 at exactly that rate."""
    assert sum(fit.law == 'stribeck' for fit in null_fits) <= binom.ppf(0.95, PLAIN, 0.05)


def test_what_one_to_three_plateaus_say_is_hardly_ever_a_stribeck_term():
    """Of 120 sets 1 in 100 at most; 4 with as many degrees of freedom as all plateaus have."""
    truth, shown = {**TRUTH, 'stribeck': 0.0}, 0
    for slow in ([0.03], [0.03, -0.04], [0.02, -0.03, 0.04]):
        speeds = np.concatenate([plateaus(HIGH), plateaus(HIGH), slow])
        for seed in range(often(40)):
            rng = np.random.default_rng(1000 + seed)
            y = law(speeds, truth) + normal(rng, len(speeds))
            fit = fit_law(speeds, y, np.arange(len(speeds)), 'Nm')
            shown += fit.drawn_law == 'stribeck'
    assert shown <= 1


def test_what_is_said_of_absent_stribeck_is_that_it_is_not_identifiable(null_fits):
    for fit in null_fits:
        s, v_s = fit.parameters['stribeck'], fit.parameters['stribeck_velocity']
        assert NOT_IDENTIFIABLE in s.flags or fit.law == 'stribeck'
        if fit.drawn_law == 'coulomb_viscous':
            assert np.isnan(s.value)
            assert np.isnan(v_s.value)
            assert s.interval[0] == 0.0
            assert s.interval[1] > 0.0


def test_noise_shared_within_a_plateau_does_not_count_as_many_measurements():
    """Ten pairs per plateau, 80 % of their variance in common."""
    truth = {**TRUTH, 'stribeck': 0.0}
    fits = [
        fit_law(*data, 'Nm') for data in data_sets(HIGH, truth, normal, pairs=10, count=often(50))
    ]
    assert_covers(fits, truth, ('coulomb', 'viscous', 'bias'))
    assert sum(fit.law == 'stribeck' for fit in fits) <= binom.ppf(0.95, len(fits), 0.05)


def test_heavy_tails_and_gross_errors_widen_the_intervals_but_do_not_move_them():
    truth = {**TRUTH, 'stribeck': 0.0}
    data = list(data_sets(HIGH, truth, heavy, count=often(50)))
    fits = [fit_law(*one, 'Nm') for one in data]
    assert_covers(fits, truth, ('coulomb', 'viscous', 'bias'))
    assert sum(fit.law == 'stribeck' for fit in fits) <= binom.ppf(0.95, len(fits), 0.05)

    def spread_of_least_squares(v, y, clusters):
        X = np.column_stack([np.sign(v), v, np.ones_like(v)])
        return np.linalg.lstsq(X, y, rcond=None)[0][0]

    ours = np.std([fit.parameters['coulomb'].value for fit in fits])
    assert ours < 0.5 * np.std([spread_of_least_squares(*one) for one in data])


def test_stribeck_beyond_the_slowest_plateau_is_flagged_whether_named_or_not():
    """Plateaus from 4 v_s up (S e^-4 = 9 mNm in 10 mNm of noise): only S e^(-v/v_s) is known."""
    fits = [fit_law(*data, 'Nm') for data in data_sets(HIGH, TRUTH, normal, count=often(40))]
    for fit in fits:
        for name in ('stribeck', 'stribeck_velocity'):
            assert NOT_IDENTIFIABLE in fit.parameters[name].flags
        if fit.law == 'stribeck':
            low, high = fit.parameters['stribeck_velocity'].interval
            assert low == 0.0 or high == np.inf


def test_what_is_left_open_for_stribeck_holds_a_knee_too_small_to_be_seen():
    """S 30 mNm at v_s 0.06: at most 4 mNm of it in 10 mNm of noise; v_s above 0.12 / 3."""
    truth = {**TRUTH, 'stribeck': 0.03, 'stribeck_velocity': 0.06}
    fits = [fit_law(*data, 'Nm') for data in data_sets(HIGH, truth, normal, count=often(60))]
    plain = [fit for fit in fits if fit.law == 'coulomb_viscous']
    assert len(plain) > 5 / 6 * len(fits)
    count, hits = coverage(plain, truth, 'stribeck')
    assert hits >= 0.9 * count


def test_a_lag_that_is_known_is_not_taken_for_friction():
    """Any linear filter of the columns: here a mean of the last 0.3 s."""
    t = np.arange(4000) * 0.01
    v = 0.4 * np.sin(t) + 0.1 * np.sin(3.7 * t)
    kernel = np.ones(30) / 30.0
    truth = {**TRUTH, 'stribeck': 0.0}
    y = np.convolve(law(v, truth), kernel)[: len(v)]

    def lag(column):
        return np.convolve(column, kernel)[: len(column)]

    keep = np.arange(len(v)) > 30
    clusters = (t / 0.5).astype(np.int64)
    fit = fit_law(v, y, clusters, 'Nm', lag=lag, keep=keep)
    assert fit.parameters['coulomb'].value == pytest.approx(0.8, rel=1e-9)
    assert fit.parameters['viscous'].value == pytest.approx(0.35, rel=1e-9)
    wrong = fit_law(v, y, clusters, 'Nm', keep=keep)
    assert wrong.parameters['coulomb'].value != pytest.approx(0.8, rel=1e-3)


def test_friction_that_would_be_negative_stays_at_its_bound_and_says_so():
    v = plateaus(HIGH)
    rng = np.random.default_rng(0)
    y = 0.9 * v - 0.05 * np.sign(v) + 0.005 * rng.normal(size=len(v))
    fit = fit_law(v, y, np.arange(len(v)), 'Nm')
    c = fit.parameters['coulomb']
    assert c.value == 0.0
    assert c.flags == (AT_BOUND,)
    assert np.isnan(c.std_error)
    assert c.interval == (0.0, 0.0)
    assert np.isfinite(fit.parameters['viscous'].std_error)
    y = 0.8 * np.sign(v) - 0.3 * v + 0.005 * rng.normal(size=len(v))
    form = LawForm(law='coulomb_viscous')
    b = fit_law(v, y, np.arange(len(v)), 'Nm', form=form).parameters['viscous']
    assert (b.value, b.flags) == (0.0, (AT_BOUND,))


def test_pairs_that_are_not_known_take_no_part():
    v = plateaus(LOW)
    y = law(v, TRUTH)
    clean = fit_law(v, y, np.arange(len(v)), 'Nm')
    v2, y2 = np.append(v, [np.nan, 0.3, 0.1]), np.append(y, [0.5, np.nan, 99.0])
    keep = np.ones(len(v2), dtype=bool)
    keep[-1] = False
    fit = fit_law(v2, y2, np.arange(len(v2)), 'Nm', keep=keep)
    assert fit.pairs == clean.pairs
    for name in TRUTH:
        assert fit.parameters[name].value == pytest.approx(clean.parameters[name].value, rel=1e-6)


@pytest.mark.parametrize(
    ('v', 'clusters', 'words'),
    [
        (np.array([0.1, -0.1, 0.2, -0.2, 0.3]), np.arange(5), 'only 5 separate pieces'),
        (plateaus(LOW), np.zeros(40, dtype=int), 'only 1 separate pieces'),
        (np.array([]), np.array([], dtype=int), 'only 0 separate pieces'),
        (np.abs(plateaus(LOW)), np.arange(40), 'in one direction only'),
        (0.2 * np.sign(plateaus(LOW)), np.arange(40), r'at one speed only \(0.2\)'),
    ],
)
def test_motion_that_cannot_answer_is_refused_in_one_sentence(v, clusters, words):
    with pytest.raises(DataError, match=words) as caught:
        fit_law(v, law(v, TRUTH), clusters, 'Nm')
    assert '\n' not in str(caught.value)


def test_six_pairs_are_fitted_with_wide_intervals():
    v = np.array([0.1, -0.1, 0.3, -0.3, 0.6, -0.6])
    y = law(v, {**TRUTH, 'stribeck': 0.0}) + 0.01 * np.array([1, -1, -1, 1, 0.5, 0.2])
    fit = fit_law(v, y, np.arange(6), 'Nm')
    low, high = fit.parameters['coulomb'].interval
    assert low < 0.8 < high
    assert high - low > 0.02


def test_relative_error_and_residual_are_of_the_pairs_fitted():
    v = plateaus(HIGH)
    y = law(v, {**TRUTH, 'stribeck': 0.0}) + 0.01 * np.random.default_rng(3).normal(size=len(v))
    fit = fit_law(v, y, np.arange(len(v)), 'Nm')
    p = {name: fit.parameters[name].value for name in ('coulomb', 'viscous', 'bias')}
    residual = y - (p['coulomb'] * np.sign(v) + p['viscous'] * v + p['bias'])
    assert fit.residual_std == pytest.approx(np.sqrt(np.mean(residual**2)), rel=1e-9)
    expected = 100.0 * np.linalg.norm(residual) / np.linalg.norm(y)
    assert fit.relative_error == pytest.approx(expected, rel=1e-9)


def test_the_jackknife_is_that_of_refits_without_one_cluster():
    rng = np.random.default_rng(5)
    X, weights = rng.normal(size=(60, 3)), rng.uniform(0.2, 1.0, 60)
    groups = np.repeat(np.arange(12), 5)
    y = X @ [1.0, -2.0, 0.5] + rng.normal(size=12)[groups] + rng.normal(size=60)

    def solve(rows):
        root = np.sqrt(weights[rows])
        return np.linalg.lstsq(X[rows] * root[:, None], y[rows] * root, rcond=None)[0]

    whole = solve(np.full(60, True))
    refits = np.array([solve(groups != g) for g in range(12)])
    expected = np.sqrt(11.0 / 12.0 * np.sum((refits - refits.mean(0)) ** 2, axis=0))
    errors = np.sqrt(np.diag(jackknife_covariance(X, y - X @ whole, groups, weights)))
    np.testing.assert_allclose(errors, expected, rtol=1e-9)


@pytest.mark.parametrize('smoothing_velocity', [0.0, 0.005])
def test_pairs_may_be_means_of_many_samples(smoothing_velocity):
    """Means over a stretch in which velocity changes: exact, where the mean velocity is not."""
    v = np.repeat(plateaus(LOW), 50) * np.tile(np.linspace(0.5, 1.5, 50), 4 * len(LOW))
    sign = np.sign(v) if smoothing_velocity == 0.0 else np.tanh(v / smoothing_velocity)
    level = TRUTH['coulomb'] + TRUTH['stribeck'] * np.exp(-np.abs(v) / TRUTH['stribeck_velocity'])

    def means(column):
        return column.reshape(-1, 50).mean(axis=1)

    y = means(level * sign + TRUTH['viscous'] * v + TRUTH['bias'])
    fit = fit_law(
        v,
        y,
        np.arange(len(y)),
        'Nm',
        lag=means,
        smoothing_velocity=smoothing_velocity,
        mean_v=means(v),
    )
    for name, truth in TRUTH.items():
        assert fit.parameters[name].value == pytest.approx(truth, rel=1e-5)
    assert fit.smoothing_velocity == smoothing_velocity


@pytest.mark.parametrize(('forwards', 'kept'), [(-1.0, False), (2.0, True)])
def test_a_stribeck_term_below_the_data_is_kept_only_if_it_is_friction_both_ways(forwards, kept):
    """
    EMPS, fitted with asymmetry: the slowest plateaus are off the line by what is no knee.

    At the slowest speed only, friction is ``forwards`` off the line that way and 3 N more
    backwards: exp(-|v| / v_s) of a v_s far below it fits that whatever the signs.
    """
    speeds = np.array([0.042, 0.06, 0.083, 0.1, 0.125])
    v = plateaus(speeds)
    y = 20.0 * np.sign(v) + 200.0 * v - 40.0 * np.abs(v)
    slow = np.abs(v) < 0.05
    y[slow] += np.where(v[slow] > 0.0, forwards, -3.0)
    y += np.random.default_rng(0).normal(0.0, 0.05, v.shape)
    fit = fit_law(v, y, np.arange(len(v)), 'N', form=LawForm('auto', symmetric=False))
    assert ('stribeck' in fit.drawn) == kept
    assert (NOT_IDENTIFIABLE in fit.parameters['coulomb'].flags) <= kept


def test_a_knee_in_the_place_of_coulomb_friction_makes_all_of_them_ranges():
    """The level falls to below zero: the best fit has C = 0, which is not how friction is."""
    v = plateaus(LOW)
    rng = np.random.default_rng(1)
    level = 0.8 * np.exp(-np.abs(v) / 0.1) - 0.05
    y = level * np.sign(v) + 0.9 * v + 0.005 * rng.normal(size=len(v))
    fit = fit_law(v, y, np.arange(len(v)), 'Nm')
    c = fit.parameters['coulomb']
    assert 'stribeck' in fit.drawn
    assert fit.law == 'coulomb_viscous'
    assert c.flags == (AT_BOUND, NOT_IDENTIFIABLE)
    assert c.interval[0] == 0.0
    assert c.interval[1] >= fit.drawn['stribeck']
    for name in ('coulomb', 'stribeck', 'stribeck_velocity'):
        assert np.isnan(fit.parameters[name].value)
        assert 'no Coulomb friction' in fit.parameters[name].reason


@pytest.mark.parametrize('stribeck', [0.0, 0.5])
@pytest.mark.parametrize(('effort', 'speed'), [(100.0, 1.0), (1.0, 0.01), (1e-3, 1e3)])
def test_other_units_give_the_same_numbers(stribeck, effort, speed):
    """To a thousandth of a standard error, which is where the searches end."""
    units = {'viscous': effort / speed, 'stribeck_velocity': speed}
    for v, y, groups in data_sets(LOW, {**TRUTH, 'stribeck': stribeck}, normal, count=4):
        one = fit_law(v, y, groups, 'Nm')
        other = fit_law(speed * v, effort * y, groups, 'Nm')
        assert one.law == other.law
        for name, p in one.parameters.items():
            q, unit = other.parameters[name], units.get(name, effort)
            assert q.flags == p.flags
            if not np.isnan(p.value):
                assert abs(q.value / unit - p.value) < 1e-3 * p.std_error, name
                assert q.std_error / unit == pytest.approx(p.std_error, rel=1e-3), name


def test_coulomb_and_viscous_hold_the_truth_where_a_knee_shows_but_is_not_known():
    """S 30 mNm in 10 mNm of noise: v_s may be anything, and C and B go with it."""
    truth = {**TRUTH, 'stribeck': 0.03}
    fits = [fit_law(*data, 'Nm') for data in data_sets(LOW, truth, normal, count=often(50))]
    shown = [fit for fit in fits if fit.drawn_law == 'stribeck' and fit.law != 'stribeck']
    assert len(shown) > 0.6 * len(fits)
    assert_covers(shown, truth, ('coulomb', 'viscous'))
    widths = []
    for fit in shown:
        low, high = fit.parameters['coulomb'].interval
        k = fit.covariance_of.index('coulomb')
        widths.append((high - low) / (4.0 * np.sqrt(fit.covariance[k, k])))
    # Wider than the jackknife at the best fit, which does not know of the other v_s.
    assert np.quantile(widths, 0.8) > 1.5


def test_a_profile_that_is_closed_by_little_is_open_at_more():
    u = np.linspace(-3.0, 3.0, 61)
    excess = np.where(u < 0.0, np.minimum(u**2, 1.5), u**2)
    profile = LawProfile(np.exp(u), excess, *np.ones((3, 61)))
    assert profile.velocity_interval() == pytest.approx((np.exp(-1.0), np.exp(1.0)), rel=1e-9)
    assert profile.velocity_interval(2.25) == pytest.approx((0.0, np.exp(1.5)), rel=1e-9)


@pytest.mark.parametrize('find', [False, True])
def test_rows_at_rest_do_not_stop_the_search_and_are_no_slowest_speed(find):
    v, y, clusters = next(data_sets(LOW, TRUTH, normal, 30, 1))
    v[::9] = 0.0
    with np.errstate(divide='raise', invalid='raise'):
        fit = fit_law(v, y, clusters, 'Nm', smoothing_velocity=None if find else 0.0)
    assert 0.005 < fit.slowest < 0.02


def test_a_term_that_the_test_refused_may_be_nothing_at_the_slowest_speed():
    # A sign that is smoothed and a large S are as one at the slowest speeds.
    for seed in range(8):
        rng = np.random.default_rng(seed)
        v = np.repeat(plateaus(LOW), 30)
        y = np.sign(v) + 0.5 * v + 0.02 * rng.standard_normal(len(v))
        fit = fit_law(v, y, np.arange(len(v)) // 30, 'Nm', smoothing_velocity=None)
        if fit.drawn_law == 'coulomb_viscous':
            assert fit.derived['stribeck_at_slowest'].interval[0] == 0.0
            assert fit.derived['stribeck_at_slowest'].flags == (NOT_IDENTIFIABLE,)


def test_a_smoother_sign_that_the_data_do_not_show_is_in_the_errors():
    """
    A test of v0 that fails leaves the sign itself, and S too low.

    Of those fits here 12 of 17 hold S; 6 of 17 did when v0 was then taken as known.
    """
    v, v0, held = plateaus(LOW), 0.005, []
    clusters = np.arange(len(v))
    for seed in range(500, 500 + often(40)):
        y = law(np.abs(v), {**TRUTH, 'viscous': 0.0, 'bias': 0.0}) * np.tanh(v / v0)
        y += TRUTH['viscous'] * v + TRUTH['bias'] + normal(np.random.default_rng(seed), len(v)) * 2
        fit = fit_law(v, y, clusters, 'Nm', smoothing_velocity=None)
        if fit.smoothing_velocity == 0.0:
            low, high = fit.parameters['stribeck'].interval
            held.append(low <= TRUTH['stribeck'] <= high)
    print(f'S: {sum(held)} of {len(held)} hold')
    assert len(held) > often(40) // 4
    assert sum(held) > 0.5 * len(held)


@pytest.mark.parametrize('width', [0.03, 0.05])
def test_a_sign_that_is_wider_than_the_slowest_speeds_is_found(width):
    """Friction begins at a third to a fifth of the width; the search ended at twice the first."""
    rng = np.random.default_rng(4)
    v = plateaus(LOW)
    y = 0.5 * np.tanh(v / width) + 0.2 * v + 0.005 * rng.normal(size=v.shape)
    fit = fit_law(v, y, np.arange(len(v)), 'Nm', smoothing_velocity=None)
    assert fit.smoothing_velocity == pytest.approx(width, rel=0.1)
    for name, truth in (('coulomb', 0.5), ('viscous', 0.2)):
        low, high = fit.parameters[name].interval
        assert truth - 0.1 < low < truth < high < truth + 0.1
        assert NOT_IDENTIFIABLE not in fit.parameters[name].flags


def test_a_knee_that_the_data_do_not_show_is_in_the_errors():
    """
    A test of S that fails leaves it out, and C and B make up for it.

    Of 40 fits here, none with an S, 38 hold C; 22 did when the law without S was then sure.
    """
    truth, held = {**TRUTH, 'stribeck': 0.03}, []
    for v, y, clusters in data_sets(
        LOW, truth, lambda rng, n: 2.0 * normal(rng, n), count=often(40)
    ):
        fit = fit_law(v, y, clusters, 'Nm')
        if not np.isfinite(fit.parameters['stribeck'].value):
            low, high = fit.parameters['coulomb'].interval
            held.append(low <= truth['coulomb'] <= high)
    print(f'C: {sum(held)} of {len(held)} hold')
    assert len(held) > 0.75 * often(40)
    assert sum(held) >= 0.8 * len(held)


def test_a_broad_knee_is_within_the_errors_and_told():
    """No exponential falls as 1 / (1 + (v / v_s)^2): C, B and S are off by its tail."""
    truth, speeds = {**TRUTH, 'stribeck_velocity': 0.08}, np.geomspace(0.01, 0.6, 20)
    fits = [
        fit_law(v, y + broad_excess(v, truth), clusters, 'Nm')
        for v, y, clusters in data_sets(speeds, truth, fine, count=often(50))
    ]
    for name in ('coulomb', 'viscous', 'stribeck'):
        held = sum(low <= truth[name] <= high for low, high in intervals(fits, name))
        print(f'broad knee, {name}: {held} of {len(fits)} intervals hold')
        assert held >= binom.ppf(0.001, len(fits), 0.90), name
    told = [check for fit in fits for check in fit.checks if check.name == KNEE]
    assert len(told) >= 0.9 * len(fits)


def test_the_broad_knee_counts_for_little_where_friction_is_exponential(stribeck_fits, told_fits):
    """Told, the exponent leaves it out. What is found of it by chance makes few errors larger."""
    told = sum(check.name == KNEE for fit in stribeck_fits for check in fit.checks)
    assert told <= binom.ppf(0.95, SETS, 0.05)
    assert not any(check.name == KNEE for fit in told_fits for check in fit.checks)


def broad_excess(v, truth):
    """Return what friction with a broad knee has above that with an exponential one."""
    x = np.abs(v) / truth['stribeck_velocity']
    return truth['stribeck'] * np.sign(v) * (1.0 / (1.0 + x**2) - np.exp(-x))


def intervals(fits, name):
    return [fit.parameters[name].interval for fit in fits]


@pytest.mark.parametrize(
    'bends', [lambda v: 0.5 * np.sqrt(v), lambda v: 0.5 * np.tanh(v / 0.2), lambda v: 0.8 * v**2]
)
def test_friction_that_bends_otherwise_is_told_and_within_the_errors(bends):
    """Law (9) is a straight line. Its band then holds friction all the same."""
    speeds = np.geomspace(0.01, 0.6, 20)
    v, at = plateaus(speeds), np.geomspace(0.01, 0.6, 50)
    shares = []
    for seed in range(often(20)):
        y = np.sign(v) * (0.8 + bends(np.abs(v))) + fine(np.random.default_rng(seed), len(v))
        fit = fit_law(v, y, np.arange(len(v)), 'Nm', form=LawForm('coulomb_viscous'))
        (told,) = (check for check in fit.checks if check.name == BEND)
        assert not told.passed
        wrong = np.abs(fitted_law(fit).torque(at) - 0.8 - bends(at))
        shares.append((wrong <= band(fit, at)).mean())
        assert shares[-1] >= 0.95
        low, high = fit.parameters['coulomb'].interval
        assert low <= 0.8 <= high
    print(f'friction that bends: the band holds it at {np.mean(shares):.3f} of the speeds')


@pytest.mark.parametrize(('drag', 'noise'), [(0.05, 0.0004), (0.3, 0.002)])
def test_drag_is_told_as_a_bend_and_is_no_knee(drag, noise):
    """A Stribeck term as wide as all speeds and more B stood for it: B .42 of .2, C .16 of .5."""
    v = plateaus(np.repeat([0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5], 6))
    for seed in range(4):
        y = np.sign(v) * (0.5 + drag * v**2) + 0.2 * v
        y += noise * np.random.default_rng(seed).normal(size=len(v))
        fit = fit_law(v, y, np.arange(len(v)), 'Nm')
        assert 'stribeck' not in fit.drawn
        assert fit.law == 'coulomb+viscous+bias+nonlinear_viscous'
        (told,) = (check for check in fit.checks if check.name == BEND)
        assert '|v|^' in told.sentence
        assert '--terms coulomb,viscous,bias,nonlinear_viscous ' in told.sentence
        truths = {'coulomb': 0.5, 'viscous': 0.2, 'stribeck': 0.0, 'nonlinear_viscous': drag}
        truths['power'] = 2.0
        for name, truth in truths.items():
            low, high = fit.parameters[name].interval
            assert low <= truth <= high, name
        for name in ('coulomb', 'viscous', 'nonlinear_viscous'):
            assert not fit.parameters[name].flags, name
        assert NOT_IDENTIFIABLE in fit.parameters['stribeck'].flags


@pytest.mark.parametrize('power', [0.5, 0.66])
def test_a_sign_as_wide_as_a_knee_is_a_bend_and_no_knee(power):
    """
    Both together bend as friction of less power than 1 does, far above standstill.

    S was 11 +- 2 Nm, a number, where friction is 3.4 to 5 Nm. The power is found instead.
    """
    speeds = np.linspace(0.96, 4.85, 300)
    v, at = np.concatenate([speeds, -speeds]), np.linspace(0.96, 4.85, 25)
    truth = 3.0 + 0.75 * at**power
    for seed in range(3):
        y = np.sign(v) * (3.0 + 0.75 * np.abs(v) ** power)
        y += 0.007 * np.random.default_rng(seed).standard_normal(len(v))
        fit = fit_law(v, y, np.arange(len(v)) // 10, 'Nm', smoothing_velocity=None)
        for name in ('stribeck', 'stribeck_velocity'):
            assert NOT_IDENTIFIABLE in fit.parameters[name].flags
        wrong = np.abs(fitted_law(fit).torque(at) - truth)
        # At all speeds, of four numbers: sqrt(chi2(4)) at 95 % is 1.6 times 1.96; and seeds.
        assert (wrong <= 2.0 * band(fit, at)).all()


def test_coulomb_friction_below_a_bend_upwards_is_friction_at_standstill():
    """Friction of more power than 1, with a knee in the place of Coulomb friction: 0 to 3.1 Nm."""
    speeds = np.linspace(0.96, 4.85, 300)
    v = np.concatenate([speeds, -speeds])
    y = np.sign(v) * (3.0 + 0.3 * np.abs(v) ** 1.6)
    y += 0.007 * np.random.default_rng(0).standard_normal(len(v))
    fit = fit_law(v, y, np.arange(len(v)) // 10, 'Nm', smoothing_velocity=None)
    coulomb = fit.parameters['coulomb']
    assert not coulomb.flags
    assert coulomb.value == pytest.approx(3.0, rel=0.02)
    assert coulomb.interval[0] <= 3.0 <= coulomb.interval[1]


@pytest.mark.parametrize('power', [1.7, 2.0])
def test_no_knee_stands_for_coulomb_friction_below_friction_that_bends_upwards(power):
    """C 1.2 Nm was 0 to 2.3, as extra friction near standstill that never fades."""
    speeds, held = np.repeat(np.geomspace(0.02, 1.0, 8), 12), 0
    for seed in range(often(8)):
        rng = np.random.default_rng(seed)
        v = plateaus(speeds * np.exp(0.05 * rng.standard_normal(len(speeds))))
        y = np.sign(v) * (1.2 + 0.1 * np.abs(v) + 0.4 * np.abs(v) ** power)
        y += 0.006 * rng.standard_normal(len(v))
        fit = fit_law(v, y, np.arange(len(v)) // 4, 'Nm')
        assert 'nonlinear_viscous' in fit.law
        for name, truth in (('coulomb', 1.2), ('viscous', 0.1), ('power', power)):
            low, high = fit.parameters[name].interval
            assert not fit.parameters[name].flags, name
            held += low <= truth <= high
        assert fit.parameters['coulomb'].std_error < 0.02
    assert held >= binom.ppf(0.01, 3 * often(8), 0.95)


def test_a_wide_knee_that_fades_is_no_power_of_speed():
    """Its v_s is a fifth and more of the fastest speed: C and B are those far above it."""
    speeds = np.linspace(0.1, 1.5, 120)
    v = plateaus(speeds)
    for v_s in (0.2, 0.4):
        y = np.sign(v) * (1.2 + 0.3 * np.exp(-np.abs(v) / v_s)) + 0.3 * v
        y += 0.006 * np.random.default_rng(4).standard_normal(len(v))
        fit = fit_law(v, y, np.arange(len(v)) // 4, 'Nm')
        assert fit.law == 'stribeck'
        for name, truth in (('coulomb', 1.2), ('viscous', 0.3)):
            low, high = fit.parameters[name].interval
            assert low <= truth <= high, name


def both_ways(speeds):
    return np.concatenate([speeds, -speeds])


@pytest.mark.parametrize('seed', [3, 4])
def test_a_sign_and_a_knee_that_are_one_bend_are_no_law(seed):
    """Half a percent less friction at one speed: a sign of .2 rad/s with S 4 Nm, C +- .3 Nm."""
    rng = np.random.default_rng(seed)
    speeds = np.concatenate([np.repeat([0.3, 0.6, 1.0], 40), rng.uniform(0.2, 1.0, 40)])
    v = both_ways(speeds * np.exp(0.01 * rng.standard_normal(len(speeds))))
    less = 0.006 * np.exp(-(((np.abs(v) - 0.45) / 0.08) ** 2))
    y = np.sign(v) * (1.2 - less) + 0.3 * v + 0.004 * rng.standard_normal(len(v))
    fit = fit_law(v, y, np.arange(len(v)) // 4, 'Nm', smoothing_velocity=None)
    assert fit.smoothing_velocity == 0.0
    assert 'stribeck' not in fit.drawn
    for name, truth in (('coulomb', 1.2), ('viscous', 0.3)):
        found = fit.parameters[name]
        assert found.value == pytest.approx(truth, abs=0.003)
        assert found.interval[0] <= truth <= found.interval[1]
        assert found.std_error < 0.02


def test_friction_that_differs_by_direction_is_no_knee():
    """Seldom fast backwards, B .3 +- .08 by direction: C was 0 to 8 Nm beside a knee."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        speeds = np.concatenate([np.repeat([0.3, 0.6, 1.0], 40), rng.uniform(0.2, 1.0, 40)])
        v = both_ways(speeds * np.exp(0.01 * rng.standard_normal(len(speeds))))
        v = v[(v > 0.0) | (np.abs(v) < 0.8) | (np.arange(len(v)) % 3 == 0)]
        y = 1.2 * np.sign(v) + 0.3 * v + 0.08 * np.abs(v) + 0.004 * rng.standard_normal(len(v))
        fit = fit_law(v, y, np.arange(len(v)) // 4, 'Nm', smoothing_velocity=None)
        assert 'stribeck' not in fit.drawn
        for name, truth in (('coulomb', 1.2), ('viscous', 0.3)):
            found = fit.parameters[name]
            assert not found.flags, name
            assert found.interval[0] <= truth <= found.interval[1]
        assert not all(check.passed for check in fit.checks)


@pytest.mark.parametrize('seed', [1, 11])
def test_coulomb_friction_is_not_less_by_a_knee_that_fades_beyond_the_data(seed):
    """Extra friction as wide as all speeds is Coulomb friction: C .35 was .15 to .36 Nm."""
    v = both_ways(np.linspace(0.2, 2.4, 500))
    y = np.sign(v) * (0.35 + 0.15 * np.exp(-np.abs(v) / 0.12)) + 0.12 * v
    y += 0.045 * np.random.default_rng(seed).standard_normal(len(v))
    fit = fit_law(v, y, np.arange(len(v)) // 25, 'Nm')
    assert NOT_IDENTIFIABLE in fit.parameters['stribeck_velocity'].flags
    low, high = fit.parameters['coulomb'].interval
    assert 0.25 < low <= 0.35 <= high
    low, high = fit.parameters['viscous'].interval
    assert low <= 0.12 <= high < 0.16


def test_a_law_that_is_true_bends_as_friction_does(stribeck_fits, null_fits):
    """In 1 % of the sets another is found by chance; more than that rate has once in 20."""
    for fits in (stribeck_fits, null_fits):
        told = sum(check.name == BEND for fit in fits for check in fit.checks)
        assert told <= binom.ppf(0.95, len(fits), 0.01)
