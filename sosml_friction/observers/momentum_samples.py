# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What observers are driven by: momentum and forcing, interval by interval."""

from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray

#: h, p, integral, forcing and inertia, as compiled functions take them.
Columns = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


# Frozen would make it slow to make, which is done for every sample on line.
@dataclass(slots=True)
class MomentumSamples:
    """
    Hold N consecutive intervals of n joints; row k is the interval that ends at sample k.

    The momentum p = M q' comes with whatever noise the velocity has. ``integral`` is the same
    information before it was differentiated, the integral of M dq over the interval, in which the
    noise of an encoder is white after summing.

    :param h: length of each interval, (N,) [s], positive.
    :param p: momentum at the end of each interval, (N, n) [Nm s or N s].
    :param integral: 1/2 (M_{k-1} + M_k) (q_k - q_{k-1}), (N, n) [Nm s2 or N s2].
    :param forcing: mean of tau + C^T q' - g over each interval, (N, n) [Nm or N]; NaN where the
        effort is not known.
    :param inertia: M at the end of each interval, (N, n, n) [kg m2 or kg].
    """

    h: FloatArray
    p: FloatArray
    integral: FloatArray
    forcing: FloatArray
    inertia: FloatArray

    @property
    def columns(self) -> Columns:
        """Return h, p, integral, forcing and inertia."""
        return self.h, self.p, self.integral, self.forcing, self.inertia

    @property
    def mobility(self) -> FloatArray:
        """Return M^-1 at the end of each interval, (N, n, n) [1/(kg m2) or 1/kg]."""
        return np.asarray(np.linalg.inv(self.inertia), dtype=np.float64)

    def __len__(self) -> int:
        """Return the number of intervals."""
        return len(self.h)
