# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where a search of inner parameters ends."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.regression.inner_search import _MOST, _lowest


def test_a_minimum_between_two_equal_costs_is_found():
    """Both corners of the first simplex have the same cost, which alone would end the search."""
    found = _lowest(lambda u: 1e3 * (u[0] - 0.15) ** 2, 1, 0.3)
    # A cost of 0.05 is 7e-3 from the lowest.
    assert found[0] == pytest.approx(0.15, abs=0.02)


def test_what_makes_no_difference_costs_nothing():
    asked = []
    _lowest(lambda u: float(asked.append(1) or 0.0), 2, 0.3)
    assert len(asked) < 6


def test_the_lowest_of_two_parameters_is_found_with_few_evaluations():
    asked = []

    def cost(u):
        asked.append(1)
        return float(200.0 * (u[0] - 0.4) ** 2 + 50.0 * (u[1] + 0.2 + 0.5 * u[0]) ** 2)

    found = _lowest(cost, 2, 0.3)
    assert cost(found) < 0.1
    assert len(asked) <= 2 * _MOST + 1
    assert np.isfinite(found).all()
