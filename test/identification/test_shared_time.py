# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Joints share one time, by its weighted mean, unless one very strongly has another."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.identification.shared_time import precision_of, shared_time
from sosml_friction.regression.rival import VERY_STRONG


def test_times_that_agree_are_their_weighted_mean():
    times, errors = np.array([1.0e-3, 1.3e-3, 0.9e-3]), np.array([1e-4, 3e-4, 2e-4])
    mean, precision = shared_time(times, errors**-2)
    assert mean == pytest.approx(np.full(3, np.average(times, weights=errors**-2)))
    assert precision == pytest.approx(np.full(3, np.sum(errors**-2)))


@pytest.mark.parametrize('sign', [-1.0, 1.0])
@pytest.mark.parametrize(('above', 'apart'), [(0.99, False), (1.01, True)])
def test_times_are_apart_beyond_a_very_strong_difference(sign, above, apart):
    """Of two, z^2 = (t_1 - t_2)^2 / (s_1^2 + s_2^2)."""
    errors = np.array([3e-4, 4e-4])
    times = np.array([0.0, sign * np.sqrt(above * VERY_STRONG) * 5e-4])
    found, precision = shared_time(times, errors**-2)
    assert (found[0] != found[1]) == apart
    assert not apart or (np.array_equal(found, times) and np.array_equal(precision, errors**-2))


def test_a_joint_whose_time_is_not_known_has_that_of_the_others():
    found, precision = shared_time(np.array([2e-3, 0.0]), np.array([1e8, 0.0]))
    assert found == pytest.approx([2e-3, 2e-3])
    assert precision == pytest.approx([1e8, 1e8])


def test_one_joint_keeps_its_time_and_nothing_known_stays_so():
    assert shared_time(np.array([3e-3]), np.array([1e6])) == (3e-3, 1e6)
    assert shared_time(np.zeros(2), np.zeros(2))[1].tolist() == [0.0, 0.0]


def test_an_error_that_is_not_known_has_no_precision():
    errors = np.array([2.0, 0.0, np.nan, np.inf])
    assert precision_of(errors).tolist() == [0.25, 0.0, 0.0, 0.0]
