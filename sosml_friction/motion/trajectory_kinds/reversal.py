# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The reversal: a sinusoid that comes out of rest and goes back to it."""

from collections.abc import Mapping, Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.motion.building_blocks import (
    Signal,
    TrajectoryBuilder,
    begin_motion,
    fade,
    move_speeds,
    product,
)
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_option import TOP, WAY, WAYS, options_of


def reversal(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    amplitude: float = 0.35,
    frequency: float = 0.5,
    cycles: float = 9.0,
    ramp_s: float = 2.0,
    top_speed: float = 0.5,
    scale: Sequence[float] = (1.0,),
) -> Trajectory:
    """
    Return a sinusoid about the centre for all joints at once.

    q(t) - centre = amplitude e(t) sin(2 pi frequency (t - T / 2)) with an envelope e that rises
    within ``ramp_s`` and falls within as much: odd in time about the middle T / 2 of the wave.

    :raises TrajectoryError: if joints differ.
    """
    motion, middle, factor = begin_motion('the reversal', start, centre, scale)
    motion.move(middle, move_speeds(top_speed, factor), 0.4)
    return add_sinusoid(motion, amplitude * factor, frequency, cycles, ramp_s).build()


def add_sinusoid(
    motion: TrajectoryBuilder,
    amplitude: FloatArray,
    frequency: float,
    cycles: float,
    ramp_s: float,
    decay: float = 1.0,
) -> TrajectoryBuilder:
    """
    Add the sinusoid about where the motion rests.

    :param amplitude: (n,) [rad or m], of the first full cycle.
    :param decay: amplitude of the last full cycle over that of the first, exponential in between.
    """
    duration = cycles / frequency + 2.0 * ramp_s
    rate = np.log(decay) * frequency / cycles

    def shape(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        w = 2.0 * np.pi * frequency
        s, c = (f(w * (t - 0.5 * duration))[:, None] for f in (np.sin, np.cos))
        e = np.exp(rate * (t - ramp_s))[:, None]
        wave = product(Signal(e, rate * e, rate**2 * e), Signal(s, w * c, -w * w * s))
        faded = product(fade(t, duration, ramp_s), wave)
        return faded.x * amplitude, faded.rate * amplitude

    return motion.wave(duration, shape)


class Reversal(TrajectoryKind):
    """The reversal, by :func:`reversal`."""

    name = 'reversal'
    label = 'the reversal'
    description = 'a sinusoid that comes out of rest and goes back to it'
    options = options_of(
        reversal,
        ('amplitude', 'amplitude', 'of the sinusoid', WAY, WAYS),
        ('frequency', 'frequency', 'of the sinusoid', 'Hz', (0.01, 50.0)),
        ('cycles', 'cycles', 'at full amplitude', '', (0.5, 1000.0)),
        ('ramp', 'ramp_s', 'from and to rest', 's', (0.1, 60.0)),
        TOP,
    )  # fmt: skip
    build = staticmethod(reversal)
