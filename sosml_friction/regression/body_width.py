# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How far the rigid body of a model may be off, told or chosen from the data."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student_t

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.regression.chance import CHANCE
from sosml_friction.regression.evidence import Fit, System
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.whitened import WhitenedRegression

#: Tolerances that are tried beside the usual one, as shares of the model's own numbers: half a
#: decade apart, over which the evidence changes little, up to bodies that say nothing.
WIDTHS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)


@dataclass(frozen=True)
class BodyWidth:
    """
    Say how far each number of the rigid body may be off, as a share of itself.

    ``log_evidence``: log p(data | tolerance) - log p(data | the usual one), by tolerance; empty
    where the tolerance was told.
    """

    tolerance: float
    log_evidence: Mapping[float, float]

    @property
    def is_wider(self) -> bool:
        """Tell whether the data contradict the model's bodies within their usual tolerance."""
        return self.log_evidence.get(self.tolerance, 0.0) > 0.0


def check_tolerance(tolerance: float) -> None:
    """
    Refuse a tolerance that is none.

    :raises ConfigurationError: if it is negative or no number.
    """
    if not (math.isfinite(tolerance) and tolerance >= 0.0):
        raise ConfigurationError(
            f'the tolerance of the rigid body is {tolerance:g}: give a share, such as 0.3'
        )


def choose_width(laboratory: WhitenedRegression, system: System) -> BodyWidth:
    """
    Return the tolerance with the largest evidence, the usual one unless another is far better.

    Far better: very strongly by evidence, and on stretches that are left out of the fit.

    With Gaussian priors N(0, (tolerance / 3 times its number)^2) of the rigid body, evidence of
    the whitened rows y = Z x + e is Gaussian in closed form:
    2 log p = r' A^-1 r / s - log det A + sum log(prior), A = Z'Z / s + prior, r = Z'y / s.
    s is the noise's variance: 1 in whitened rows, more where the widest model leaves more.

    :param system: the laboratory's, with the columns of the terms that are fitted beside.
    """
    usual = laboratory.settings.tolerance
    target = Fit.make(system, laboratory.y).target
    G, r, yy = system.total, target.r.sum(axis=(0, 1)), float(target.yy.sum())
    widths = [usual, *(w for w in WIDTHS if w > usual)]
    count = float(laboratory.noise_energy.sum())
    prior = {w: _with_prior(laboratory, system, w).penalty() for w in widths}
    widest = np.diag(prior[widths[-1]])
    s = max(float(yy - r @ np.linalg.solve(G + widest, r)) / count, 1.0)
    evidence = {w: _log_evidence(G / s, r / s, prior[w]) for w in widths}
    evidence = {w: value - evidence[usual] for w, value in evidence.items()}
    best = max(evidence, key=lambda w: evidence[w])
    # The best of several is taken.
    wider = 2.0 * evidence[best] > VERY_STRONG + 2.0 * math.log(len(widths) - 1)
    wider = wider and _predicts(laboratory, system, best)
    return BodyWidth(best if wider else usual, evidence)


def _predicts(laboratory: WhitenedRegression, system: System, tolerance: float) -> bool:
    """
    Tell whether wider bodies predict stretches that they were not fitted to better, beyond chance.

    Evidence takes what no term explains for noise; a model that lacks something else would widen
    the bodies as well. By Student's t of the gain over the folds, one-sided at 1 %.
    """
    held_out = [
        Fit.make(_with_prior(laboratory, system, w), laboratory.y).baseline.held_out.sum(axis=0)
        for w in (laboratory.settings.tolerance, tolerance)
    ]
    gain = held_out[0] - held_out[1]
    error = float(np.std(gain, ddof=1)) / math.sqrt(len(gain))
    # Of six recordings of a busy machine, whose holes no body explains, a chance of 5 % let one
    # through (`python -m validation.busy --load 2 --runs 6` tells of each).
    return float(gain.mean()) > float(student_t.isf(CHANCE, len(gain) - 1)) * error


def with_width(laboratory: WhitenedRegression, tolerance: float) -> WhitenedRegression:
    """Return the regression with another tolerance of the rigid body."""
    nominal = laboratory.nominal
    factor = np.ones(len(nominal.bound))
    factor[nominal.rigid_columns] = tolerance / laboratory.settings.tolerance
    # What the model does not know has no tolerance.
    factor[np.isinf(nominal.bound)] = 1.0
    nominal = replace(nominal, bound=nominal.bound * factor, prior=nominal.prior * factor)
    system = replace(laboratory.system, bound=nominal.bound, prior=nominal.prior)
    rows = replace(laboratory.rows, nominal=nominal)
    return replace(laboratory, rows=rows, system=system)


def _with_prior(laboratory: WhitenedRegression, system: System, tolerance: float) -> System:
    """Return the system with that tolerance of the bodies."""
    wide = with_width(laboratory, tolerance).system
    free = np.full(system.Z.shape[2] - len(wide.bound), np.inf)
    bound, prior = np.concatenate([wide.bound, free]), np.concatenate([wide.prior, free])
    return replace(system, bound=bound, prior=prior)


def _log_evidence(G: FloatArray, r: FloatArray, prior: FloatArray) -> float:
    scale = 1.0 / np.sqrt(np.diag(G) + prior)
    A = (G + np.diag(prior)) * scale * scale[:, None]
    _, size = np.linalg.slogdet(A)
    b = r * scale
    explained = float(b @ np.linalg.solve(A, b))
    return 0.5 * (explained - float(size) + float(np.log(prior * scale**2).sum()))


def body_precision(system: System, rigid: IndexArray) -> FloatArray:
    """Return the inverse covariance of the rigid body (p, p), all else fitted beside it."""
    A = system.total + np.diag(system.penalty())
    others = np.setdiff1d(np.arange(len(A)), rigid)
    across = A[np.ix_(others, rigid)]
    return np.asarray(
        A[np.ix_(rigid, rigid)] - across.T @ np.linalg.solve(A[np.ix_(others, others)], across)
    )


def body_variance(system: System, rigid: IndexArray, index: int, worth: float = 1.0) -> float:
    """
    Return the variance that not knowing the rigid body adds to a parameter.

    Its variance in the fit less that with the bodies held where the fit has them.

    :param worth: of a row, 1 where noise alone is left.
    """
    A = worth * system.total + np.diag(system.penalty())
    scale = 1.0 / np.sqrt(np.diag(A))
    A = A * scale * scale[:, None]
    held = np.setdiff1d(np.arange(len(A)), rigid)
    full = np.linalg.inv(A)[index, index]
    at = int(np.searchsorted(held, index))
    alone = np.linalg.inv(A[np.ix_(held, held)])[at, at]
    return float(max(full - alone, 0.0) * scale[index] ** 2)
