# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The evidence for a candidate over its grid."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.regression.evidence import CandidateColumns, Fit, System, make_blocks

ROWS = 400


@pytest.mark.parametrize(
    ('within', 'best'),
    [((-np.inf, np.inf), 0), ((0.4, 1.8), 1), ((2.5, 3.0), 0)],
    ids=['any', 'possible at one point', 'possible nowhere'],
)
def test_a_grid_is_asked_where_amplitudes_are_possible(within, best):
    """At point 0 twice the effort explains all with the opposite sign, at 1 it is half of it."""
    rng = np.random.default_rng(1)
    Z = rng.normal(size=(ROWS, 1, 1))
    blocks = make_blocks(ROWS, 4, 2)
    system = System.make(Z, np.full(1, np.inf), np.full(1, np.inf), blocks)
    effort, other = rng.normal(size=(2, ROWS, 1))
    grid = np.stack([-0.5 * effort, effort + other], axis=2)
    columns = CandidateColumns.make(system, np.array([0]), grid[..., None])
    y = effort + 0.01 * rng.normal(size=(ROWS, 1))
    found = Fit.make(system, y).score(columns, within)
    assert found.best == best
    assert found.amplitude == pytest.approx([-2.0, 0.5][best], rel=0.15)
