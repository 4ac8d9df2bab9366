# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What one completed cycle measured."""

from dataclasses import dataclass

from sosml_friction.arrays import FloatArray


@dataclass(frozen=True)
class JointSample:
    """
    Hold what one completed cycle measured, joints in the driver's order.

    ``stamp_ns``: when the cycle's last position was asked for, on the driver's clock;
    ``joint_ns``: of each joint's. ``q`` [rad or m], ``v`` [rad/s or m/s], ``tau`` [Nm or N], the
    mean since the sample before, each (n,); NaN is not known: v until its window is full, tau
    where the actuator measures no current.
    """

    stamp_ns: int
    joint_ns: tuple[int, ...]
    q: FloatArray
    v: FloatArray
    tau: FloatArray

    @property
    def skew_ns(self) -> int:
        """Return the time between the first and the last position of the cycle [ns]."""
        return max(self.joint_ns) - min(self.joint_ns)
