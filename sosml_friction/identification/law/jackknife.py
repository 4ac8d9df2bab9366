# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The delete-one-cluster jackknife of a linear least-squares fit, and its intervals."""

import numpy as np
from scipy.stats import t as t_distribution

from sosml_friction.arrays import FloatArray, IndexArray


def jackknife_errors(
    X: FloatArray, residual: FloatArray, groups: IndexArray, weights: FloatArray | None = None
) -> FloatArray:
    """
    Return the delete-one-cluster jackknife standard errors of a linear least-squares fit, (P,).

    :param X: columns of the regression (N, P), of like sizes.
    :param residual: what the fit leaves (N,).
    :param groups: cluster of each row (N,), 0 to the number of clusters - 1, each in use.
    :param weights: of the rows (N,), all 1 if None.
    """
    return np.array(np.sqrt(np.diag(jackknife_covariance(X, residual, groups, weights))))


def jackknife_covariance(
    X: FloatArray, residual: FloatArray, groups: IndexArray, weights: FloatArray | None = None
) -> FloatArray:
    """Return the covariance (P, P) whose roots :func:`jackknife_errors` returns."""
    w = np.ones(len(residual)) if weights is None else weights
    order = np.argsort(groups, kind='stable')
    first = np.append(0, np.flatnonzero(np.diff(groups[order])) + 1)
    X, weighted = X[order], (w[:, None] * X)[order]
    moments = np.add.reduceat(weighted * residual[order, None], first)
    own = np.column_stack(
        [np.add.reduceat(weighted * X[:, [k]], first) for k in range(X.shape[1])]
    )
    own = own.reshape(len(first), X.shape[1], X.shape[1])
    rest = np.linalg.pinv(weighted.T @ X - own, rcond=1e-12, hermitian=True)
    spread = -np.einsum('gij,gj->gi', rest, moments)
    spread = spread - spread.mean(0)
    count = len(first)
    return np.array((count - 1) / count * spread.T @ spread)


def t_95(freedom: int) -> float:
    """Return half of a 95 % interval in standard errors, by Student's t."""
    return float(t_distribution.ppf(0.975, freedom))
