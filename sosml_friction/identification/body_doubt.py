# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What friction is unsure by where the bodies of a model are only known within a tolerance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.robot import Robot
from sosml_friction.regression.evidence import UNIFORM, Fit
from sosml_friction.regression.whitened import WhitenedRegression


@dataclass(frozen=True)
class BodyDoubt:
    """
    Hold what a recording leaves open of bodies that are used as the model has them.

    ``rigid`` (p,): which numbers, ten of each body and then the rotors; ``roots`` (p, p + 1): R
    with R R' = b b' + P, b and P mean and covariance of what they are off by, given the recording.
    """

    rigid: IndexArray
    roots: FloatArray

    @classmethod
    def of(cls, laboratory: WhitenedRegression, fit: Fit) -> BodyDoubt:
        """Return the doubt that a regression leaves, each number anywhere in its tolerance."""
        nominal, prior = laboratory.nominal, fit.system.prior_weight()
        # A rotor of which nothing is known is fitted, and its variance is said with it.
        known = prior[nominal.rigid_columns] > 0.0
        own = nominal.rigid_columns[known]
        weight = prior.copy()
        weight[own] /= UNIFORM
        # What is left beyond the noise makes the rows worth less, and not the tolerance.
        more = max(fit.baseline.cost / float(laboratory.known.sum()), 1.0)
        A = fit.system.total / more + np.diag(fit.system.penalty() - prior + weight)
        r = fit.target.r.sum(axis=(0, 1)) / more
        scale = 1.0 / np.sqrt(np.diag(A))
        inverse = np.linalg.inv(A * scale * scale[:, None])
        mean, covariance = scale * (inverse @ (r * scale)), inverse * scale * scale[:, None]
        P = covariance[np.ix_(own, own)]
        size = np.sqrt(np.diag(P))
        values, vectors = np.linalg.eigh(P / size / size[:, None])
        spread = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
        return cls(nominal.rigid[known], np.column_stack([mean[own], spread]))

    def efforts(self, robot: Robot, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return what each column of ``roots`` adds to the friction of a motion, (N, n, p + 1)."""
        bodies, count = self.rigid < 10 * robot.n, 10 * robot.n
        Y = robot.torque_regressors(q, v, a)[:, :, self.rigid[bodies]]
        result = -Y @ self.roots[bodies]
        for joint, root in zip(self.rigid[~bodies] - count, self.roots[~bodies], strict=True):
            result[:, joint] -= a[:, joint, None] * root
        return np.asarray(result)
