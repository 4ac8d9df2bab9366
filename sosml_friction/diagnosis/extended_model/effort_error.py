# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How much effort is not explained on data left out of the fit, before and after the causes."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.whitened import WhitenedRegression

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class EffortError:
    """
    Hold the error of effort, measured minus predicted, in the band (rows, n) [Nm or N].

    ``before``: of the refitted nominal; ``after``: with the causes; ``measured``: the effort
    itself, without what joints at rest may take, as the errors are; ``on``: which data were left
    out, for the report.
    """

    before: FloatArray
    after: FloatArray
    measured: FloatArray
    on: str


def error_on_folds(laboratory: WhitenedRegression, selection: Selection) -> EffortError:
    """Return the error on the folds of the recordings, each predicted by the fit without it."""
    y, Z = laboratory.unwhitened()
    wide = np.concatenate([Z, *(_columns(laboratory, f) for f in selection.accepted)], axis=2)
    return EffortError(
        _left(laboratory, y, Z, selection.before.fold_x),
        _left(laboratory, y, wide, selection.after.fold_x),
        laboratory.measured_in_motion(),
        'folds left out',
    )


def error_on_recording(
    laboratory: WhitenedRegression, selection: Selection, others: Sequence[Signals]
) -> EffortError:
    """Return the error on the stretches of another recording, predicted by the fit to all data."""
    before, after, measured = [], [], []
    for s in others:
        y = s.in_band(s.tau - s.torque)
        Z = s.in_band(laboratory.nominal.columns(s))
        more = (f.effect.columns(s, f.joint, f.inner) for f in selection.accepted)
        wide = np.concatenate([Z, *(s.in_band(x) for x in more)], axis=2)
        before.append(y - Z @ selection.before.x)
        after.append(y - wide @ selection.after.x)
        measured.append(s.in_band(s.tau))
    return EffortError(
        np.concatenate(before),
        np.concatenate(after),
        np.concatenate(measured),
        'another recording',
    )


def stages(laboratory: WhitenedRegression, selection: Selection) -> list[dict[str, Any]]:
    """Return the relative effort error [%] by joint on folds left out, after each cause."""
    y, wide = laboratory.unwhitened()
    size = np.linalg.norm(laboratory.measured_in_motion(), axis=0)
    names = laboratory.robot.names
    result = []
    for k in range(len(selection.accepted) + 1):
        done = selection.accepted[:k]
        effect = joint = None
        if done:
            effect, joint = done[-1].reported(names)
            wide = np.concatenate([wide, _columns(laboratory, done[-1])], axis=2)
        system = laboratory.system.extended([f.columns for f in done])
        fit = Fit.make(system, laboratory.y)
        left = _left(laboratory, y, wide, fit.baseline.fold_x)
        error = 100.0 * np.linalg.norm(left, axis=0) / size
        result.append(
            {
                'effect': effect,
                'joint': joint,
                'relative_error_percent': dict(zip(names, error.tolist(), strict=True)),
            }
        )
    return result


def _columns(laboratory: WhitenedRegression, finding: Finding) -> FloatArray:
    return laboratory.own_columns(finding.effect, finding.joint, finding.inner)


def _left(
    laboratory: WhitenedRegression, y: FloatArray, columns: FloatArray, fold_x: FloatArray
) -> FloatArray:
    """Return y - columns @ x (rows, n), x of each row that of the fit without its fold."""
    left = y.copy()
    blocks = laboratory.blocks
    for fold, (first, last) in zip(blocks.fold, itertools.pairwise(blocks.edges), strict=True):
        left[first:last] -= columns[first:last] @ fold_x[fold]
    return left
