# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How large the columns of a regression are, and how much of one is its own."""

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray

#: Share of a column that others must leave of it, or its parameter cannot be told beside theirs.
#: Then its error is a thousand times that beside none. Halved and doubled, no answer of ``python
#: -m validation.sensitivity --seed 1`` changes.
COLLINEAR = 1e-3
#: Share of a column that is rounding, and ridge of columns of norm 1, of which some are collinear:
#: the root of the smallest share of a double, 2e-16, beside which what data tell is large.
ROUNDING = 1e-8


def joints_acted_in(columns: FloatArray) -> IndexArray:
    """
    Return the joints in which any of the columns (N, n, k) is more than rounding, in order.

    What a cause does in one joint, as a body far from it, is a share of what it does in another.
    """
    energy = np.einsum('kij,kij->i', columns, columns)
    return np.flatnonzero(~(energy <= ROUNDING**2 * energy.max()))


def column_norms(X: FloatArray) -> FloatArray:
    """Return the norms of columns (N, P), 1 of those that are 0: what a regression divides by."""
    norms = np.linalg.norm(X, axis=0)
    return np.asarray(np.where(norms == 0.0, 1.0, norms))


def told_beside(column: FloatArray, basis: FloatArray) -> bool:
    """Tell whether a column (N,) is more than a combination of an orthonormal ``basis`` (N, P)."""
    left = column - basis @ (basis.T @ column)
    return float(left @ left) > COLLINEAR**2 * float(column @ column)
