# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the bodies of a model are off by, within their tolerance, where the model keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.regression.evidence import UNIFORM, Fit
from sosml_friction.regression.whitened import WhitenedRegression


@dataclass(frozen=True)
class BodyDoubt:
    """
    Hold what a recording says of bodies that the model keeps: what they are off by.

    ``rigid`` (p,): which numbers, ten of each body and then the rotors; ``mean`` (p,) of what they
    are off by, given the recording; ``roots`` (p, k): R with R R' its covariance.
    """

    rigid: IndexArray
    mean: FloatArray
    roots: FloatArray

    @classmethod
    def of(
        cls,
        laboratory: WhitenedRegression,
        fit: Fit,
        armature: Mapping[str, Parameter],
    ) -> BodyDoubt:
        """
        Return the doubt that a regression leaves, each number anywhere in its tolerance.

        :param armature: by joint, that of the model for rotors that were fitted: beside bodies
            that are off by ``mean`` it is another one. What it is unsure by is said with it.
        """
        nominal, prior = laboratory.nominal, fit.system.prior_weight()
        columns = nominal.rigid_columns
        known = prior[columns] > 0.0
        own = columns[known]
        weight = prior.copy()
        weight[own] /= UNIFORM
        mean, P, _ = _posterior(fit, rows_worth(laboratory, fit, own, weight), weight)
        P = P[np.ix_(own, own)]
        size = np.sqrt(np.diag(P))
        values, vectors = np.linalg.eigh(P / size / size[:, None])
        roots = np.zeros((len(columns), len(own)))
        roots[known] = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
        off, robot = mean[columns], laboratory.robot
        for k in np.flatnonzero(~known):
            joint = int(nominal.rigid[k]) - 10 * robot.n
            its = armature[robot.names[joint]]
            off[k] += robot.armature[joint] - its.value
        return cls(nominal.rigid, off, roots)

    def efforts(self, robot: Robot, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return what these bodies add to friction, (N, n, 1 + p): the mean, then each root."""
        off = np.column_stack([self.mean, self.roots])
        bodies, count = self.rigid < 10 * robot.n, 10 * robot.n
        Y = robot.torque_regressors(q, v, a)[:, :, self.rigid[bodies]]
        result = -Y @ off[bodies]
        for joint, root in zip(self.rigid[~bodies] - count, off[~bodies], strict=True):
            result[:, joint] -= a[:, joint, None] * root
        return np.asarray(result)


def rows_worth(
    laboratory: WhitenedRegression, fit: Fit, of: IndexArray, weight: FloatArray
) -> float:
    """
    Return what a row of a regression is worth, 1 where noise alone is left.

    What is left beyond the noise makes it less, and not the tolerance. So does what the blocks of
    the recording say, each by its own sum of scores: what else the model lacks, such as cogging,
    pulls at the parameters ``of`` in different ways.

    :param weight: of the tolerances, one over a variance (p,).
    """
    worth = 1.0 / max(fit.baseline.cost / float(laboratory.noise_energy.sum()), 1.0)
    _, P, between = _posterior(fit, worth, weight)
    return worth / float(np.max(between[of] / np.diag(P)[of], initial=1.0))


def _posterior(
    fit: Fit, worth: float, weight: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mean (p,), covariance, and variances (p,) of the blocks; a row is of ``worth``."""
    A = worth * fit.system.total + np.diag(
        fit.system.penalty() - fit.system.prior_weight() + weight
    )
    scale = 1.0 / np.sqrt(np.diag(A))
    inverse = np.linalg.inv(A * scale * scale[:, None]) * scale * scale[:, None]
    r = fit.target.r.sum(axis=0)
    mean = worth * inverse @ r.sum(axis=0)
    scores = worth * (r - np.einsum('nbpq,q->bp', fit.system.G, mean))
    spread = (scores - scores.mean(axis=0)) @ inverse
    between = np.sum(spread**2, axis=0) * len(scores) / (len(scores) - 1)
    return mean, inverse, between
