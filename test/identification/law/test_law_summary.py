# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of each parameter of a law holds as it is said."""

from __future__ import annotations

import numpy as np
import pytest
from fitted_law import fit_law

from sosml_friction.identification.law.law_fit import STRIBECK_AT_SLOWEST
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.model.parameter import NOT_IDENTIFIABLE

#: Chance of 95 % intervals: of 20, fewer than 16 hold once in 400.
SETS, HELD = 20, 16


def both_ways(speeds):
    return np.concatenate([speeds, -speeds])


def fits(speeds, friction, noise):
    """Yield fits of friction at speeds in both directions, ten pairs to a cluster."""
    v = both_ways(speeds)
    for seed in range(SETS):
        y = np.sign(v) * friction(np.abs(v)) + noise * np.random.default_rng(seed).normal(
            size=len(v)
        )
        yield fit_law(v, y, np.arange(len(v)) // 10, 'Nm')


def test_the_range_of_extra_friction_holds_what_fades_far_below_the_data():
    """S 2 Nm at a tenth of the slowest speed leaves 0.1 mNm there: most ranges ended below 2."""
    for fit in fits(
        np.geomspace(0.12, 0.62, 100), lambda w: 0.8 + 0.3 * w + 2.0 * np.exp(-w / 0.012), 0.001
    ):
        stribeck = fit.parameters['stribeck']
        assert NOT_IDENTIFIABLE in stribeck.flags
        low, high = stribeck.interval
        assert low <= 2.0 <= high
        # What the data do tell is told at their slowest speed.
        assert fit.derived[STRIBECK_AT_SLOWEST].interval[1] < 0.1


def test_what_other_laws_leave_open_is_no_number():
    """Friction of the third power at one speed within 6 %: B may be 0 as well as its value."""
    for fit in fits(np.linspace(0.715, 0.8, 300), lambda w: 0.5 + 0.5 * w**3, 0.0002):
        viscous = fit.parameters['viscous']
        assert NOT_IDENTIFIABLE in viscous.flags
        assert np.isnan(viscous.value)
        low, high = viscous.interval
        assert low == 0.0
        assert f'is 0 to {high:.3g} Nm s/rad' in viscous.reason


def test_what_is_added_to_the_errors_later_is_judged_as_well():
    (fit, *_) = fits(np.linspace(0.1, 0.8, 100), lambda w: 0.8 + 0.3 * w, 0.01)
    assert not fit.parameters['viscous'].flags
    wide = fit.with_variance({'viscous': 1.0, 'coulomb': 1e-6}).parameters
    assert wide['viscous'].flags == (NOT_IDENTIFIABLE,)
    assert wide['viscous'].interval[0] == 0.0
    assert not wide['coulomb'].flags
    # Nor does what is added still later make one of it.
    wider = (
        fit.with_variance({'viscous': 1.0}).with_variance({'viscous': 1.0}).parameters['viscous']
    )
    assert f'{wider.interval[1]:.3g}' in wider.reason


def test_a_bend_that_no_exponent_makes_is_no_extra_friction_at_standstill():
    """A level that falls below zero: S stands in the place of Coulomb friction."""
    (fit, *_) = fits(
        np.geomspace(0.01, 0.6, 40),
        lambda w: 0.8 * np.exp(-w / 0.1) - 0.05 + 0.9 * w,
        0.005,
    )
    assert fit.parameters['stribeck'].interval == (0.0, np.inf)
    assert fit.derived[STRIBECK_AT_SLOWEST].interval[0] == 0.0
    assert NOT_IDENTIFIABLE in fit.derived[STRIBECK_AT_SLOWEST].flags


@pytest.mark.parametrize('asymmetry', [0.0, 0.3])
def test_a_bias_at_one_speed_is_as_unsure_as_viscous_friction_by_direction_makes_it(asymmetry):
    """B 2.6 -+ 0.3 Nm s/rad at 0.5 rad/s within 10 %: a bias of 0.05 was 0.20 +- 0.001 Nm."""
    v, held = both_ways(np.linspace(0.52, 0.58, 200)), 0
    for seed in range(SETS):
        y = 0.57 * np.sign(v) + 2.6 * v + asymmetry * np.abs(v) + 0.05
        y += 0.005 * np.random.default_rng(seed).normal(size=len(v))
        low, high = fit_law(v, y, np.arange(len(v)) // 10, 'Nm').parameters['bias'].interval
        held += low <= 0.05 <= high
    assert held >= HELD


def test_a_bias_over_many_speeds_is_no_less_sure_for_a_form_that_the_data_refuse():
    """Of symmetric friction: the spread of 20 estimates is known to 16 %, so within 35 %."""
    biases = [
        fit.parameters['bias']
        for fit in fits(np.geomspace(0.05, 0.6, 100), lambda w: 0.8 + 0.3 * w, 0.01)
    ]
    spread = np.std([bias.value for bias in biases], ddof=1)
    assert np.median([bias.std_error for bias in biases]) == pytest.approx(spread, rel=0.35)


def test_extra_friction_at_a_speed_is_no_more_than_all_friction_there():
    """S stood beside a negative C: of 0.96 Nm up to 5.4 were extra friction."""
    for fit in fits(np.linspace(0.5, 2.0, 100), lambda w: 0.8 + 0.3 * w, 0.05):
        extra = fit.derived[STRIBECK_AT_SLOWEST]
        # And its error, of a knee that only the slowest speeds see.
        assert extra.interval[1] < 1.5 * (0.8 + 0.3 * fit.slowest)


def test_extra_friction_that_two_speeds_do_not_tell_is_not_mentioned():
    """Two speeds are a straight line with S of any size: the sentence had no number."""
    fit = next(fits(np.repeat([0.5, 0.6], 50), lambda w: 0.8 + 0.3 * w, 0.01))
    assert NOT_IDENTIFIABLE in fit.parameters['stribeck'].flags
    assert STRIBECK_AT_SLOWEST not in fit.derived


@pytest.mark.parametrize(
    ('v_s', 'noise', 'seed'), [(8e-4, 0.02, 2), (8e-4, 0.02, 3), (1e-3, 0.035, 2)]
)
def test_a_range_of_the_stribeck_velocity_has_the_best_fit_and_the_truth_in_it(v_s, noise, seed):
    """Speeds begin at 1.5 mrad/s: the range, of any exponent, began above the best fit."""
    speeds = (0.0015, 0.002, 0.003, 0.005, 0.008, 0.012, 0.02, 0.03)
    v = np.array([w * way for w in speeds for way in (1, -1)] * 4)
    y = np.sign(v) * (6.0 + 3.0 * np.exp(-np.abs(v) / v_s)) + 45.0 * v
    y += np.random.default_rng(seed).normal(0.0, noise, v.shape)
    each, known = np.arange(len(v)), np.ones(len(v), dtype=bool)
    found = LawRows(v, y, each, known, v, lambda column: column).fit('Nm')
    low, high = found.parameters['stribeck_velocity'].interval
    assert np.isnan(found.parameters['stribeck_velocity'].value)
    assert low <= found.drawn['stribeck_velocity'] <= high
    assert low <= v_s <= high
