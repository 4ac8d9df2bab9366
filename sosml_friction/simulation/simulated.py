# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a simulation says."""

from dataclasses import dataclass

from sosml_friction.arrays import FloatArray


@dataclass(frozen=True)
class Simulated:
    """
    Hold position, velocity and effort at each sample, of one shape [rad or m, per s, Nm or N].

    (W, L, n) of windows of several joints, (N,) of one joint. ``effort`` is what a simulated
    controller asked for, None where measured effort drove the simulation.
    """

    q: FloatArray
    v: FloatArray
    effort: FloatArray | None = None
