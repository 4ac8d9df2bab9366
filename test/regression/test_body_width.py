# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The evidence of a tolerance is that of the Gaussian model it stands for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from sosml_friction.regression.body_width import _log_evidence


def test_the_log_evidence_is_that_of_the_marginal_normal_distribution():
    """y = Z x + e, x ~ N(0, P), e ~ N(0, 1): y ~ N(0, 1 + Z P Z'), up to a constant of y."""
    rng = np.random.default_rng(4)
    Z, y = rng.normal(size=(30, 3)), rng.normal(size=30)
    values, exact = [], []
    for scale in (0.01, 0.3, 4.0):
        prior = scale**2 * np.array([1.0, 0.5, 2.0])
        values.append(_log_evidence(Z.T @ Z, Z.T @ y, 1.0 / prior))
        whole = np.eye(30) + Z @ np.diag(prior) @ Z.T
        exact.append(multivariate_normal.logpdf(y, np.zeros(30), whole))
    assert np.diff(values) == pytest.approx(np.diff(exact), rel=1e-9)
