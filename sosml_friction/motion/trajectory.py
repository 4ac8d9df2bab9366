# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint trajectory: what a planner makes and a driver follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from sosml_friction.exceptions import TrajectoryError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """
    Hold knots of position and velocity, joined by cubic Hermite polynomials.

    ``t`` (K,) [s] from 0, increasing; ``q`` (K, n) [rad or m]; ``v`` (K, n) [rad/s or m/s].

    :raises TrajectoryError: if shapes disagree, a number is not finite, or time does not increase.
    """

    names: tuple[str, ...]
    t: FloatArray
    q: FloatArray
    v: FloatArray

    def __post_init__(self) -> None:
        shape = (len(self.t), len(self.names))
        if self.q.shape != shape or self.v.shape != shape or len(self.t) < 2:
            raise TrajectoryError(
                f'the trajectory has {len(self.t)} times for {len(self.names)} joints but '
                f'positions {self.q.shape} and velocities {self.v.shape}: give each joint both at '
                'two or more times'
            )
        for what in ('t', 'q', 'v'):
            if not np.isfinite(getattr(self, what)).all():
                raise TrajectoryError(f'the trajectory holds a {what} that is not finite')
        if not (np.diff(self.t) > 0.0).all():
            k = int(np.argmin(np.diff(self.t))) + 1
            raise TrajectoryError(f'the trajectory goes back in time at point {k} ({self.t[k]} s)')

    @property
    def duration(self) -> float:
        """Return the time of the last knot [s]."""
        return float(self.t[-1])

    def spline(self) -> CubicHermiteSpline:
        """Return the position as a function of time; its derivative is the velocity."""
        return CubicHermiteSpline(self.t, self.q, self.v)
