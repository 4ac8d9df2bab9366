# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Filters of any length leave what they have to leave, up to the ends."""

import numpy as np
import pytest

from sosml_friction.model.finite_differences import convolved


@pytest.mark.parametrize('weights', [31, 201])
@pytest.mark.parametrize('samples', [2, 40, 90, 101, 300])
def test_a_low_pass_leaves_a_constant_however_short(weights, samples):
    taps = np.hanning(weights) / np.hanning(weights).sum()
    x = np.full((samples, 2), 5.0)
    assert convolved(x, taps) == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize('weights', [31, 201])
def test_a_low_pass_leaves_a_line_to_its_ends(weights):
    """Its point reflection at an end is the line itself."""
    taps = np.hanning(weights) / np.hanning(weights).sum()
    x = np.linspace(-1.0, 2.0, 300)
    assert convolved(x, taps) == pytest.approx(x, abs=1e-12)
