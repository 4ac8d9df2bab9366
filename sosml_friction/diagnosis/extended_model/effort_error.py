# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How much effort is not explained on data left out of the fit, with any of the causes."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.regression.evidence import Baseline, Fit
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.whitened import WhitenedRegression


@dataclass(frozen=True)
class HeldOut:
    """
    Hold data left out of the fit, in the band: rows of n joints [Nm or N].

    ``residual`` (rows, n): of the nominal model; ``nominal`` (rows, n, p): its columns;
    ``columns``: those of a finding (rows, n, k); ``measured``: the effort itself, without what
    joints at rest may take, as the residual is; ``fold`` (rows,): whose fit did not see a row, or
    None where no fit saw any; ``on``: which data were left out, for the report.
    """

    residual: FloatArray
    nominal: FloatArray
    columns: Callable[[Finding], FloatArray]
    measured: FloatArray
    fold: IndexArray | None
    on: str

    def error(self, baseline: Baseline, findings: Sequence[Finding]) -> FloatArray:
        """Return measured minus predicted effort (rows, n) of a fit with these findings."""
        wide = np.concatenate([self.nominal, *map(self.columns, findings)], axis=2)
        if self.fold is None:
            return np.asarray(self.residual - wide @ baseline.x)
        return self.residual - np.einsum('rnp,rp->rn', wide, baseline.fold_x[self.fold])


def folds_left_out(laboratory: WhitenedRegression) -> HeldOut:
    """
    Return the folds of the recordings, each for the fit without it.

    Rows of contacts are zero, as no model has these.
    """
    y, Z = laboratory.unwhitened()
    told = np.asarray(~laboratory.contacts.mask, dtype=np.float64)
    blocks = laboratory.blocks
    fold = np.empty(len(y), dtype=np.int64)
    for own, (first, last) in zip(blocks.fold, itertools.pairwise(blocks.edges), strict=True):
        fold[first:last] = own

    def columns(finding: Finding) -> FloatArray:
        own = laboratory.own_columns(finding.effect, finding.joint, finding.inner)
        return own * told[:, :, None]

    measured = laboratory.measured_in_motion() * told
    return HeldOut(y * told, Z * told[:, :, None], columns, measured, fold, 'folds left out')


def another_recording(laboratory: WhitenedRegression, others: Sequence[Signals]) -> HeldOut:
    """Return the stretches of another recording, for the fit to all data."""

    def columns(finding: Finding) -> FloatArray:
        return np.concatenate(
            [s.in_band(finding.effect.columns(s, finding.joint, finding.inner)) for s in others]
        )

    residual, nominal, measured = (
        np.concatenate([s.in_band(make(s)) for s in others])
        for make in (lambda s: s.unexplained, laboratory.nominal.columns, lambda s: s.tau)
    )
    return HeldOut(residual, nominal, columns, measured, None, 'another recording')


def stages(
    held: HeldOut, laboratory: WhitenedRegression, found: Selection
) -> list[dict[str, Any]]:
    """Return the relative effort error [%] by joint on folds left out, after each cause."""
    size = np.linalg.norm(held.measured, axis=0)
    names = laboratory.robot.names
    result = []
    for k in range(len(found.accepted) + 1):
        done = found.accepted[:k]
        effect, joint = done[-1].reported(names) if done else (None, None)
        system = laboratory.system.extended([f.columns for f in done])
        left = held.error(Fit.make(system, laboratory.y).baseline, done)
        error = 100.0 * np.linalg.norm(left, axis=0) / size
        result.append(
            {
                'effect': effect,
                'joint': joint,
                'relative_error_percent': dict(zip(names, error.tolist(), strict=True)),
            }
        )
    return result
