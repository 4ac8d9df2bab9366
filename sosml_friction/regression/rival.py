# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How likely another equation of the same term is."""

from scipy.special import expit


def rival_probability(excess: float) -> float:
    """
    Return the probability of the second of two equations that were as likely beforehand.

    1 / (1 + exp(excess / 2)), with ``excess`` its sum of squares above that of the first, in
    variances of the noise.
    """
    return float(expit(-0.5 * excess))
