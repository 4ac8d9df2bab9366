# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The recordings as rows of a regression: low-passed, decimated, not yet whitened."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import ColumnArray, FloatArray, IndexArray
from sosml_friction.model.terms.kinds.term import Term
from sosml_friction.model.terms.kinds.transmission_term import TransmissionTerm
from sosml_friction.regression.candidate import Candidate, make_candidates
from sosml_friction.regression.column_norms import joints_acted_in
from sosml_friction.regression.kernels import POINTS_AT_ONCE, ROWS_AT_ONCE
from sosml_friction.regression.nominal import Nominal, make_nominal
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.structure import Structure

#: The m joints that columns act in, and the columns of each stretch (K, m, g, k).
JointColumns = tuple[IndexArray, list[ColumnArray]]

#: A larger grid [points] is kept in single precision, whose noise is a millionth of a whitened
#: column's: what is chosen of it is computed anew. What is left as noise has its strongest points
#: taken off alone. Doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes;
#: halved, two of nine do: a push is named where a gap is, and causes come in another order.
SMALL_GRID = 12


@dataclass(frozen=True)
class BandRows:
    """
    Hold both sides of the regression in the band, one array per stretch of K rows [Nm or N].

    ``residual`` (K, n): measured effort minus that of the nominal model. ``nominal_columns``
    (K, n, p): effort per unit of each nominal parameter. ``columns``: those of the candidates, at
    all points of their grids, of large ones in single precision; ``structure_columns``: those of
    the free curves of each joint. Both are empty once they are whitened.
    """

    signals: tuple[Signals, ...]
    nominal: Nominal
    candidates: tuple[Candidate, ...]
    residual: list[FloatArray]
    nominal_columns: list[FloatArray]
    columns: list[JointColumns]
    structure_columns: list[JointColumns]

    @classmethod
    def make(
        cls, signals: Sequence[Signals], library: dict[str, Term], settings: DiagnosisSettings
    ) -> BandRows:
        """
        Return the rows of some stretches, with a candidate for each effect of the library.

        :raises ConfigurationError: if no effect can act.
        """
        first = signals[0]
        # Joints whose effort is known in no stretch.
        silent = frozenset.intersection(*(s.silent for s in signals))
        nominal = make_nominal(
            first,
            settings.tolerance,
            silent,
            settings.free_inertia,
            settings.unknown_armature,
            tuple(sorted({s.recording for s in signals})) if settings.own_friction else (),
        )
        # A gear that gives moves the nominal body, of which a free inertia says that it is not so.
        candidates = tuple(
            candidate
            for candidate in make_candidates(library, first, silent)
            if not isinstance(candidate.effect, TransmissionTerm)
            or first.robot.names[candidate.joint] not in settings.free_inertia
        )
        free = Structure(signals)
        structures = [Candidate(free, i, ({},)) for i in range(first.robot.n)]
        return cls(
            tuple(signals),
            nominal,
            candidates,
            [s.in_band(s.unexplained) for s in signals],
            [s.in_band(nominal.columns(s)) for s in signals],
            [columns_in_band(signals, candidate) for candidate in candidates],
            [columns_in_band(signals, candidate) for candidate in structures],
        )

    def in_joint(self, joint: int) -> Iterator[tuple[Candidate, list[ColumnArray]]]:
        """Yield the candidates that act in a joint, with their columns there (K, g, k)."""
        for candidate, (joints, columns) in zip(self.candidates, self.columns, strict=True):
            for k in np.flatnonzero(joints == joint):
                yield candidate, [part[:, k] for part in columns]

    def only(self, effects: Collection[str]) -> BandRows:
        """Return the same with some effects as candidates."""
        kept = [k for k, own in enumerate(self.candidates) if own.effect.identifier in effects]
        return replace(
            self,
            candidates=tuple(self.candidates[k] for k in kept),
            columns=[self.columns[k] for k in kept],
        )


def columns_in_band(signals: Sequence[Signals], candidate: Candidate) -> JointColumns:
    """Return the columns of a candidate in the joints that it acts in, in any stretch."""
    found = [_own_joint(s, candidate) or _all_joints(s, candidate) for s in signals]
    first = found[0][0]
    if all(np.array_equal(joints, first) for joints, _ in found):
        return first, [part for _, part in found]
    # A stretch in which a joint does not move has no column of its own there.
    joints = np.unique(np.concatenate([own for own, _ in found]))
    parts = []
    for own, part in found:
        wide = np.zeros((len(part), len(joints), *part.shape[2:]))
        wide[:, np.searchsorted(joints, own)] = part
        parts.append(wide)
    return joints, parts


def _own_joint(signals: Signals, candidate: Candidate) -> tuple[IndexArray, ColumnArray] | None:
    """Return joint and columns (K, 1, g, k), if the effect gives many grid points at once."""
    joint, grid, band = candidate.joint, candidate.grid, signals.band
    count = band.count(len(signals.q))
    at_once = max(1, ROWS_AT_ONCE // band.factor)
    precision = np.float64 if len(grid) <= SMALL_GRID else np.float32
    part: ColumnArray | None = None
    for first in range(0, count, at_once):
        rows = slice(first, min(first + at_once, count))
        seen = signals.part(band.seen(rows))
        for begin in range(0, len(grid), POINTS_AT_ONCE):
            points = slice(begin, begin + POINTS_AT_ONCE)
            own = candidate.effect.own_columns(seen, joint, grid[points])
            if own is None:
                return None
            if part is None:
                part = np.empty((count, 1, len(grid), own.shape[2]), precision)
            part[rows, 0, points] = band.apply(own.astype(precision, copy=False))
    return None if part is None else (np.array([joint]), signals.without_unknown(part, [joint]))


def _all_joints(signals: Signals, candidate: Candidate) -> tuple[IndexArray, FloatArray]:
    """Return joints and columns (K, m, g, k), one grid point after the other."""
    joint, grid = candidate.joint, candidate.grid
    columns = candidate.effect.columns(signals, joint, grid[0])
    rows = joints_acted_in(columns)
    if not len(rows):
        rows = np.array([max(joint, 0)])
    part = np.empty((signals.band.count(len(columns)), len(rows), len(grid), columns.shape[2]))
    for g, inner in enumerate(grid):
        if g:
            columns = candidate.effect.columns(signals, joint, inner)
        part[:, :, g] = signals.in_band(columns[:, rows], rows.tolist())
    return rows, part
