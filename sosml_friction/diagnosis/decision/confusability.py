# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which causes look alike along this motion: known from the columns alone, before any answer."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.diagnosis.decision.cause import joint_name
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.regression.bounded import bounded_least_squares
from sosml_friction.regression.column_norms import ROUNDING
from sosml_friction.regression.evidence import CandidateColumns
from sosml_friction.regression.kernels import products
from sosml_friction.regression.whitened import WhitenedRegression

#: Directions of a cause with less than this share of its largest energy are rounding.
_DIRECTION = 1e-6
#: Decimals of a share in the document.
_DECIMALS = 4


@dataclass(frozen=True)
class Confusability:
    """
    Hold what one cause explains of another's effort.

    ``effects`` and ``joints`` (m,): of each candidate, the joint's name or '*'. ``share`` (m, m):
    C_ab, the share of what the refitted nominal leaves of the whitened effort of cause a that
    cause b explains, 1 on the diagonal. ``absorbed`` (m,): the share that the refit takes.
    """

    effects: tuple[str, ...]
    joints: tuple[str, ...]
    share: FloatArray
    absorbed: FloatArray

    def of(self, one: tuple[str, str], other: tuple[str, str]) -> float:
        """
        Return the share of cause ``one`` (effect, joint) that ``other`` explains.

        :raises KeyError: if one of them is no candidate here.
        """
        keys = {key: k for k, key in enumerate(zip(self.effects, self.joints, strict=True))}
        return float(self.share[keys[one], keys[other]])

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``confusability`` of diagnosis.json."""
        return {
            'candidates': [
                {'effect': effect, 'joint': joint, 'absorbed': round(float(absorbed), _DECIMALS)}
                for effect, joint, absorbed in zip(
                    self.effects, self.joints, self.absorbed, strict=True
                )
            ],
            'share': [[round(float(x), _DECIMALS) for x in row] for row in self.share],
        }


def confusability(
    laboratory: WhitenedRegression,
    accepted: Sequence[Finding] = (),
    bound: FloatArray | None = None,
) -> Confusability:
    """
    Return the share of each candidate that each other one explains.

    A cause is an effort A c as large as the noise (whitened mean square 1 in its joints) at the
    point of its grid that explains most of these data, and the mean over its directions c of equal
    energy; an accepted one is as it was found. What the nominal parameters, refitted within their
    bounds, leave of it is e = A c - Z x. The share of another cause with columns B is

        d' (B'B - B'Z_f (Z_f'Z_f + P)^-1 Z_f'B)^-1 d / (|e|^2 + x'P x),   d = B'e,

    at the point of its grid where that is largest: Z_f are the columns of nominal parameters that
    are not at their bounds, P is the precision of their prior. Ordered: a cause with more freedom
    explains one with less, not the other way round.

    :param accepted: causes that were found.
    :param bound: of the nominal deviations (p,), without prior; None for the model's own. Zero:
        the nominal is not refitted; infinite: it is free.
    """
    system, y = laboratory.system, laboratory.y
    weight = system.penalty() if bound is None else 1e-10 * np.diag(system.total)
    limit = system.bound if bound is None else bound
    normal = system.total + np.diag(weight + 1e-300)
    nuisance = _Nuisance(normal, limit)
    found = {finding.key: finding for finding in reversed(accepted)}
    names = laboratory.robot.names
    # The residual of the refitted nominal says at which point a cause is looked at.
    Zy = np.einsum('tip,ti->p', system.Z, y, optimize=True)
    x, free = nuisance.fit(Zy)
    left = (y - np.einsum('tip,p->ti', system.Z, x, optimize=True)).T[:, None]
    effects, joints = [], []
    efforts: list[tuple[CandidateColumns, FloatArray]] = []
    # A stated term with inner parameters is a candidate in any other form, too: it is told once.
    looked_at = [
        (candidate, columns)
        for candidate, columns in zip(laboratory.candidates, laboratory.columns, strict=True)
        if candidate.effect.stated is None or not candidate.effect.inner
    ]
    for candidate, columns in looked_at:
        effects.append(candidate.effect.identifier)
        joints.append(joint_name(candidate.effect, candidate.joint, names))
        finding = found.get(candidate.key)
        if finding is not None and finding.score.amplitude.any():
            its = finding.columns
            efforts.append((its, its.C[:, :, 0] @ finding.score.amplitude[:, None]))
            continue
        d = _cross(columns, left)
        g = int(np.argmax(_explained(columns, d, nuisance, free)[:, 0]))
        A = columns.A[:, g].sum(axis=0)
        size = np.sqrt(len(y) * len(columns.rows))
        efforts.append((columns, columns.C[:, :, g] @ (size * _directions(A))))
    share, absorbed = _shares(laboratory, efforts, [columns for _, columns in looked_at], nuisance)
    return Confusability(tuple(effects), tuple(joints), share, absorbed)


class _Nuisance:
    """Fit nominal deviations, and give the equations of those that are not at a bound."""

    def __init__(self, normal: FloatArray, bound: FloatArray) -> None:
        self.scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        self.normal = np.ascontiguousarray(normal * self.scale * self.scale[:, None])
        self.bound = bound / self.scale
        self._inverses: dict[bytes, FloatArray] = {}

    def fit(self, r: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the deviations (p,) for products r (p,) with a target, and which are free."""
        x = bounded_least_squares(self.normal, r * self.scale, -self.bound, self.bound)
        return np.asarray(x * self.scale), np.abs(x) < self.bound

    def inverse(self, free: BoolArray) -> FloatArray:
        """Return the inverse of the equations of the free ones, zero elsewhere, (p, p)."""
        key = free.tobytes()
        if key not in self._inverses:
            result = np.zeros_like(self.normal)
            result[np.ix_(free, free)] = np.linalg.pinv(
                self.normal[np.ix_(free, free)], hermitian=True
            )
            self._inverses[key] = result * self.scale * self.scale[:, None]
        return self._inverses[key]


def _shares(
    laboratory: WhitenedRegression,
    efforts: Sequence[tuple[CandidateColumns, FloatArray]],
    others: Sequence[CandidateColumns],
    nuisance: _Nuisance,
) -> tuple[FloatArray, FloatArray]:
    """Return C (m, m) and what is absorbed (m,) of causes, each (columns, (rows, joints, r))."""
    Z = laboratory.system.Z
    rows, n, _ = Z.shape
    # A cause without any effort in these data has one that is 0.
    efforts = [(c, e if e.shape[2] else np.zeros((*e.shape[:2], 1))) for c, e in efforts]
    ends = np.cumsum([0, *(effort.shape[2] for _, effort in efforts)])
    E = np.zeros((n, int(ends[-1]), rows))
    for k, (columns, effort) in enumerate(efforts):
        for i, row in enumerate(columns.rows):
            E[row, ends[k] : ends[k + 1]] = effort[:, i].T
    whole = np.einsum('iat,iat->a', E, E)
    r = np.stack([E[i] @ Z[:, i] for i in range(n)]).sum(axis=0)
    fits = [nuisance.fit(row) for row in r]
    x = np.array([fit[0] for fit in fits])
    normal = nuisance.normal / nuisance.scale / nuisance.scale[:, None]
    left = whole - 2.0 * (x * r).sum(axis=1) + np.einsum('ap,pq,aq->a', x, normal, x)
    left = np.maximum(left, 0.0)
    for i in range(n):
        E[i] -= x @ Z[:, i].T
    masks: dict[bytes, list[int]] = {}
    for a, (_, free) in enumerate(fits):
        masks.setdefault(free.tobytes(), []).append(a)
    share = np.zeros((len(efforts), len(efforts)))
    counts = np.diff(ends)
    seen = left > ROUNDING * whole
    for b, own in enumerate(others):
        d = _cross(own, E)
        explained = np.zeros((d.shape[0], d.shape[2]))
        for members in masks.values():
            explained[:, members] = _explained(
                own, d[:, :, members], nuisance, fits[members[0]][1]
            )
        shares = np.where(seen, explained / np.maximum(left, 1e-300), 0.0)
        share[:, b] = (np.add.reduceat(shares, ends[:-1], axis=1) / counts).max(axis=0)
    np.fill_diagonal(share, 1.0)
    absorbed = 1.0 - np.add.reduceat(left / np.maximum(whole, 1e-300), ends[:-1]) / counts
    return np.clip(share, 0.0, 1.0), np.clip(absorbed, 0.0, 1.0)


def _cross(columns: CandidateColumns, E: FloatArray) -> FloatArray:
    """Return products (g, k, a) of a cause's columns with efforts (n, a, rows)."""
    rows, m, grid, k = columns.C.shape
    result = np.zeros((E.shape[1], grid * k))
    for i in range(m):
        result += products(E[columns.rows[i]], columns.C[:, i].reshape(rows, grid * k))
    return result.T.reshape(grid, k, E.shape[1])


def _explained(
    columns: CandidateColumns, d: FloatArray, nuisance: _Nuisance, free: BoolArray
) -> FloatArray:
    """Return the energy (g, a) explained of efforts of which d (g, k, a) are the products."""
    A, B = columns.A.sum(axis=0), columns.B.sum(axis=0)
    B = B[:, : len(nuisance.scale)]
    own = np.einsum('gkk->gk', A)
    size = np.where(own > 0.0, 1.0 / np.sqrt(np.maximum(own, 1e-300)), 0.0)
    energy = A - B.transpose(0, 2, 1) @ (nuisance.inverse(free) @ B)
    energy = energy * size[:, :, None] * size[:, None, :] + ROUNDING * np.eye(A.shape[1])
    d = d * size[:, :, None]
    return np.asarray(np.einsum('gka,gka->ga', d, np.linalg.solve(energy, d)))


def _directions(A: FloatArray) -> FloatArray:
    """Return amplitudes (k, r) of energy 1 each and 0 together, those without energy left out."""
    size = np.sqrt(np.maximum(np.diag(A), 0.0))
    size = np.where(size > 0.0, 1.0 / np.maximum(size, 1e-300), 0.0)
    values, vectors = np.linalg.eigh(A * size * size[:, None])
    kept = values > max(_DIRECTION * float(values.max()), 1e-300)
    return np.asarray(size[:, None] * vectors[:, kept] / np.sqrt(values[kept]))
