# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The motions of the blind trials: rich, three multisines, a slow ladder."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from sosml_friction.motion.building_blocks import begin_motion
from sosml_friction.motion.trajectory_kinds.multisine import MultisineSettings, add_multisine
from sosml_friction.motion.trajectory_kinds.rich import rich
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from validation import plant as bp

JOINTS = ('shoulder', 'elbow')
MOTIONS = ('rich', 'multisine', 'slow', 'reversals', 'other')


@lru_cache(maxsize=8)
def _plan(name: str):
    start = dict(zip(JOINTS, (-0.9, 0.9), strict=True))
    if name == 'rich':
        sines = MultisineSettings(
            amplitude=0.45, peak_speed=2.0, peak_acceleration=9.0, band=(0.1, 1.5), period_s=16.0
        )
        return rich(
            start, start, offset=(-0.5, 0.5), speeds=(0.05, 0.12, 0.3, 0.7, 1.4), plateau_s=0.7,
            ramp_s=0.25, amplitude=0.25, frequency=0.5, cycles=8.0, decay=0.04, settings=sines,
            top_speed=1.2,
        )  # fmt: skip
    if name == 'multisine':
        sines = MultisineSettings(
            amplitude=0.5, peak_speed=1.5, peak_acceleration=8.0, period_s=20.0, periods=6
        )
    elif name == 'reversals':
        sines = MultisineSettings(
            amplitude=0.12, peak_speed=1.0, peak_acceleration=12.0, band=(0.5, 2.5),
            period_s=20.0, periods=6, seed=1,
        )  # fmt: skip
    elif name == 'other':
        sines = MultisineSettings(
            amplitude=0.55, peak_speed=1.6, peak_acceleration=9.0, band=(0.05, 1.2),
            period_s=20.0, periods=4, seed=5,
        )  # fmt: skip
    elif name == 'slow':
        return speed_ladder(start, start, (0.05, 0.1, 0.2, 0.4), plateau_s=1.2, ramp_s=0.3)
    else:
        raise ValueError(name)
    motion, _, factor = begin_motion('multisine', start, start, (1.0,))
    return add_multisine(motion, sines, factor).build()


@lru_cache(maxsize=8)
def reference(name: str = 'rich', duration: float | None = None):
    """
    Return position, speed and acceleration (N, 2) at 500 Hz of a motion.

    :param duration: [s]; a motion that is shorter is repeated. None for once.
    """
    plan = _plan(name)
    t = np.arange(0.0, duration or plan.duration, bp.PERIOD)
    spline = plan.spline()
    turn = np.mod(t, plan.duration)
    q, v = spline(turn), spline(turn, 1)
    return q, v, np.gradient(v, bp.PERIOD, axis=0)
