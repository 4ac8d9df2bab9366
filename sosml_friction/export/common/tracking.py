# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint that follows a recorded motion under control, with friction that sticks."""

from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled

#: Bandwidth [rad/s] and damping ratio of the loop where no gains are recorded: of an actuator's
#: own position loop. Chosen: along T1 the stated error is within a fifth of MuJoCo's for loops
#: of 25 to 50 rad/s, python -m validation.mujoco_round_trip.
_BANDWIDTH, _DAMPING = 50.0, 1.0
#: Points of the tables of friction over speed, and the speed about which they are dense, as a
#: share of the top speed.
_POINTS, _DENSE = 401, 1e-4


class Law(NamedTuple):
    """
    Hold the friction of one joint along a motion of N samples.

    At sample k and velocity v, ``level[k] + level_v(v)`` opposes motion and
    ``both[k] + both_v(v)`` acts in both directions alike; the latter of each pair are tables over
    ``asinh(v / dense)``, evenly up to ``top`` in both directions [Nm or N].
    """

    level: FloatArray
    both: FloatArray
    level_v: FloatArray
    both_v: FloatArray
    top: float

    @staticmethod
    def speeds(top: float) -> FloatArray:
        """Return the speeds of the tables."""
        dense = _DENSE * top
        most = np.arcsinh(top / dense)
        return np.asarray(dense * np.sinh(np.linspace(-most, most, _POINTS)))


class Path(NamedTuple):
    """Hold position, velocity and acceleration (N,), the step [s] and what is controlled."""

    q: FloatArray
    v: FloatArray
    a: FloatArray
    step: float
    inertia: float
    gains: tuple[float, float] | None = None


def follow(path: Path, law: Law) -> tuple[FloatArray, FloatArray]:
    """
    Return the effort (N,) that follows a path, and friction (N,), both [Nm or N].

    J x'' = u - friction, u = J a + kp (q - x) + kd (v - x'), from the path's state. What opposes
    motion takes at most what stops the joint within a step: it sticks.
    """
    inertia = path.inertia
    kp, kd = path.gains or (inertia * _BANDWIDTH**2, 2.0 * _DAMPING * inertia * _BANDWIDTH)
    # Half of the time constant of what is fastest, at most.
    fastest = max(np.sqrt(kp / inertia), kd / inertia)
    parts = max(1, int(np.ceil(path.step * fastest / 0.5)))
    return _follow(path.q, path.v, path.a, path.step, parts, inertia, kp, kd, *law,
                   _DENSE * law.top)  # fmt: skip


@compiled
def _follow(
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    step: float,
    parts: int,
    inertia: float,
    kp: float,
    kd: float,
    level: FloatArray,
    both: FloatArray,
    level_v: FloatArray,
    both_v: FloatArray,
    top: float,
    dense: float,
) -> tuple[FloatArray, FloatArray]:
    """Return effort and friction (N,) along the path, friction sticking within each step."""
    effort, friction = np.empty(len(q)), np.empty(len(q))
    x, w, h = q[0], v[0], step / parts
    most, last = np.arcsinh(top / dense), len(level_v) - 1
    for k in range(len(q)):
        spent = 0.0
        u = inertia * a[k] + kp * (q[k] - x) + kd * (v[k] - w)
        for _ in range(parts):
            place = 0.5 * last * (1.0 + np.arcsinh(w / dense) / most)
            place = min(max(place, 0.0), last - 1e-9)
            i = int(place)
            share = place - i
            opposing = level[k] + (1.0 - share) * level_v[i] + share * level_v[i + 1]
            alike = both[k] + (1.0 - share) * both_v[i] + share * both_v[i + 1]
            free = w + h * (u - alike) / inertia
            most_change = max(opposing, 0.0) * h / inertia
            after = np.sign(free) * max(abs(free) - most_change, 0.0)
            spent += inertia * (free - after) / h + alike
            w = after
            x += h * w
        effort[k], friction[k] = u, spent / parts
    return effort, friction
