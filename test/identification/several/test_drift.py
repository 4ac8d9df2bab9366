# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The change of a parameter per day against closed forms and in repetition."""

import numpy as np
import pytest
from scipy.stats import linregress
from scipy.stats import t as t_distribution

from sosml_friction.identification.several.drift import drift_of

DAY = 86400e9


def test_a_line_without_scatter_is_the_least_squares_line_with_the_stated_errors():
    days = np.array([0.0, 1.0, 4.0, 9.0])
    y = 0.4 + 0.01 * days
    drift = drift_of(days * DAY, y, np.full(4, 0.002))
    assert drift.slope == pytest.approx(0.01)
    error = 0.002 / np.sqrt(np.sum((days - days.mean()) ** 2))
    assert drift.half_width == pytest.approx(t_distribution.ppf(0.975, 2) * error)
    assert drift.scatter == 0.0
    assert drift.is_shown
    assert drift.count == 4


def test_scatter_between_recordings_takes_the_place_of_errors_that_are_too_small():
    days = np.arange(6.0)
    y = np.array([0.4, 0.43, 0.38, 0.42, 0.39, 0.43])
    drift = drift_of(days * DAY, y, np.full(6, 1e-6))
    expected = linregress(days, y)
    assert drift.slope == pytest.approx(expected.slope)
    assert drift.half_width == pytest.approx(
        t_distribution.ppf(0.975, 4) * expected.stderr, rel=1e-6
    )
    assert not drift.is_shown


def test_a_line_is_fitted_in_95_of_100_cases_to_within_its_interval():
    rng, inside = np.random.default_rng(1), 0
    days, errors = np.arange(8.0), np.linspace(0.01, 0.03, 8)
    for _ in range(400):
        y = 0.4 + 0.005 * days + errors * rng.standard_normal(8)
        y += 0.02 * rng.standard_normal(8)
        drift = drift_of(days * DAY, y, errors)
        inside += abs(drift.slope - 0.005) <= drift.half_width
    # Three standard errors of a share of 95 % in 400 cases.
    assert inside / 400 == pytest.approx(0.95, abs=0.033)


@pytest.mark.parametrize(
    ('days', 'errors'), [([0.0, 1.0], [1.0, 1.0]), ([0.0] * 3, [1.0] * 3), ([0, 1, 2], [0, 1, 1])]
)
def test_too_few_recordings_or_one_time_say_nothing(days, errors):
    values = np.ones(len(days))
    assert drift_of(np.array(days) * DAY, values, np.array(errors, dtype=float)) is None


@pytest.mark.parametrize(
    'errors', [[1e-16, 1.0, 1.0, 1.0], [1e-300] * 4, [1e-12, 1e-3, 1e-3, 1e-3]]
)
def test_errors_of_any_sizes_leave_finite_numbers(errors):
    with np.errstate(all='raise'):
        drift = drift_of(np.arange(4) * DAY, np.array([0.4, 0.41, 0.39, 0.4]), np.array(errors))
    assert np.isfinite([drift.slope, drift.half_width, drift.scatter]).all()
    assert not drift.is_shown
