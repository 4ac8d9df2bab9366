# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The one sign function: regressors, predictions and simulation all use it."""

import numpy as np
from numpy.typing import ArrayLike

from sosml_friction.arrays import FloatArray


def smooth_sign(v: ArrayLike, smoothing_velocity: float) -> FloatArray:
    """
    Return tanh(v / v0), or sgn(v) with sgn(0) = 0 where v0 = 0.

    :param v: velocity [rad/s or m/s], any shape.
    :param smoothing_velocity: v0 >= 0, same unit: |v| = 3 v0 gives 99.5 % of the sign.
    """
    v = np.asarray(v, dtype=float)
    if smoothing_velocity == 0.0:
        return np.sign(v)
    return np.tanh(v / smoothing_velocity)


def softened(z: FloatArray, v: FloatArray, smoothing_velocity: float) -> FloatArray:
    """
    Return z tanh(|v| / v0): a state of friction along a path, whose sign is smooth besides.

    z itself where v0 = 0; tanh(v / v0) where z follows the sign of motion at once.
    """
    if smoothing_velocity == 0.0:
        return z
    return np.asarray(z * np.abs(smooth_sign(v, smoothing_velocity)))
