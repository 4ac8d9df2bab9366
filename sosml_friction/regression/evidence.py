# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The whitened regression: nominal deviations within bounds, and candidates beside them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import BoolArray, ColumnArray, FloatArray, IndexArray
from sosml_friction.compiled import compiled
from sosml_friction.regression.bounded import AT, SAME, bounded_from, bounded_least_squares
from sosml_friction.regression.column_norms import ROUNDING
from sosml_friction.regression.kernels import convolve_rows, products, squares
from sosml_friction.regression.noise_model import NoiseModel

#: Ridge of a free parameter as a share of its column's whitened square norm. It keeps the
#: equations regular and moves an estimate by 1e-10 of itself.
_FREE = 1e-10
#: Variance of a uniform distribution within a bound, b^2 / 3, over that of the Gaussian whose
#: three standard deviations are the bound, b^2 / 9.
UNIFORM = 3.0
#: A deviation this close to its bound, as a share, is at it.
AT_BOUND = 0.999
#: Points of a grid whose deviations at bounds are others before these are looked up anew. Halved
#: and doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes.
_MISSES = 3
#: The range of an amplitude that may be anything.
ANY = (-np.inf, np.inf)


@dataclass(frozen=True)
class Blocks:
    """Say which rows belong to which block: ``edges`` (blocks + 1,), ``fold`` (blocks,)."""

    edges: IndexArray
    fold: IndexArray

    @property
    def ranges(self) -> list[tuple[int, int]]:
        """Return the rows of each block, from and to."""
        return list(itertools.pairwise(self.edges.tolist()))

    @property
    def folds(self) -> int:
        """Return how many folds there are."""
        return int(self.fold.max()) + 1


def make_blocks(rows: int, blocks: int, folds: int) -> Blocks:
    """
    Return ``blocks`` blocks of consecutive rows; block b is in fold b modulo ``folds``.

    With two blocks per fold, they are half a recording apart: a motion that is run twice is left
    out of a fit with its repetition.
    """
    return Blocks(
        np.linspace(0, rows, blocks + 1).astype(np.int64),
        np.arange(blocks, dtype=np.int64) % folds,
    )


def whiten_all(parts: Sequence[ColumnArray], noise: Sequence[NoiseModel]) -> ColumnArray:
    """Return parts in the band (K, n, ...) whitened and joined, (rows, n, ...)."""
    weights = np.stack([model.whitening for model in noise])
    whitened = [
        convolve_rows(
            np.ascontiguousarray(part).reshape(*part.shape[:2], math.prod(part.shape[2:])), weights
        ).reshape(-1, *part.shape[1:])
        for part in parts
    ]
    return whitened[0] if len(whitened) == 1 else np.concatenate(whitened)


@dataclass(frozen=True)
class System:
    """
    Hold the normal equations of the nominal deviations, by joint and block.

    ``Z`` (rows, n, p) whitened columns; ``G`` (n, blocks, p, p); ``bound`` and ``prior`` (p,).
    """

    Z: FloatArray
    G: FloatArray
    bound: FloatArray
    prior: FloatArray
    blocks: Blocks

    @classmethod
    def make(cls, Z: FloatArray, bound: FloatArray, prior: FloatArray, blocks: Blocks) -> System:
        """Return the system of the columns ``Z``."""
        G = np.array(
            [[Z[a:b, i].T @ Z[a:b, i] for a, b in blocks.ranges] for i in range(Z.shape[1])]
        )
        return cls(Z, G, bound, prior, blocks)

    def extended(self, more: Sequence[CandidateColumns]) -> System:
        """Return a system that has the columns of accepted causes too, without bounds."""
        if not more:
            return self
        Z = np.concatenate([self.Z, joined(more, self.Z.shape[1])], axis=2)
        free = np.full(Z.shape[2] - len(self.bound), np.inf)
        return System.make(
            Z, np.concatenate([self.bound, free]), np.concatenate([self.prior, free]), self.blocks
        )

    @cached_property
    def total(self) -> FloatArray:
        """Return Z'Z of all joints and blocks, (p, p)."""
        return np.asarray(self.G.sum(axis=(0, 1)))

    def penalty(self) -> FloatArray:
        """Return the diagonal that the prior adds to the normal equations, (p,)."""
        return self.prior_weight() + _ridge(self.total)

    def prior_weight(self) -> FloatArray:
        """Return one over the variance of the prior, 0 where there is none, (p,)."""
        weight = np.where(np.isfinite(self.prior), 1.0 / np.maximum(self.prior, 1e-150) ** 2, 0.0)
        # A bound of zero is no freedom at all; its weight would overflow.
        return np.where(self.bound > 0.0, weight, 0.0)


def _ridge(G: FloatArray) -> FloatArray:
    """Return what keeps equations regular, (p,)."""
    return np.asarray(_FREE * np.diag(G) + 1e-12)


@dataclass(frozen=True)
class Target:
    """Hold what is to be explained: ``y`` (rows, n), ``r`` (n, blocks, p), ``yy`` (n, blocks)."""

    y: FloatArray
    r: FloatArray
    yy: FloatArray

    @classmethod
    def make(cls, system: System, y: FloatArray) -> Target:
        """Return the target's products with the system's columns."""
        pairs, n = system.blocks.ranges, y.shape[1]
        r = np.array([[system.Z[a:b, i].T @ y[a:b, i] for a, b in pairs] for i in range(n)])
        yy = np.array([[float(y[a:b, i] @ y[a:b, i]) for a, b in pairs] for i in range(n)])
        return cls(y, r, yy)


@dataclass(frozen=True)
class CandidateColumns:
    """
    Hold the whitened columns of one effect in one joint over its grid, and their products.

    ``rows``: the joints they act in, m of them. ``C`` (rows, m, g, k), of a large grid in single
    precision; ``A`` (blocks, g, k, k)
    and ``B`` (blocks, g, p, k) with the system's columns, summed over the joints.
    """

    rows: IndexArray
    C: ColumnArray
    A: FloatArray
    B: FloatArray

    @classmethod
    def make(cls, system: System, rows: IndexArray, C: ColumnArray) -> CandidateColumns:
        """Return the products of ``C`` with itself and with the system."""
        A = np.array([squares(C[a:b]) for a, b in system.blocks.ranges])
        return cls(rows, C, A, np.empty((*A.shape[:2], 0, A.shape[2]))).beside(system)

    def beside(self, system: System) -> CandidateColumns:
        """Return the same with an extended system, whose first columns are the known ones."""
        known = self.B.shape[2]
        if system.Z.shape[2] == known:
            return self
        _, m, g, k = self.C.shape
        B = []
        for b, (first, last) in enumerate(system.blocks.ranges):
            cross = np.zeros((system.Z.shape[2] - known, g * k))
            for i in range(m):
                flat = self.C[first:last, i].reshape(last - first, g * k)
                cross += products(system.Z[first:last, self.rows[i], known:].T, flat)
            more = cross.reshape(-1, g, k).transpose(1, 0, 2)
            B.append(np.concatenate([self.B[b], more], axis=1))
        return CandidateColumns(self.rows, self.C, self.A, np.array(B))

    def beside_first(self, known: int) -> CandidateColumns:
        """Return the same with the first ``known`` columns of the system alone."""
        return CandidateColumns(self.rows, self.C, self.A, self.B[:, :, :known])

    def products(self, system: System, y: FloatArray) -> FloatArray:
        """Return C' y by block, (blocks, g, k)."""
        _, m, g, k = self.C.shape
        result = np.zeros((len(system.blocks.ranges), g * k))
        for i in range(m):
            flat = self.C[:, i].reshape(len(self.C), g * k)
            for b, (first, last) in enumerate(system.blocks.ranges):
                result[b] += products(y[None, first:last, self.rows[i]], flat[first:last])[0]
        return result.reshape(-1, g, k)


def joined(columns: Sequence[CandidateColumns], n: int) -> FloatArray:
    """Return columns of one point each beside one another, (rows, n, k)."""
    ends = np.cumsum([0, *(each.C.shape[3] for each in columns)])
    result = np.zeros((len(columns[0].C), n, int(ends[-1])))
    for each, first in zip(columns, ends, strict=False):
        result[:, each.rows, first : first + each.C.shape[3]] = each.C[:, :, 0]
    return result


@dataclass(frozen=True)
class NormalEquations:
    """
    Hold the normal equations of a system and of free columns beside it, over all rows.

    What a search asks at every step, without the rows and folds of a :class:`Fit`. ``G`` (p, p)
    without and ``penalty`` (p,) of the prior, ``r`` (p,) and ``yy`` of the target.
    """

    G: FloatArray
    penalty: FloatArray
    bound: FloatArray
    r: FloatArray
    yy: float

    @classmethod
    def make(
        cls, system: System, target: Target, columns: Sequence[CandidateColumns]
    ) -> NormalEquations:
        """Return the equations; the products of ``columns`` begin with those of the system."""
        own, r, yy = system.total, target.r.sum(axis=(0, 1)), float(target.yy.sum())
        if not columns:
            return cls(own, system.penalty(), system.bound, r, yy)
        rows, n = target.y.shape
        wide = joined(columns, n).reshape(rows * n, -1)
        cross = np.hstack([each.B[:, 0, : len(own)].sum(axis=0) for each in columns])
        more = wide.T @ wide
        return cls(
            np.block([[own, cross], [cross.T, more]]),
            np.concatenate([system.penalty(), _ridge(more)]),
            np.concatenate([system.bound, np.full(len(more), np.inf)]),
            np.concatenate([r, wide.T @ target.y.reshape(rows * n)]),
            yy,
        )

    def solve(self) -> tuple[FloatArray, float]:
        """Return where the cost is least within the bounds (p,), and the cost."""
        A = self.G + np.diag(self.penalty)
        x = solve_bounded(A, self.r, -self.bound, self.bound)
        return x, float(self.yy - 2.0 * self.r @ x + x @ A @ x)


@dataclass(frozen=True)
class Baseline:
    """
    Hold the refitted nominal without candidates.

    ``x`` (p,) on all data and ``cost`` its whitened residual energy plus prior; ``fold_x``
    (folds, p) without each fold; ``held_out`` (n, folds): residual energy on the fold left out.
    """

    x: FloatArray
    cost: float
    fold_x: FloatArray
    held_out: FloatArray


def fit_baseline(system: System, target: Target) -> Baseline:
    """Return the refitted nominal."""
    equations = NormalEquations.make(system, target, ())
    x, cost = equations.solve()
    G, r, penalty = equations.G, equations.r, equations.penalty
    low, high = -system.bound, system.bound
    folds = system.blocks.folds
    fold_x = np.empty((folds, len(r)))
    held_out = np.empty((len(target.yy), folds))
    for f in range(folds):
        inside = system.blocks.fold == f
        Gf, rf = system.G[:, inside].sum(axis=1), target.r[:, inside].sum(axis=1)
        fold_x[f] = solve_bounded(
            G - Gf.sum(axis=0) + np.diag(penalty), r - rf.sum(axis=0), low, high
        )
        z = fold_x[f]
        held_out[:, f] = (
            target.yy[:, inside].sum(axis=1) - 2.0 * rf @ z + np.einsum('ikl,k,l->i', Gf, z, z)
        )
    return Baseline(x, cost, fold_x, held_out)


def solve_bounded(G: FloatArray, r: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return x (p,) between its bounds where x' G x - 2 r' x is least."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(G), 1e-300))
    x = bounded_least_squares(
        np.ascontiguousarray(G * scale * scale[:, None]), r * scale, low / scale, high / scale
    )
    return np.asarray(x * scale)


@dataclass(frozen=True)
class Score:
    """
    Hold what the data say of one candidate.

    ``best``: index into its grid on all data, where its amplitudes are possible; ``gain``: fall of
    the cost; ``amplitude``, ``error`` (k,); ``x`` (p,) the nominal deviations beside it.
    ``cv_gain``: share of the held-out residual energy of its joints that it removes, inner
    parameters chosen without the fold; ``cv_se`` its standard error over the folds; ``cv_least``:
    without the fold in which it removes most; ``energy``: held-out energy removed in all.
    ``gains`` (g,) over the grid.
    """

    best: int
    gain: float
    amplitude: FloatArray
    error: FloatArray
    x: FloatArray
    cv_gain: float
    cv_se: float
    cv_least: float
    energy: float
    gains: FloatArray


@dataclass(frozen=True)
class Fit:
    """Hold a system fitted to a target, beside which candidates are scored."""

    system: System
    target: Target
    baseline: Baseline

    @classmethod
    def make(cls, system: System, y: FloatArray) -> Fit:
        """Return the fit to whitened rows ``y`` (rows, n)."""
        target = Target.make(system, y)
        return cls(system, target, fit_baseline(system, target))

    @cached_property
    def _sides(self) -> list[_Side]:
        """Return the equations of all rows, then those without each fold."""
        system, x = self.system, self.baseline.x
        penalty = np.diag(system.penalty())
        G, r = system.total + penalty, self.target.r.sum(axis=(0, 1))
        sides = [_Side.make(slice(None), G, r, system.bound, x)]
        for f, z in enumerate(self.baseline.fold_x):
            inside = system.blocks.fold == f
            Gf, rf = (
                system.G[:, inside].sum(axis=(0, 1)),
                self.target.r[:, inside].sum(axis=(0, 1)),
            )
            sides.append(_Side.make(inside, G - Gf, r - rf, system.bound, z))
        return sides

    def score(self, columns: CandidateColumns, within: tuple[float, float] = ANY) -> Score:
        """
        Return the evidence for a candidate whose first products are those of the system.

        :param within: where its amplitudes are, if they are there at any point of its grid.
        """
        baseline = self.baseline
        candidate = columns.beside(self.system)
        d = candidate.products(self.system, self.target.y)
        whole, *folds = self._sides
        A, B, D = candidate.A.sum(axis=0), candidate.B.sum(axis=0), d.sum(axis=0)
        gains, solutions = whole.sweep(A, B, D)
        p = len(baseline.x)
        best = _best(gains, solutions[:, p:], within)
        removed = np.empty(len(folds))
        for f, (side, z) in enumerate(zip(folds, baseline.fold_x, strict=True)):
            Af, Bf, Df = (part[side.blocks].sum(axis=0) for part in (candidate.A, candidate.B, d))
            fold_gains, fold_solutions = side.sweep(A - Af, B - Bf, D - Df)
            g = _best(fold_gains, fold_solutions[:, p:], within)
            x, c = fold_solutions[g, :p], fold_solutions[g, p:]
            Gf, rf = whole.G - side.G, whole.r - side.r
            with_it = (
                -2.0 * (rf @ x + Df[g] @ c) + x @ Gf @ x + 2.0 * x @ Bf[g] @ c + c @ Af[g] @ c
            )
            removed[f] = -2.0 * rf @ z + z @ Gf @ z - with_it
        base = float(self.target.yy.sum()) - baseline.cost
        # A joint that rests throughout has no energy.
        energy = max(float(baseline.held_out[candidate.rows].sum()), np.finfo(np.float64).tiny)
        return Score(
            best=best,
            gain=float(gains[best]) - base,
            amplitude=solutions[best, p:],
            error=_amplitude_error(whole.G, A[best], B[best]),
            x=solutions[best, :p],
            cv_gain=float(removed.sum()) / energy,
            cv_se=float(np.std(removed, ddof=1)) * np.sqrt(len(removed)) / energy,
            cv_least=float(removed.sum() - removed.max()) / energy,
            energy=float(removed.sum()),
            gains=gains - base,
        )


class _Side(NamedTuple):
    """
    Hold the equations of some blocks' rows, which all candidates are tried beside.

    ``blocks``: those left out, or all; ``G`` (p, p) with the prior, ``r``, ``bound`` (p,);
    ``start`` (p,): the answer without a candidate, ``K``: see :func:`_inverse_of`.
    """

    blocks: BoolArray | slice
    G: FloatArray
    r: FloatArray
    bound: FloatArray
    start: FloatArray
    K: FloatArray

    @classmethod
    def make(
        cls,
        blocks: BoolArray | slice,
        G: FloatArray,
        r: FloatArray,
        bound: FloatArray,
        start: FloatArray,
    ) -> _Side:
        """Return the equations with their inverse."""
        scale = 1.0 / np.sqrt(np.diag(G))
        # What is at a bound but for rounding is there.
        at = np.abs(start) >= (1.0 - AT) * bound
        start = np.where(at, np.copysign(bound, start), start)
        K = _inverse_of(G * scale * scale[:, None], np.abs(start) < bound)
        return cls(blocks, G, r, bound, start, K)

    def sweep(self, A: FloatArray, B: FloatArray, d: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return gains and solutions along a grid, see :func:`_sweep`."""
        return _sweep(self.G, self.r, self.bound, A, B, d, self.start, self.K)


def _best(gains: FloatArray, amplitudes: FloatArray, within: tuple[float, float]) -> int:
    """Return the point of a grid that explains most, of those whose amplitudes are possible."""
    inside = possible(amplitudes, within)
    return int(np.argmax(np.where(inside, gains, -np.inf) if inside.any() else gains))


def possible(amplitudes: FloatArray, within: tuple[float, float]) -> BoolArray:
    """Return where all amplitudes (..., k) are within a range."""
    return np.asarray(((within[0] < amplitudes) & (amplitudes < within[1])).all(axis=-1))


def _amplitude_error(G: FloatArray, A: FloatArray, B: FloatArray) -> FloatArray:
    """Return the errors of a candidate's amplitudes (k,), of A (k, k) and B (p, k)."""
    size, scale = np.sqrt(np.diag(A)), 1.0 / np.sqrt(np.diag(G))
    size = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    own, cross = A * size * size[:, None], B * size * scale[:, None]
    np.fill_diagonal(own, 1.0 + ROUNDING)
    left = own - cross.T @ np.linalg.solve(G * scale * scale[:, None], cross)
    variance = np.diag(np.linalg.inv(left + ROUNDING * np.eye(len(A))))
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)) * size)


@compiled
def _sweep(
    G: FloatArray,
    r: FloatArray,
    bound: FloatArray,
    A: FloatArray,
    B: FloatArray,
    d: FloatArray,
    start: FloatArray,
    K: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """
    Return the fall of the cost (g,) and the solutions (g, p + k).

    Candidates are not bounded. Amplitudes are eliminated first, so that one small bounded problem
    is left for each point of the grid, solved from the answer before; the first from ``start``.
    The deviations that are at a bound change seldom: while they do not, the inverse of the others'
    equations is that without the candidate, ``K``, and a correction of rank k.
    """
    g, k = d.shape
    p = len(r)
    misses = 0
    gains = np.empty(g)
    solutions = np.empty((g, p + k))
    scale = 1.0 / np.sqrt(np.diag(G))
    low, high = -bound / scale, bound / scale
    scaled = G * scale * scale.reshape(p, 1)
    x = start / scale
    free = np.abs(start) < bound
    for i in range(g):
        size = np.empty(k)
        for j in range(k):
            size[j] = 1.0 / np.sqrt(A[i, j, j]) if A[i, j, j] > 0.0 else 0.0
        own = A[i] * size * size.reshape(k, 1)
        for j in range(k):
            own[j, j] = 1.0 + ROUNDING
        cross = B[i] * size * scale.reshape(p, 1)
        right = d[i] * size
        solved = np.linalg.solve(own, cross.T)
        aim = r * scale - cross @ np.linalg.solve(own, right)
        if misses >= _MISSES:
            misses = 0
            free = (x > low) & (x < high)
            K = _inverse_of(scaled, free)
        known, y = _with_free(scaled, cross, own, solved, aim, low, high, free, K, x)
        if known:
            x = y
        else:
            misses += 1
            x = bounded_from(scaled - cross @ solved, aim, low, high, x)
        c = np.linalg.solve(own, right - cross.T @ x)
        gains[i] = (
            2.0 * (np.dot(r * scale, x) + np.dot(right, c))
            - np.dot(x, scaled @ x)
            - 2.0 * np.dot(x, cross @ c)
            - np.dot(c, own @ c)
        )
        solutions[i, :p] = x * scale
        solutions[i, p:] = c * size
    return gains, solutions


@compiled
def _inverse_of(G: FloatArray, free: BoolArray) -> FloatArray:
    """Return the inverse of the equations of the free ones, zero elsewhere, (p, p)."""
    at = np.flatnonzero(free)
    part = np.empty((len(at), len(at)))
    for i in range(len(at)):
        part[i] = G[at[i]][at]
    inverse = np.linalg.inv(part)
    result = np.zeros(G.shape)
    for i in range(len(at)):
        for j in range(len(at)):
            result[at[i], at[j]] = inverse[i, j]
    return result


@compiled
def _with_free(
    G: FloatArray,
    cross: FloatArray,
    own: FloatArray,
    solved: FloatArray,
    aim: FloatArray,
    low: FloatArray,
    high: FloatArray,
    free: BoolArray,
    K: FloatArray,
    before: FloatArray,
) -> tuple[bool, FloatArray]:
    """
    Return whether the answer has these ``free`` deviations, and the answer if so.

    Of :func:`~sosml_friction.regression.bounded.bounded_from` with G - cross own^-1 cross',
    by Woodbury's identity; ``solved`` is own^-1 cross', K that of :func:`_inverse_of`.
    """
    x = np.where(free, 0.0, before)
    for i in range(len(x)):
        if not free[i] and low[i] < before[i] < high[i]:
            return False, x
    b = aim - G @ x + cross @ (solved @ x)
    Kb, Kc = K @ b, K @ cross
    x += Kb + Kc @ np.linalg.solve(own - cross.T @ Kc, cross.T @ Kb)
    slope = aim - G @ x + cross @ (solved @ x)
    for i in range(len(x)):
        if free[i]:
            if not low[i] <= x[i] <= high[i]:
                return False, x
        elif high[i] > low[i]:
            pull = slope[i] / np.sqrt(G[i, i] - np.dot(cross[i], solved[:, i]))
            if pull * (1.0 if x[i] <= low[i] else -1.0) > SAME:
                return False, x
    return True, x


def falls(
    normal: FloatArray,
    r: FloatArray,
    bound: FloatArray,
    A: FloatArray,
    B: FloatArray,
    d: FloatArray,
) -> tuple[float, FloatArray]:
    """
    Return by how much the cost falls with nominal deviations alone, and with a candidate (g,).

    :param normal: Z'Z with the prior (p, p); r: Z'y (p,); A, B, d: C'C (g, k, k), Z'C (g, p, k),
        C'y (g, k).
    """
    x = solve_bounded(normal, r, -bound, bound)
    alone = float(2.0 * r @ x - x @ normal @ x)
    side = _Side.make(slice(None), normal, r, bound, x)
    return alone, side.sweep(A, np.ascontiguousarray(B), d)[0]
