# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The profile of the cost over the Stribeck velocity, and what it leaves open."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.fading_term import fade


@dataclass(frozen=True)
class LawProfile:
    """
    Hold the profile of the cost.

    ``excess`` (K,) is the least cost at each ``stribeck_velocity`` (K,) [rad/s or m/s] above the
    least of all, in units of the 95 % limit: up to 1 is within. ``stribeck`` (K,) is the best S
    there, ``half`` (K,) [Nm or N] half of the range of S within the limit, NaN outside, and
    ``exponent`` (K,) the best alpha, the same at all v_s where it was not found.
    """

    stribeck_velocity: FloatArray
    excess: FloatArray
    stribeck: FloatArray
    half: FloatArray
    exponent: FloatArray

    def velocity_interval(self, limits: float = 1.0) -> tuple[float, float]:
        """Return the range of v_s of an excess below ``limits``; an open end is 0 or infinite."""
        u, best = np.log(self.stribeck_velocity), int(np.argmin(self.excess))
        below = _crossing(u[: best + 1][::-1], self.excess[: best + 1][::-1] / limits)
        above = _crossing(u[best:], self.excess[best:] / limits)
        return (
            0.0 if below is None else float(np.exp(below)),
            np.inf if above is None else float(np.exp(above)),
        )

    def stribeck_interval(self, speed: float = 0.0) -> tuple[float, float]:
        """
        Return the range of S exp(-(speed / v_s)^alpha) within the limit, over all v_s; S >= 0.

        At speed 0, which is S itself, it has no upper end where v_s may be next to nothing.
        """
        within = np.isfinite(self.half)
        if not within.any():
            return 0.0, np.inf
        faded = fade(np.asarray(speed), self.stribeck_velocity[within], self.exponent[within])
        best, half = self.stribeck[within], self.half[within]
        low = float(np.min((best - half) * faded))
        high = float(np.max((best + half) * faded))
        open_ = speed == 0.0 and bool(within[0])
        return max(low, 0.0), np.inf if open_ else max(high, 0.0)

    def with_best(self, drawn: Mapping[str, float]) -> tuple[FloatArray, ...]:
        """Return v_s, excess, S and half its range, the best fit ``drawn`` among the points."""
        v, own = self.stribeck_velocity, (self.excess, self.stribeck, self.half)
        v_s, size = drawn.get('stribeck_velocity', np.nan), drawn.get('stribeck', np.nan)
        if not np.isfinite([v_s, size]).all() or np.isclose(v, v_s, rtol=1e-9, atol=0.0).any():
            return v, *own
        k = int(np.searchsorted(v, v_s))
        best = (0.0, size, self.half[min(k, len(v) - 1)])
        more = (np.insert(x, k, its) for x, its in zip(own, best, strict=True))
        return np.insert(v, k, v_s), *more


def _crossing(u: FloatArray, excess: FloatArray) -> float | None:
    """Return where ``excess``, from its least on, exceeds 1, or None."""
    # A cost is a parabola about its minimum: its root is nearly straight.
    root = np.sqrt(np.maximum(excess, 0.0))
    beyond = np.flatnonzero(root > 1.0)
    if not len(beyond):
        return None
    k = max(int(beyond[0]), 1)
    return float(u[k - 1] + (u[k] - u[k - 1]) * (1.0 - root[k - 1]) / (root[k] - root[k - 1]))
