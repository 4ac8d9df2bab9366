# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The two reference motions of the paper's simulation study (its section IV)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sosml_friction.motion.reference import Reference

#: About which joint 1 moves, and where joint 2 is held [rad].
POSTURE = np.deg2rad([-50.0, 65.0])
#: Of ``slow`` [rad/s, s, s].
_SPEED, _TURN, _DWELL = 0.052, 3.0, 3.0
#: Of ``reversal`` [rad, rad/s].
_AMPLITUDE, _FREQUENCY = 0.35, np.pi


@dataclass(frozen=True)
class StudyMotion:
    """Name a motion: ``reference`` maps time [s] to :class:`Reference` over ``duration`` [s]."""

    identifier: str
    reference: Callable[[float], Reference]
    duration: float
    description: str


def slow(t: float) -> Reference:
    """
    Return the slow S-shape of joint 1: 3 s at +0.052 rad/s, 3 s at -0.052 rad/s, and so on.

    From one to the other the velocity is a quintic blend of 3 s; the motion starts, and after
    12 s ends, at rest in the middle of one, so that it begins and ends with half a quintic.
    """
    half_cycles, s = divmod(t + 0.5 * _TURN, _TURN + _DWELL)
    way = 1.0 if half_cycles % 2.0 == 0.0 else -1.0
    u = min(s / _TURN, 1.0)
    blend = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    rate = 30.0 * u**2 * (1.0 - u) ** 2 / _TURN
    blend_integral = _TURN * u**4 * (2.5 - 3.0 * u + u**2) + max(s - _TURN, 0.0)
    begin = 0.0 if way > 0.0 else _SPEED * _DWELL
    return _joint_1(
        begin + way * _SPEED * (2.0 * blend_integral - s),
        way * _SPEED * (2.0 * blend - 1.0),
        way * _SPEED * 2.0 * rate,
    )


def reversal(t: float) -> Reference:
    """Return a sinusoid of joint 1, 0.35 rad at 0.5 Hz: a reversal every second."""
    w, s, c = _FREQUENCY, np.sin(_FREQUENCY * t), np.cos(_FREQUENCY * t)
    return _joint_1(_AMPLITUDE * s, _AMPLITUDE * w * c, -_AMPLITUDE * w * w * s)


def _joint_1(q: float, v: float, a: float) -> Reference:
    return Reference(POSTURE + np.array([q, 0.0]), np.array([v, 0.0]), np.array([a, 0.0]))


MOTIONS = {
    motion.identifier: motion
    for motion in (
        StudyMotion('slow', slow, 12.0, 'slow S-shape, 0.052 rad/s both ways'),
        StudyMotion('reversal', reversal, 20.0, 'reversal, 0.35 rad at 0.5 Hz'),
    )
}
