# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Columns that are rounding act in no joint."""

from __future__ import annotations

import numpy as np

from sosml_friction.regression.column_norms import joints_acted_in


def test_a_column_acts_where_it_is_more_than_rounding():
    """Backlash of a last joint is 1e-15 in the one before it, and was a column that fits noise."""
    columns = np.zeros((1000, 4, 2))
    assert not len(joints_acted_in(columns))
    columns[:, 3, 1] = np.random.default_rng(0).normal(size=1000)
    columns[:, 2, 0] = 1e-15 * columns[:, 3, 1]
    assert joints_acted_in(columns).tolist() == [3]
    columns[777, 1, 0] = -1e-3
    assert joints_acted_in(columns).tolist() == [1, 3]
    columns[5, 0, 0] = np.nan
    assert joints_acted_in(columns).tolist() == [0, 1, 2, 3]
