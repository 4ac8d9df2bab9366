# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is not known in some rows is taken out as a projection does it."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.regression.rest import Rest
from sosml_friction.regression.row_bases import RowBases


@pytest.mark.parametrize(('kind', 'rounding'), [(np.float64, 1e-14), (np.float32, 1e-6)])
@pytest.mark.parametrize('more', [(), (5,), (3, 2)])
def test_what_a_base_spans_is_taken_out_of_its_rows_in_its_joint_alone(kind, rounding, more):
    rng = np.random.default_rng(1)
    base = np.linalg.qr(rng.normal(size=(8, 3)))[0]
    rests = [Rest(1, slice(4, 12), base), Rest(1, slice(20, 23), None)]
    x = rng.normal(size=(30, 2, *more)).astype(kind)
    expected = x.copy()
    expected[4:12, 1] -= np.tensordot(base @ base.T, x[4:12, 1], 1)
    expected[20:23, 1] = 0.0
    found = RowBases(rests).take_out(x.copy(), [0, 1])
    assert found.dtype == kind
    assert np.abs(found - expected).max() < 10.0 * rounding
    assert RowBases(rests).rank(1) == 3
