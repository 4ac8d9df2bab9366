# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The search: exactly its budget, no more than the cube, each problem for itself."""

import numpy as np
import pytest

from sosml_friction.study.tuning import minimise

CENTRES = np.array([[0.3, 0.8, 0.5], [0.9, 0.1, 0.45]])
SCALES = np.array([1.0, 30.0, 5.0])


def bowl(points):
    return np.sum(SCALES * (points - CENTRES) ** 2, axis=1)


@pytest.mark.parametrize('budget', [4, 5, 16, 37, 150])
@pytest.mark.parametrize('dimensions', [1, 3])
def test_every_problem_takes_exactly_its_evaluations(budget, dimensions):
    seen = []

    def count(points):
        seen.append(points)
        return np.sum((points - 0.4) ** 2, axis=1)

    minimise(count, 2, dimensions, budget)
    assert len(seen) == budget
    assert all(points.shape == (2, dimensions) for points in seen)
    everything = np.array(seen)
    assert everything.min() >= 0.0
    assert everything.max() <= 1.0


def test_it_finds_the_minimum_of_each_problem():
    points, values = minimise(bowl, 2, 3, 150)
    np.testing.assert_allclose(points, CENTRES, atol=0.01)
    np.testing.assert_array_equal(values, bowl(points))


def test_it_finds_a_minimum_on_the_boundary():
    points, _ = minimise(lambda x: np.sum((x - 2.0) ** 2, axis=1), 1, 1, 16)
    assert points[0, 0] == 1.0


def test_problems_do_not_feel_each_other_and_runs_are_the_same():
    both, _ = minimise(bowl, 2, 3, 60)
    again, _ = minimise(bowl, 2, 3, 60)
    np.testing.assert_array_equal(both, again)
    for k in range(2):
        alone, _ = minimise(
            lambda x, k=k: np.sum(SCALES * (x - CENTRES[k]) ** 2, axis=1), 1, 3, 60
        )
        np.testing.assert_array_equal(alone[0], both[k])


def test_values_that_are_not_numbers_are_not_chosen():
    def hole(points):
        values = np.sum((points - 0.6) ** 2, axis=1)
        return np.where(points[:, 0] > 0.7, np.nan, values)

    points, values = minimise(hole, 2, 2, 80)
    np.testing.assert_allclose(points, 0.6, atol=0.02)
    assert np.isfinite(values).all()
    points, values = minimise(lambda x: np.full(len(x), np.nan), 1, 2, 9)
    np.testing.assert_array_equal(points, 0.5)


def test_an_error_of_the_objective_comes_through():
    def fail(points):
        raise KeyError('broken')

    with pytest.raises(KeyError, match='broken'):
        minimise(fail, 3, 2, 10)
