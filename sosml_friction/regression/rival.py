# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How likely another equation is, and from when on it is."""

from scipy.special import expit

#: Twice the logarithm of the ratio of two evidences, or the difference of two BIC, from which it
#: is very strong: a ratio of exp(10 / 2) = 148 (R. E. Kass, A. E. Raftery, Bayes Factors, J. Am.
#: Stat. Assoc. 90, 1995). What differs by less is not told apart.
VERY_STRONG = 10.0


def rival_probability(excess: float) -> float:
    """
    Return the probability of the second of two equations that were as likely beforehand.

    1 / (1 + exp(excess / 2)), with ``excess`` its sum of squares above that of the first, in
    variances of the noise.
    """
    return float(expit(-0.5 * excess))
