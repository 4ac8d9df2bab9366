# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A soft end to each joint's range, made of torque."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.robot import JointLimits


class SoftStop:
    """
    Let the effort outward fade beyond a joint's limit, and brake what cannot stop in time.

    x = q + v |v| / (2 a) is where the joint would come to rest at the deceleration a. Beyond the
    upper limit the effort upward may be at most (1 - s) of the actuator's greatest, with
    s = (x - upper) / margin, clipped to 0..1; and a joint still moving upward is damped by
    s * kd * v besides. Mirrored at the lower limit; inside the limits it changes nothing. At
    limit + margin no effort outward is left, and the driver takes it for a fault.

    :param effort: the greatest of each actuator (n,) [Nm or N].
    :param kd: (n,) [Nm s/rad or N s/m].
    :param deceleration: a > 0 [rad/s^2 or m/s^2].
    :param margin: [rad or m]; 0 ends the effort at the limit itself.
    """

    def __init__(
        self,
        limits: Sequence[JointLimits],
        effort: FloatArray,
        kd: FloatArray,
        deceleration: float,
        margin: float,
    ) -> None:
        self._lower = np.array([own.lower for own in limits])
        self._upper = np.array([own.upper for own in limits])
        self._bounds = [(own.lower, own.upper) for own in limits]
        self._effort = np.array(effort, dtype=float)
        self._kd = np.array(kd, dtype=float)
        self._deceleration = deceleration
        # A margin of nothing is still a width to divide by.
        self._margin = max(margin, 1e-6)

    def limit(self, tau: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return ``tau`` (n,) [Nm or N] as it may be at ``q`` and ``v``; NaN stays NaN."""
        share = 0.5 / self._deceleration
        # Plain floats: nearly always nothing is to be done, five times as fast as arrays say so.
        if all(
            low <= x + share * w * abs(w) <= high
            for x, w, (low, high) in zip(q.tolist(), v.tolist(), self._bounds, strict=True)
        ):
            return tau
        rest = q + share * v * np.abs(v)
        up = np.clip((rest - self._upper) / self._margin, 0.0, 1.0)
        down = np.clip((self._lower - rest) / self._margin, 0.0, 1.0)
        high = np.where(up > 0.0, (1.0 - up) * self._effort, np.inf)
        low = np.where(down > 0.0, -(1.0 - down) * self._effort, -np.inf)
        damping = self._kd * (up * np.maximum(v, 0.0) + down * np.minimum(v, 0.0))
        return np.clip(tau, low, high) - damping
