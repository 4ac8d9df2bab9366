# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The delete-one-cluster jackknife of a linear least-squares fit, and its intervals."""

import numpy as np
from scipy.stats import t as t_distribution

from sosml_friction.arrays import FloatArray, IndexArray

#: Share of what all clusters say that is a rounding error: of sums of squares, 1e-8 of a number.
_TOLD = 1e-12


def jackknife_errors(X: FloatArray, residual: FloatArray, groups: IndexArray) -> FloatArray:
    """
    Return the delete-one-cluster jackknife standard errors of a linear least-squares fit, (P,).

    :param X: columns of the regression (N, P), of like sizes.
    :param residual: what the fit leaves (N,).
    :param groups: cluster of each row (N,), 0 to the number of clusters - 1, each in use.
    """
    covariance = jackknife_covariance(X, residual, groups, np.ones(len(residual)))
    return np.array(np.sqrt(np.diag(covariance)))


def jackknife_covariance(
    X: FloatArray, residual: FloatArray, groups: IndexArray, w: FloatArray
) -> FloatArray:
    """Return the covariance (P, P) of a fit with weights ``w`` (N,) of the rows."""
    moments = _sums((w * residual)[:, None] * X, groups)
    own = _products(X, groups, w)
    rest = np.linalg.pinv(own.sum(axis=0) - own, rcond=1e-12, hermitian=True)
    spread = -np.einsum('gij,gj->gi', rest, moments)
    spread = spread - spread.mean(0)
    count = len(own)
    return np.array((count - 1) / count * spread.T @ spread)


def jackknife_freedom(X: FloatArray, groups: IndexArray, w: FloatArray) -> FloatArray:
    """
    Return the degrees of freedom that each of these variances has (P,), 1 or more.

    A variance is a sum of squares, one of each cluster. That of a parameter is known as well as a
    mean of n squares, n = (sum s)^2 / sum s^2 (Satterthwaite), where s, what a cluster adds to
    the sum if all rows are as noisy, is how much less sure the parameter is without it. All
    clusters that say as much leave (clusters - parameters); one that says all leaves 1.
    """
    own = _products(X, groups, w)
    size, axes = np.linalg.eigh(own.sum(axis=0))
    known = size > _TOLD * size[-1]
    axes = axes[:, known] / np.sqrt(size[known])
    # In these axes all clusters together say 1.
    share, ways = np.linalg.eigh(axes.T @ own @ axes)
    lost = share / np.maximum(1.0 - share, _TOLD)
    s = np.sum((axes @ ways) ** 2 * lost[:, None, :], axis=-1)
    # Of one that no cluster tells, such as v_s where S is 0, none says more than another.
    most = s.max(axis=0)
    s = np.divide(s, most, out=np.ones_like(s), where=most > 0.0)
    counting = s.sum(axis=0) ** 2 / np.sum(s**2, axis=0)
    count = len(own)
    return np.maximum(counting * (count - X.shape[1]) / count, 1.0)


def _sums(rows: FloatArray, groups: IndexArray) -> FloatArray:
    """Return the sum of the rows (N, P) of each cluster (G, P)."""
    order = np.argsort(groups, kind='stable')
    first = np.append(0, np.flatnonzero(np.diff(groups[order])) + 1)
    return np.asarray(np.add.reduceat(rows[order], first))


def _products(X: FloatArray, groups: IndexArray, w: FloatArray) -> FloatArray:
    """Return X^T W X of each cluster (G, P, P)."""
    weighted = w[:, None] * X
    each = [_sums(weighted * X[:, [k]], groups) for k in range(X.shape[1])]
    return np.stack(each, axis=1)


def t_95(freedom: float, chance: float = 0.05) -> float:
    """Return half of a 95 % interval in standard errors, by Student's t, or of 1 - chance."""
    return float(t_distribution.ppf(1.0 - 0.5 * chance, freedom))
