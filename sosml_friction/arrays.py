# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The types of arrays: their shapes stand where they are used; the sizes of columns."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
#: Floating-point numbers, of single precision where very many are kept.
ColumnArray = NDArray[Any]
BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.int64]


def column_norms(X: FloatArray) -> FloatArray:
    """Return the norms of columns (N, P), 1 of those that are 0: what a regression divides by."""
    norms = np.linalg.norm(X, axis=0)
    return np.asarray(np.where(norms == 0.0, 1.0, norms))
