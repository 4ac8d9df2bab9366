# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The rows of several recordings as one regression, each weighted by what it knows."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag
from scipy.sparse import csr_array

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.kinds.fading_term import fade

#: Rows are joined to means if as many neighbours or more share their noise. Chosen, no
#: measurement.
_JOINED = 4.0
#: Exponentials of the curve, without a law, that is taken off to see the noise.
_MOST_EXPONENTIALS = 4
_CLIP = 4.0


#: The parameters that bags may have of their own, and the column of each.
OWN: dict[str, Callable[[LawRows], FloatArray]] = {
    'coulomb': lambda rows: smooth_sign(np.nan_to_num(rows.v), rows.smoothing_velocity),
    'viscous': lambda rows: np.nan_to_num(rows.v),
    'bias': lambda rows: np.ones_like(np.nan_to_num(rows.v)),
}


@dataclass(frozen=True)
class RowNoise:
    """
    Hold the noise of a bag's rows [Nm or N].

    ``std`` is that of a single row, ``effective`` what it would be if rows were independent and
    their sums as noisy as they are: that of a row times the root of how many share their noise.
    """

    std: float
    effective: float

    @property
    def shared(self) -> float:
        """Return how many rows share their noise, 1 if each has its own."""
        return (self.effective / self.std) ** 2 if self.std > 0.0 else 1.0


def row_noise(rows: LawRows, smoothing_velocity: float | None = None) -> RowNoise:
    """
    Return the noise of the rows about a smooth curve of their own.

    The curve has the law's terms and up to four exponentials of fixed widths, so that it fits any
    friction that changes smoothly with speed: what is left is noise, not the law's failing.

    :param smoothing_velocity: v0 of the sign, None for that of the rows.
    """
    keep = rows.known
    y = rows.y[keep]
    labels, groups = np.unique(rows.clusters[keep], return_inverse=True)
    v = np.nan_to_num(rows.v)
    width = rows.smoothing_velocity if smoothing_velocity is None else smoothing_velocity
    sign = smooth_sign(v, width)
    columns = [sign, v, np.ones_like(v)]
    speeds = np.abs(rows.mean_v[keep])
    count = int(np.clip((len(labels) - 6) // 3, 0, _MOST_EXPONENTIALS))
    slowest, fastest = np.quantile(speeds, [0.02, 1.0]) if len(speeds) else (0.0, 0.0)
    if count and 0.0 < slowest < fastest:
        widths = np.geomspace(slowest, fastest, count)
        columns += [sign * fade(v, w, 1.0) for w in widths]
    X = np.column_stack([rows.lag(column)[keep] for column in columns])
    norms = np.linalg.norm(X, axis=0)
    X = X / np.where(norms > 0.0, norms, 1.0)
    theta, _, rank, _ = np.linalg.lstsq(X, y, rcond=1e-8)
    residual = y - X @ theta
    spread = 1.4826 * float(np.median(np.abs(residual))) if len(residual) else 0.0
    if spread > 0.0:
        residual = np.clip(residual, -_CLIP * spread, _CLIP * spread)
    free = max(len(y) - int(rank), 1)
    std = float(np.sqrt(residual @ residual / free))
    sums = np.bincount(groups, weights=residual) if len(y) else np.zeros(1)
    left = max(len(labels) - int(rank), 1)
    effective = float(np.sqrt(sums @ sums / len(y) * len(labels) / left)) if len(y) else 0.0
    return RowNoise(std, max(effective, std))


def joined(rows: LawRows, noise: RowNoise) -> LawRows:
    """
    Return means of rows that share their noise, so that each row knows something of its own.

    The law is averaged in the same way; only the change of friction within a mean is lost. Rows
    that are nearly independent stay as they are.
    """
    if noise.shared < _JOINED:
        return rows
    length = round(noise.shared)
    keep = np.flatnonzero(rows.known)
    runs = np.split(keep, np.flatnonzero(np.diff(keep) > 1) + 1)
    blocks = [
        part
        for run in runs
        if len(run)
        for part in np.array_split(run, max(1, len(run) // length))
    ]
    # A way from one to the other direction would average to next to nothing.
    blocks = [
        part
        for block in blocks
        for part in np.split(block, np.flatnonzero(np.diff(np.sign(rows.mean_v[block]))) + 1)
        if 2 * len(part) >= length
    ]
    if not blocks:
        return rows
    sizes = np.array([len(block) for block in blocks])
    index = np.concatenate(blocks)
    bounds = np.append(0, np.cumsum(sizes))
    mean = csr_array(
        (np.repeat(1.0 / sizes, sizes), index, bounds), shape=(len(blocks), len(rows.y))
    )
    return replace(
        rows.mapped(lambda column: np.array(mean @ column)),
        clusters=rows.clusters[[block[0] for block in blocks]],
        keep=np.ones(len(blocks), dtype=bool),
        mean_v=mean @ np.nan_to_num(rows.mean_v),
        unsmoothed=None if rows.unsmoothed is None else joined(rows.unsmoothed, noise),
    )


@dataclass(frozen=True)
class LawStack:
    """Hold one regression of all bags: ``bag`` (K,) says of which each row is."""

    rows: LawRows
    bag: IndexArray

    def own(self, names: Collection[str]) -> LawStack:
        """
        Return the regression in which each bag has some parameters of its own.

        What is fitted of these is their mean. Deviations from it are projected out of both sides
        (Frisch and Waugh): the other parameters are those of a fit that has all of them.

        :param names: some of :data:`OWN`, in which the law is linear whatever its other terms.
        """
        keep = self.rows.known
        bags = np.unique(self.bag[keep])
        contrasts = []
        for name in names:
            column = np.where(keep, self.rows.lag(OWN[name](self.rows)), 0.0)
            by_bag = np.column_stack([column, *(column * (self.bag == b) for b in bags[:-1])])
            contrasts.append(np.linalg.qr(by_bag)[0][:, 1:])
        gone = np.linalg.qr(np.hstack(contrasts))[0]

        def project(column: FloatArray) -> FloatArray:
            column = np.where(keep, column, 0.0)
            return np.array(column - gone @ (gone.T @ column))

        other = self.rows.unsmoothed
        if other is not None:
            other = LawStack(other, self.bag).own(names).rows
        rows = replace(self.rows.mapped(project), keep=keep, unsmoothed=other)
        return LawStack(rows, self.bag)


def stack_rows(parts: Sequence[LawRows], weights: Sequence[float]) -> LawStack:
    """
    Return the rows of all bags as one regression, both sides times the weight of their bag.

    Clusters of different bags are different. Columns that a caller added share their factors.

    :raises DataError: if the bags do not have as many of these.
    """
    ends = np.cumsum([len(rows.v) for rows in parts])[:-1]

    def lag(column: FloatArray) -> FloatArray:
        pieces = zip(parts, np.split(column, ends), weights, strict=True)
        return np.concatenate([w * rows.lag(piece) for rows, piece, w in pieces])

    clusters, first = [], 0
    for rows in parts:
        own = np.unique(rows.clusters, return_inverse=True)[1]
        clusters.append(own + first)
        first += int(own.max(initial=-1)) + 1
    columns = {0 if rows.extra is None else rows.extra.shape[1] for rows in parts}
    if len(columns) > 1:
        raise DataError(
            'the recordings were not prepared alike: inertia is fitted in some and not in others; '
            'fit all of them with it, or none'
        )

    def weighed(columns: Sequence[FloatArray | None]) -> FloatArray | None:
        known = [w * x for w, x in zip(weights, columns, strict=True) if x is not None]
        return np.concatenate(known) if known else None

    bag = np.repeat(np.arange(len(parts)), [len(rows.y) for rows in parts])
    of_row, trending = np.asarray(weights)[bag], _trending(parts)
    unsmoothed = None
    if any(rows.unsmoothed for rows in parts):
        unsmoothed = stack_rows([rows.unsmoothed or rows for rows in parts], weights).rows
    stacked = replace(
        parts[0],
        v=np.concatenate([rows.v for rows in parts]),
        y=np.concatenate([rows.y for rows in parts]) * of_row,
        clusters=np.concatenate(clusters).astype(np.int64),
        keep=np.concatenate([rows.keep for rows in parts]),
        mean_v=np.concatenate([rows.mean_v for rows in parts]),
        lag=lag,
        extra=weighed([rows.extra for rows in parts]),
        unsmoothed=unsmoothed,
        ways={
            name: np.concatenate([rows.ways.get(name, rows.y) for rows in parts]) * of_row
            for name in sorted({name for rows in parts for name in rows.ways})
        },
        trending=None if trending is None else trending * of_row[:, None],
        trend=None,
        # The bodies are the same in all recordings, and so are the columns.
        unsure=weighed([rows.unsure for rows in parts]),
    )
    return LawStack(stacked, bag)


def _trending(parts: Sequence[LawRows]) -> FloatArray | None:
    """Return what trends may be off by (K, T): each recording has one of its own."""
    if all(rows.trending is None for rows in parts):
        return None
    none = [np.empty((len(rows.y), 0)) for rows in parts]
    known = [rows.trending for rows in parts]
    return np.asarray(
        block_diag(*(n if x is None else x for n, x in zip(none, known, strict=True)))
    )
