# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from sosml_friction.identification.law.speed_table import SpeedTable, triangle

RNG = np.random.default_rng(5)
#: Velocities over three decades, both ways, and standstill.
V = RNG.choice([-1.0, 1.0], 4000) * np.exp(RNG.uniform(np.log(2e-3), np.log(3.0), 4000))
V[::100] = 0.0


def means(column):
    return column.reshape(100, 40).mean(axis=1)


@pytest.mark.parametrize(
    ('law', 'error'),
    [
        (lambda v: np.sign(v) * np.exp(-np.abs(v) / 0.03), 3e-9),
        (lambda v: np.sign(v) * np.exp(-((v / 0.03) ** 2)), 2e-6),
        (lambda v: np.tanh(v / 0.03), 2e-8),
        (lambda v: np.sign(v), 1e-12),
    ],
)
def test_an_odd_law_is_made_of_what_it_is_at_positive_nodes(law, error):
    table = SpeedTable.of(V, means, 1e-4, one_sided=True)
    assert (table.v > 0.0).all() and table.rows.shape == (100, len(table.v))
    np.testing.assert_allclose(table.rows @ law(table.v), means(law(V)), rtol=0.0, atol=error)


def test_a_law_of_both_directions_is_made_of_nodes_in_both():
    def law(v):
        return np.where(v > 0.0, 1.0, 0.4) * np.exp(-np.abs(v) / 0.03)

    table = SpeedTable.of(V, means, 1e-4, one_sided=False)
    np.testing.assert_allclose(table.rows @ law(table.v), means(law(V)), rtol=0.0, atol=3e-9)


def test_below_the_floor_a_law_is_what_it_is_there():
    table = SpeedTable.of(V, means, 0.1, one_sided=True)
    flat = np.sign(V) * np.exp(-np.maximum(np.abs(V), 0.1) / 0.03)
    np.testing.assert_allclose(
        table.rows @ np.exp(-table.v / 0.03), means(flat), rtol=0.0, atol=3e-9
    )


def test_few_samples_need_no_table():
    assert SpeedTable.of(V[:30], lambda column: column, 1e-4, one_sided=True) is None


def test_a_triangle_of_blocks_has_the_gram_matrix_of_all_rows(monkeypatch):
    monkeypatch.setattr('sosml_friction.identification.law.speed_table._BLOCK', 7)
    a, b = RNG.normal(size=(100, 3)), RNG.normal(size=(100, 2))
    R, X = triangle(a, b), np.column_stack([a, b])
    assert R.shape == (5, 5)
    np.testing.assert_allclose(R.T @ R, X.T @ X, rtol=1e-12)
