# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Few rows and columns stand for many, to rounding."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from sosml_friction.identification.law.law_problem import bounded, spanning, triangle
from sosml_friction.identification.law.law_search import search_law

RNG = np.random.default_rng(5)


def test_a_triangle_of_blocks_has_the_gram_matrix_of_all_rows(monkeypatch):
    monkeypatch.setattr('sosml_friction.identification.law.law_problem.ROWS_AT_ONCE', 7)
    a, b = RNG.normal(size=(100, 3)), RNG.normal(size=(100, 2))
    root = RNG.uniform(0.5, 1.0, 100)
    R, X = triangle(root, a, b), root[:, None] * np.column_stack([a, b])
    assert R.shape == (5, 5)
    np.testing.assert_allclose(R.T @ R, X.T @ X, rtol=1e-12)


def test_many_exponentials_are_combinations_of_a_few_at_speeds_that_were_not_looked_at():
    knees = np.geomspace(1e-3, 1.0, 60)
    speeds, others = np.geomspace(1e-5, 2.0, 200), RNG.uniform(0.0, 2.0, 500)
    columns = np.exp(-speeds[:, None] / knees)
    picked = spanning(columns)
    assert len(picked) < 30
    combination = np.linalg.pinv(columns[:, picked])
    for v_s in (1.7e-3, 0.0433, 0.71):
        made = np.exp(-others[:, None] / knees[picked]) @ combination @ np.exp(-speeds / v_s)
        # What spanning leaves, by column, times how many columns are combined.
        np.testing.assert_allclose(made, np.exp(-others / v_s), rtol=0.0, atol=30 * 1e-8)


def test_columns_of_which_none_is_a_combination_are_all_picked():
    assert sorted(spanning(np.eye(4))) == [0, 1, 2, 3]


def test_reduced_rows_have_the_laws_of_any_power_of_speed_that_all_rows_have():
    v = np.concatenate([np.geomspace(1e-3, 2.0, 400), -np.geomspace(1e-3, 2.0, 400)])
    y = np.sign(v) * (0.4 + 0.3 * np.abs(v) ** 1.3) + 0.01 * RNG.normal(size=len(v))
    search = search_law(v, y, np.arange(len(v)) // 20, lambda column: np.array(column))
    few, whole = search.few, search.problem
    assert len(few.y) < len(y)
    for power in (0.37, 1.3, 2.6):
        for v0 in (0.0, 0.002):
            small = few.bent(power).solve(None, v0, 1.0, few.ones)
            large = whole.bent(power).solve(None, v0, 1.0, search.weights)
            # Columns are made to e = 1e-8 of the largest: sums of squares r^2 to 2 |r| |e|.
            np.testing.assert_allclose(small.theta, large.theta, atol=1e-5)
            e = 1e-8 * np.sqrt(len(y))
            np.testing.assert_allclose(small.cost, large.cost, atol=2.0 * np.sqrt(large.cost) * e)


@given(st.integers(0, 10_000))
def test_a_bounded_solution_is_that_of_scipy(seed):
    """Bounds of 0 and none; the free solution is below none, one or several of them."""
    rng = np.random.default_rng(seed)
    R, moment = rng.normal(size=(12, 4)), rng.normal(size=12)
    lower = np.where(rng.random(4) < 0.7, 0.0, -np.inf)
    free = np.linalg.lstsq(R, moment, rcond=1e-12)[0]
    if (free >= lower).all():
        return
    expected = lsq_linear(R, moment, bounds=(lower, np.inf), method='bvls').x
    np.testing.assert_allclose(bounded(R, moment, lower, free), expected, atol=1e-9)
