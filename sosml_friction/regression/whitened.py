# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings made ready for selection: whitened columns of the nominal and of all candidates."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import BoolArray, Entry, FloatArray
from sosml_friction.exceptions import DataError
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.band_rows import BandRows, JointColumns, columns_in_band
from sosml_friction.regression.candidate import Candidate
from sosml_friction.regression.chance import FEWEST
from sosml_friction.regression.column_norms import joints_acted_in
from sosml_friction.regression.contacts import Contacts
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.evidence import (
    Blocks,
    CandidateColumns,
    System,
    Target,
    make_blocks,
)
from sosml_friction.regression.library_residual import (
    MOST_TAKEN,
    LibraryResidual,
    library_residual,
)
from sosml_friction.regression.noise_model import ORDER, NoiseModel
from sosml_friction.regression.nominal import Nominal
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, with_rests
from sosml_friction.regression.turn_residual import sticking_joints
from sosml_friction.regression.whitening import Whitening, pushed_rows


@dataclass(frozen=True)
class WhitenedRegression:
    """
    Hold the whitened regression: any target can be tried against any candidate.

    ``rows``: both sides in the band; ``whitening``: noise, contacts and standstill; ``known``
    (n,): how many whitened rows of each joint say something; ``y`` (rows, n): the whitened
    residual of the nominal model; ``system``: the whitened nominal columns; ``columns`` and
    ``structure_columns``: those of the candidates, and of the free curves of each joint.
    """

    settings: DiagnosisSettings
    rows: BandRows
    whitening: Whitening
    known: FloatArray
    y: FloatArray
    system: System
    columns: tuple[CandidateColumns, ...]
    structure_columns: tuple[CandidateColumns, ...]

    @classmethod
    def make(
        cls,
        signals: Sequence[Signals],
        library: dict[str, Term],
        settings: DiagnosisSettings,
        step: Callable[[str], None] = lambda text: None,
        kept: Collection[str] | None = None,
    ) -> WhitenedRegression:
        """
        Low-pass, whiten and multiply everything once.

        :param library: effects to look for, by identifier.
        :param kept: effects that remain candidates once the noise is known; None for all.
        :raises ConfigurationError: if no effect can act in these joints.
        :raises DataError: if the recordings are too short for the blocks.
        """
        step('computing the columns of all candidates')
        every = frozenset(range(signals[0].robot.n))
        turns = every if settings.moving_only else frozenset()
        rows = BandRows.make(with_rests(signals, turns=turns), library, settings)
        if not turns and (turns := sticking_joints(rows, with_rests(signals, turns=every))):
            # All grids together are the largest of a diagnosis: two of them do not fit.
            del rows
            rows = BandRows.make(with_rests(signals, turns=turns), library, settings)
        step('whitening')
        left, pushed = _beside_pushes(rows, settings)
        whitening = Whitening.fit(rows, left, pushed, settings.tolerance)
        if kept is not None:
            rows = rows.only(kept)
        y, standstill = whitening.apply(rows.residual), whitening.standstill
        known = np.full(y.shape[1], float(len(y))) if standstill is None else standstill.known()
        found, needed = round(float(known.max())), FEWEST * settings.blocks
        if kept is None and found >= needed:
            # A joint in which less than half as many candidates act as in another rests.
            taken = np.array([float(fit.act.sum()) for fit in left[0].fits])
            told = np.where(taken >= 0.5 * taken.max(), known, 0.0)
            i = int(np.argmax(told / np.maximum(taken, 1.0)))
            found, needed = round(float(known[i])), max(needed, round(taken[i] / MOST_TAKEN))
        if found < needed:
            # A short recording is short by itself.
            rests = f' ({len(y)} samples, but the joints rest in the others)' * (found < len(y))
            raise DataError(
                f'{found} samples of a motion are in the band of {signals[0].band.cutoff:.3g} Hz, '
                f'which noise and rate leave{rests}, and {needed} are needed: record more motion, '
                'without holes, or at a higher rate'
            )
        blocks = make_blocks(len(y), settings.blocks, settings.folds)
        nominal = rows.nominal
        system = System.make(
            whitening.apply(rows.nominal_columns), nominal.bound, nominal.prior, blocks
        )
        columns, structure = (
            _whitened(system, whitening, entries)
            for entries in (rows.columns, rows.structure_columns)
        )
        return cls(settings, rows, whitening, known, y, system, columns, structure)

    @cached_property
    def target(self) -> Target:
        """Return the products of ``y`` with the nominal columns."""
        return Target.make(self.system, self.y)

    @property
    def signals(self) -> tuple[Signals, ...]:
        """Return the stretches, with their rests."""
        return self.rows.signals

    @property
    def robot(self) -> Robot:
        """Return the robot of the nominal model."""
        return self.signals[0].robot

    @property
    def nominal(self) -> Nominal:
        """Return the nominal parameters that are refitted."""
        return self.rows.nominal

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """Return the candidates, in the order of ``columns``."""
        return self.rows.candidates

    @property
    def noise(self) -> tuple[NoiseModel, ...]:
        """Return the noise of each joint."""
        return self.whitening.noise

    @property
    def noise_energy(self) -> FloatArray:
        """Return the sum of squares (n,) that noise alone has in the whitened rows."""
        return self.known * np.array([model.power for model in self.noise])

    @property
    def contacts(self) -> Contacts:
        """Return contacts and impacts."""
        return self.whitening.contacts

    @property
    def blocks(self) -> Blocks:
        """Return the blocks of the whitened rows."""
        return self.system.blocks

    @property
    def without_rests(self) -> bool:
        """Tell whether any joint rests."""
        return any(signals.rests for signals in self.signals)

    def seen_alike(self, others: Sequence[Signals]) -> list[Signals]:
        """Return stretches of another recording, without the rests of the joints that stop."""
        return list(with_rests(others, (*self.signals, *others)))

    def unwhitened(self) -> tuple[FloatArray, FloatArray]:
        """Return residual (rows, n) and nominal columns (rows, n, p) in the band, unwhitened."""
        return _joined(self.rows.residual), _joined(self.rows.nominal_columns)

    def split(self, rows: NDArray[Entry]) -> list[NDArray[Entry]]:
        """Return what has one entry per whitened row as one array per stretch."""
        ends = np.cumsum([len(part) - ORDER for part in self.rows.residual])[:-1]
        return np.split(rows, ends)

    def measured(self) -> FloatArray:
        """Return the measured effort in the band (rows, n), in the rows of the whitened ones."""
        return _joined([signals.band.apply(signals.tau) for signals in self.signals])

    def measured_in_motion(self) -> FloatArray:
        """Return the same without what rests may take, NaN of joints of which nothing is known."""
        measured = _joined([signals.in_band(signals.tau) for signals in self.signals])
        measured[:, sorted(self.nominal.silent)] = np.nan
        return measured

    def own_columns(self, effect: Term, joint: int, inner: Inner) -> FloatArray:
        """Return an effect's columns in the band (rows, n, k), in Nm or N."""
        parts = []
        for s in self.signals:
            columns = effect.columns(s, joint, inner)
            part = np.zeros((s.band.count(len(columns)), *columns.shape[1:]))
            for i in joints_acted_in(columns).tolist():
                own = np.ascontiguousarray(columns[:, i : i + 1])
                part[:, i] = s.in_band(own, [i])[:, 0]
            parts.append(part)
        return _joined(parts)

    def single(self, effect: Term, joint: int, inner: Inner) -> CandidateColumns:
        """Return the whitened columns of an effect at one value of its inner parameters."""
        return self.on_grid(effect, joint, (inner,))

    def on_grid(self, effect: Term, joint: int, grid: Sequence[Inner]) -> CandidateColumns:
        """Return the whitened columns of an effect at some values of its inner parameters."""
        joints, parts = columns_in_band(self.signals, Candidate(effect, joint, grid))
        return CandidateColumns.make(self.system, joints, self.whitening.apply(parts, joints))

    def of_curve(self, curve: Curve, joint: int) -> FloatArray:
        """Return the whitened columns (rows, k) of a free curve of a joint in that joint."""
        joints, parts = columns_in_band(self.signals, Candidate(curve, joint, ({},)))
        C = self.whitening.apply(parts, joints)
        (at,) = np.flatnonzero(joints == joint)
        return np.asarray(C[:, at].reshape(len(C), -1), np.float64)

    def inseparable(self, effect: Term) -> tuple[str, ...]:
        """Return the causes looked for that joint sensors cannot tell from an effect at all."""
        sought = {candidate.effect.identifier for candidate in self.candidates}
        return tuple(name for name in effect.inseparable if name in sought)


def _whitened(
    system: System, whitening: Whitening, entries: list[JointColumns]
) -> tuple[CandidateColumns, ...]:
    """Return columns whitened, and take them out of ``entries``: two of all are too large."""
    result = []
    while entries:
        joints, parts = entries.pop(0)
        result.append(CandidateColumns.make(system, joints, whitening.apply(parts, joints)))
    return tuple(result)


def _joined(parts: Sequence[FloatArray]) -> FloatArray:
    """Return the rows of all stretches that whitening keeps."""
    return np.concatenate([part[ORDER:] for part in parts])


def _beside_pushes(
    rows: BandRows, settings: DiagnosisSettings
) -> tuple[list[LibraryResidual], BoolArray]:
    """
    Return what all candidates leave, and beside it what they leave where nothing pushes.

    A push bends the fit in which it is found. The rows of all stretches (rows, n) that pushes
    spoil are told as well.
    """
    left = [library_residual(rows)]
    pushed = pushed_rows(rows, left[0].left, settings.tolerance)
    if pushed.any():
        left.append(library_residual(rows, pushed))
    return left, pushed
