# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How wrong the model is in ways that are in no catalogue: what impossible candidates explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.regression.evidence import CandidateColumns, Fit


@dataclass(frozen=True)
class Misfit:
    """
    Hold the impossible candidates of a round, beside the fit ``fit``, most energy first.

    The best of them shows what a wrong model looks like: a cause explains as much, in the joints
    that it acts in. What is wrong in another joint says nothing of it.
    """

    fit: Fit
    impossible: Sequence[Finding]

    @classmethod
    def make(cls, fit: Fit, impossible: Sequence[Finding]) -> Misfit:
        """Return them in order."""
        return cls(fit, sorted(impossible, key=lambda finding: -finding.score.energy))

    def floor(self, finding: Finding) -> float:
        """
        Return the floor of a candidate, as a share of the held-out energy of its joints.

        The most that an impossible one removes there, less the standard error of the candidate.
        """
        if finding.score.energy <= 0.0:
            return 0.0
        most = 0.0
        for other in self.impossible:
            if other.score.energy <= most:
                break
            most = max(most, other.score.energy * self._share(other, finding.columns.rows))
        share = finding.score.cv_gain / finding.score.energy
        return most * share - finding.score.cv_se

    def _share(self, finding: Finding, joints: IndexArray) -> float:
        """Return the share of what a candidate explains that it explains in some joints."""
        own = finding.columns.rows
        if not np.isin(own, joints).any():
            return 0.0
        if np.isin(own, joints).all():
            return 1.0
        s = finding.score
        k = s.best if finding.columns.C.shape[2] > 1 else 0
        gains = explained(self.fit, finding.columns, k, s.x, s.amplitude)
        gains = np.maximum(gains, 0.0)
        return float(gains[joints].sum() / max(gains.sum(), np.finfo(float).tiny))


def explained(
    fit: Fit, columns: CandidateColumns, point: int, x: FloatArray, amplitude: FloatArray
) -> FloatArray:
    """
    Return by how much the sum of squares of each joint (n,) falls with a candidate.

    :param point: which of the columns' grid.
    :param x: the system's parameters (p,) beside it.
    """
    r, before = fit.target.r.sum(axis=1), fit.baseline.x
    G = fit.system.G.sum(axis=1)
    result = 2.0 * r @ (x - before) + before @ G @ before - x @ G @ x
    for i, joint in enumerate(columns.rows):
        made = np.asarray(columns.C[:, i, point], np.float64) @ amplitude
        left = fit.target.y[:, joint] - fit.system.Z[:, joint] @ x
        result[joint] += 2.0 * float(made @ left) - float(made @ made)
    return np.asarray(result)
