# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the columns of a regression are divided by."""

import numpy as np

from sosml_friction.arrays import FloatArray


def column_norms(X: FloatArray) -> FloatArray:
    """Return the norms of columns (N, P), 1 of those that are 0: what a regression divides by."""
    norms = np.linalg.norm(X, axis=0)
    return np.asarray(np.where(norms == 0.0, 1.0, norms))
