# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What every test takes for chance, and every comparison for nothing."""

from scipy.stats import norm

#: Probability with which a test sees what is not there: once in a hundred recordings. By
#: convention.
CHANCE = 0.01
#: A change of more standard errors than this is beyond chance: one-sided, of a normal
#: distribution. A right cause that is too fast to show in 0.3 s stays below it.
BEYOND_CHANCE = round(float(norm.isf(CHANCE)), 2)
#: Bound of what varies by chance, in standard deviations: 99.7 % of a normal distribution are
#: within.
SIGMAS = 3.0
#: Share of an energy, a range of motion or a load that is as good as none of it. Halved and
#: doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes.
NEGLIGIBLE = 0.02
#: Fewest numbers whose usual size is known: their root mean square to 1 / sqrt(2 20) = 16 %, their
#: median absolute deviation to 25 %.
FEWEST = 20
