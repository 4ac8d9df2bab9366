# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The cubic B-spline that the weak form's test functions are."""

import numpy as np

from sosml_friction.arrays import FloatArray


def cubic_spline(x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Return the cubic B-spline of the knots -2, -1, 0, 1, 2 at x, and its integral from -2 to x.

    ((2 - |x|)_+^3 - 4 (1 - |x|)_+^3) / 6, whose whole integral is 1.
    """
    far = np.abs(x)
    outer, inner = np.maximum(2.0 - far, 0.0), np.maximum(1.0 - far, 0.0)
    cubes, inner_cubes = outer * outer * outer, 4.0 * inner * inner * inner
    beyond = (cubes * outer - inner_cubes * inner) / 24.0
    return (cubes - inner_cubes) / 6.0, np.where(x > 0.0, 1.0 - beyond, beyond)
