# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a parameter changes from recording to recording, and how fast."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.jackknife import t_95

_DAY = 86400e9
#: Fewest recordings that a line and the scatter about it can be told from.
_FEWEST = 3
#: Least standard error as a share of the largest: weights are then 1e12 apart, and sums of them
#: exact to 1e-4.
_SURER = 1e-6


@dataclass(frozen=True)
class Drift:
    """
    Hold the change of a parameter per day.

    ``slope`` and ``half_width`` of its 95 % interval, in its unit per day; ``scatter``: standard
    deviation between recordings beyond their own errors and the line; ``count`` recordings.
    """

    slope: float
    half_width: float
    scatter: float
    count: int

    @property
    def is_shown(self) -> bool:
        """Tell whether the interval leaves out 0."""
        return abs(self.slope) > self.half_width


def drift_of(dates_ns: FloatArray, values: FloatArray, errors: FloatArray) -> Drift | None:
    """
    Fit a line over time to values (K,) with standard errors (K,).

    Weighted by 1 / (error^2 + scatter^2), with the scatter between recordings by DerSimonian and
    Laird's moment estimate about the line (Controlled Clinical Trials 7, 1986, for a regression).
    The interval has Student's t of K - 2 degrees of freedom. None of fewer than three recordings,
    or where all are of one time.
    """
    known = np.isfinite(values) & np.isfinite(errors) & (errors > 0.0)
    days = (dates_ns[known] - dates_ns.min()) / _DAY
    y, s = values[known], errors[known]
    if len(y) < _FEWEST or not np.ptp(days) > 0.0:
        return None
    # Surer than that, one recording would leave nothing of the others but rounding errors.
    s = np.maximum(s, max(_SURER * float(s.max()), float(np.spacing(np.abs(y).max()))))
    unit = float(s.max())
    y, s = y / unit, s / unit
    X = np.column_stack([np.ones_like(days), days])

    def solved(w: FloatArray) -> tuple[FloatArray, FloatArray]:
        covariance = np.linalg.inv(X.T @ (w[:, None] * X))
        return covariance @ X.T @ (w * y), covariance

    w = s**-2.0
    theta, covariance = solved(w)
    cost = float(np.sum(w * (y - X @ theta) ** 2))
    expected = len(y) - 2.0
    room = float(np.sum(w) - np.trace(covariance @ X.T @ ((w**2)[:, None] * X)))
    scatter = np.sqrt(max(cost - expected, 0.0) / room)
    theta, covariance = solved(1.0 / (s**2 + scatter**2))
    quantile = t_95(len(y) - 2)
    half = quantile * float(np.sqrt(covariance[1, 1]))
    return Drift(unit * float(theta[1]), unit * half, unit * float(scatter), len(y))
