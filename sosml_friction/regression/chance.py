# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What every test takes for chance, and every comparison for nothing."""

from scipy.stats import norm

#: Probability with which a test sees what is not there: once in a hundred recordings. By
#: convention.
CHANCE = 0.01
#: A change of more standard errors than this is beyond chance: one-sided, of a normal
#: distribution. A right cause that is too fast to show in 0.3 s stays below it.
BEYOND_CHANCE = float(norm.isf(CHANCE))
