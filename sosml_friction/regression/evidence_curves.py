# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Free curves beside a fit, as large as the data say: variances by evidence."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.regression.evidence import AT_BOUND, UNIFORM, Fit
from sosml_friction.regression.kernels import ROWS_AT_ONCE

#: Over how many hats a curve is smooth: the length of its Gaussian kernel. Chosen: two hats bend
#: within a quarter of an axis, where causes of the catalogue have their knees.
SMOOTH = 2.0
#: Exponent of the prior of a curve's size tau, p ~ tau^-4: the explicit "none of these" swallows
#: what has a name where it is weaker (study of 127 recordings).
EXPONENT = 4.0
#: Smallest size of a curve, as a share of the noise: of 1e4 rows it is worth 5 nats, as chance.
LEAST = 0.03
#: When sizes are settled, as a change of their logarithm, and the most rounds until then.
_SETTLED, _MOST_ROUNDS = 0.02, 60
#: Added to the diagonal of the kernel, which is near singular, as a share of it: rounding.
_JITTER = 1e-6


@dataclass(frozen=True)
class Curves:
    """
    Hold what each of some free curves explains beside a fit and all other curves.

    ``energy`` (g,): by which the whitened cost rises without the curve alone; ``left`` (rows, n):
    the whitened residual beside all of them.
    """

    energy: FloatArray
    left: FloatArray


def fit_curves(
    fit: Fit,
    curves: Sequence[tuple[int, FloatArray]],
    told: BoolArray | None = None,
    smooth: float = SMOOTH,
) -> Curves:
    """
    Return what curves explain, each of a size tau_g that the evidence says.

        y = Z x + sum_g D_g d_g + e,  d_g ~ N(0, tau_g^2 K),  K_kl = exp(-(k - l)^2 / 2 l^2),

    D_g scaled so that a curve of size 1 has the energy of the noise. MacKay's updates: with the
    number of its coefficients that the data know, gamma_g, tau_g^2 = d_g' K^-1 d_g / (gamma_g +
    exponent) (D. J. C. MacKay, Bayesian Interpolation, 1992). One below the least is no curve.
    Nominal parameters are anywhere within their bounds alike; those at one stay there.

    :param curves: the joint and the whitened hats (rows, h) of each.
    :param told: rows (rows, n) that say something of curves; None for all.
    :param smooth: l, over how many columns a curve is smooth; 0 for columns of no order, K = 1.
    """
    system, x, y = fit.system, fit.baseline.x, fit.target.y
    free = np.flatnonzero(np.abs(x) < AT_BOUND * system.bound)
    held = np.setdiff1d(np.arange(len(x)), free)
    told = np.ones(y.shape, dtype=bool) if told is None else told
    target = told * (y - system.Z[:, :, held] @ x[held])
    parts = _own(len(free), [hats.shape[1] for _, hats in curves])
    G, r = _normal(system.Z, free, curves, told, target)
    to_hats = []
    for (joint, hats), part in zip(curves, parts, strict=True):
        seen = int((hats.any(axis=1) & told[:, joint]).sum())
        to_hats.append(standard(G[np.ix_(part, part)], seen, smooth))
        G[:, part] = G[:, part] @ to_hats[-1]
        G[part], r[part] = to_hats[-1].T @ G[part], to_hats[-1].T @ r[part]
    prior = system.penalty()[free] - (1.0 - 1.0 / UNIFORM) * system.prior_weight()[free]
    size = np.full(len(parts), 0.1)
    alive = [g for g, part in enumerate(parts) if G[part, part].any()]
    for _ in range(_MOST_ROUNDS):
        kept = np.concatenate([np.arange(len(free)), *(parts[g] for g in alive)])
        own_prior = [np.full(len(parts[g]), size[g] ** -2) for g in alive]
        A = G[np.ix_(kept, kept)] + np.diag(np.concatenate([prior, *own_prior]))
        scale = 1.0 / np.sqrt(np.diag(A))
        inverse = np.linalg.inv(A * scale * scale[:, None]) * scale * scale[:, None]
        mean = inverse @ r[kept]
        before, tried = size.copy(), alive
        own = _own(len(free), [len(parts[g]) for g in tried])
        for g, at in zip(tried, own, strict=True):
            known = len(at) - np.trace(inverse[np.ix_(at, at)]) / size[g] ** 2
            size[g] = np.sqrt(mean[at] @ mean[at] / (known + EXPONENT))
        alive = [g for g in tried if size[g] >= LEAST]
        if alive == tried and np.all(np.abs(np.log(size / before)) < _SETTLED):
            break
    common = np.zeros(len(x))
    common[free] = mean[: len(free)]
    energy, left = np.zeros(len(parts)), target - system.Z @ common
    for g, at in zip(tried, own, strict=True):
        energy[g] = mean[at] @ np.linalg.solve(inverse[np.ix_(at, at)], mean[at])
        joint, hats = curves[g]
        left[:, joint] -= hats @ (to_hats[g] @ mean[at])
    return Curves(energy, told * left)


def _own(first: int, counts: Sequence[int]) -> list[IndexArray]:
    """Return where coefficients of each count are, from ``first`` on."""
    return [np.arange(a, b) for a, b in itertools.pairwise(first + np.cumsum([0, *counts]))]


def standard(products: FloatArray, seen: int, smooth: float = SMOOTH) -> FloatArray:
    """Return the hats' coefficients (h, h) of independent ones of variance 1 that make a curve."""
    k = np.arange(len(products))
    kernel = np.eye(len(k))
    if smooth:
        kernel = np.exp(-0.5 * ((k - k[:, None]) / smooth) ** 2) + _JITTER * kernel
    root = np.linalg.cholesky(kernel)
    energy = float(np.sum(root * (products @ root)))
    return np.asarray(root * np.sqrt(seen / max(energy, np.finfo(float).tiny)))


def _normal(
    Z: FloatArray,
    free: IndexArray,
    curves: Sequence[tuple[int, FloatArray]],
    told: BoolArray,
    target: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return W' W and W' y of Z's free columns and all hats, in blocks of rows for the memory."""
    known = len(free)
    own = _own(known, [hats.shape[1] for _, hats in curves])
    count = known + sum(len(part) for part in own)
    G, r = np.zeros((count, count)), np.zeros(count)
    for i in range(target.shape[1]):
        mine = [g for g, (joint, _) in enumerate(curves) if joint == i]
        at = np.concatenate([np.arange(known), *(own[g] for g in mine)])
        seen = np.flatnonzero(told[:, i])
        for rows in np.split(seen, np.arange(ROWS_AT_ONCE, len(seen), ROWS_AT_ONCE)):
            W = np.concatenate([Z[rows, i][:, free], *(curves[g][1][rows] for g in mine)], axis=1)
            G[np.ix_(at, at)] += W.T @ W
            r[at] += W.T @ target[rows, i]
    return G, r
