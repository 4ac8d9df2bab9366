# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The multisine: a periodic sum of sinusoids of random phase within a band."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.exceptions import TrajectoryError
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
from sosml_friction.motion.trajectory_option import SPEED, SPEEDS, TOP, WAY, WAYS, options_of


@dataclass(frozen=True)
class MultisineSettings:
    """
    Say how a multisine is made.

    ``band`` [Hz], lowest and highest frequency; lines are whole multiples of 1 / ``period_s``;
    ``periods`` at full amplitude; ``ramp_s`` from and to rest. Peaks, which no joint exceeds and
    one of which each joint reaches: ``amplitude`` [rad or m], ``peak_speed`` [per s],
    ``peak_acceleration`` [per s^2].
    """

    amplitude: float = 0.3
    peak_speed: float = 0.8
    peak_acceleration: float = 4.0
    band: Sequence[float] = (0.1, 1.0)
    period_s: float = 20.0
    periods: int = 1
    ramp_s: float = 2.0
    seed: int = 0

    def __post_init__(self) -> None:
        if len(self.band) != 2 or not self.band[0] < self.band[1]:
            raise TrajectoryError(
                f'the multisine has the band {list(self.band)} Hz: give the lowest and the '
                'highest frequency'
            )

    @property
    def lines(self) -> IndexArray:
        """Return the frequencies in the band, in units of 1 / ``period_s``."""
        # A band that ends on a line has it, whatever the last bit of the product.
        low = math.ceil(self.band[0] * self.period_s - 1e-9)
        high = math.floor(self.band[1] * self.period_s + 1e-9)
        return np.arange(max(low, 1), high + 1)


def multisine(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    settings: MultisineSettings | None = None,
    top_speed: float = 0.5,
    scale: Sequence[float] = (1.0,),
) -> Trajectory:
    """
    Return a multisine about the centre for all joints at once.

    A sum of a_k sin(2 pi k t / period + phase_k) with a_k proportional to 1 / k, the same velocity
    at every frequency, and phases drawn from the seed. Moving joint i has every n-th line of the
    band, so that what one joint does to another can be told by its frequency.

    :param settings: default: those of the exoskeleton.
    :raises TrajectoryError: if joints differ, or the band holds no line for a joint.
    """
    motion, middle, factor = begin_motion('the multisine', start, centre, scale)
    motion.move(middle, move_speeds(top_speed, factor), 0.4)
    return add_multisine(motion, settings or MultisineSettings(), factor).build()


def add_multisine(
    motion: TrajectoryBuilder, settings: MultisineSettings, scale: FloatArray
) -> TrajectoryBuilder:
    """
    Add the multisine about where the motion rests.

    :raises TrajectoryError: if the band holds no line for a joint.
    """
    moving = np.flatnonzero(scale)
    lines = settings.lines
    if len(lines) < len(moving):
        raise TrajectoryError(
            f'the band {list(settings.band)} Hz holds {len(lines)} multiples of '
            f'1 / {settings.period_s:g} s for {len(moving)} joints: widen it or lengthen the '
            'period'
        )
    rng = np.random.default_rng(int(settings.seed))
    phases = rng.uniform(0.0, 2.0 * np.pi, len(lines))
    duration = settings.periods * settings.period_s + 2.0 * settings.ramp_s

    def signal(t: FloatArray) -> Signal:
        waves = np.zeros((3, len(t), len(scale)))
        for place, joint in enumerate(moving):
            for k, phase in zip(
                lines[place :: len(moving)], phases[place :: len(moving)], strict=True
            ):
                w = 2.0 * np.pi * k / settings.period_s
                s, c = np.sin(w * t + phase), np.cos(w * t + phase)
                waves[:, :, joint] += np.array([s, w * c, -w * w * s]) / k
        return product(fade(t, duration, settings.ramp_s), Signal(*waves))

    # Peaks of what is really run, ramps included, at forty points per shortest cycle.
    finest = lines[-1] / settings.period_s
    whole = signal(np.linspace(0.0, duration, int(40 * finest * duration) + 1000))
    limits = (settings.amplitude, settings.peak_speed, settings.peak_acceleration)
    shares = [np.abs(x).max(axis=0) / limit for x, limit in zip(whole, limits, strict=True)]
    largest = np.max(shares, axis=0)
    factor = np.where(scale > 0.0, scale / np.where(largest > 0.0, largest, 1.0), 0.0)

    def shape(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        wave = signal(t)
        return wave.x * factor, wave.rate * factor

    return motion.wave(duration, shape)


#: What the user can set of a multisine.
SINES = options_of(
    MultisineSettings,
    ('amplitude', 'amplitude', 'largest displacement from the centre', WAY, WAYS),
    ('peak_speed', 'peak_speed', 'largest speed', SPEED, SPEEDS),
    (
        'peak_acceleration', 'peak_acceleration', 'largest acceleration', 'rad/s2 or m/s2',
        (1e-3, 1000.0),
    ),
    ('band', 'band', 'lowest and highest frequency', 'Hz', (0.01, 50.0)),
    ('period', 'period_s', 'period, the inverse of the spacing of frequencies', 's', (0.1, 200.0)),
    ('periods', 'periods', 'whole periods at full amplitude', '', (1, 100)),
    ('ramp', 'ramp_s', 'from and to rest', 's', (0.1, 60.0)),
    ('seed', 'seed', 'of the phases', '', (0, 2**31 - 1)),
)  # fmt: skip


class Multisine(TrajectoryKind):
    """The multisine, by :func:`multisine`."""

    name = 'multisine'
    label = 'the multisine'
    description = 'a periodic sum of sinusoids of random phase within a band'
    options = (*SINES, *options_of(multisine, TOP))

    @staticmethod
    def build(
        start: Mapping[str, float],
        centre: Mapping[str, float],
        top_speed: float,
        scale: Sequence[float],
        **settings: Any,
    ) -> Trajectory:
        """Return it."""
        return multisine(start, centre, MultisineSettings(**settings), top_speed, scale)
