# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The rich trajectory: ladder, decaying reversals and multisine, in two postures."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from sosml_friction.motion.building_blocks import begin_motion, move_speeds, per_joint
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_kinds.multisine import (
    SINES,
    MultisineSettings,
    add_multisine,
)
from sosml_friction.motion.trajectory_kinds.reversal import add_sinusoid
from sosml_friction.motion.trajectory_kinds.speed_ladder import add_ladder
from sosml_friction.motion.trajectory_option import (
    PLATEAU,
    RAMP,
    SPEED,
    SPEEDS,
    TOP,
    WAY,
    WAYS,
    options_of,
)


def rich(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    offset: Sequence[float] = (-0.3,),
    speeds: Sequence[float] = (0.02, 0.06, 0.2, 0.5),
    plateau_s: float = 0.8,
    ramp_s: float = 0.3,
    amplitude: float = 0.25,
    frequency: float = 0.4,
    cycles: float = 8.0,
    decay: float = 0.05,
    settings: MultisineSettings | None = None,
    top_speed: float = 0.5,
    scale: Sequence[float] = (1.0,),
) -> Trajectory:
    """
    Return one trajectory that excites everything, for all joints at once.

    About the centre, then about centre + offset: a speed ladder (levels), a sinusoid whose
    amplitude decays (reversals at every speed) and a multisine (inertia and gravity). What changes
    with the posture alone is gravity.

    :param offset: not scaled, but a joint whose scale is 0 keeps its posture.
    :param settings: of the multisine; the second posture has the next seed.
    :raises TrajectoryError: if joints differ.
    """
    motion, middle, factor = begin_motion('the rich trajectory', start, centre, scale)
    sines = settings or MultisineSettings()
    shift = np.where(factor > 0.0, per_joint('the offset', offset, len(middle)), 0.0)
    top = move_speeds(top_speed, factor)
    for k, posture in enumerate((middle, middle + shift)):
        add_ladder(motion, posture, speeds, [plateau_s] * len(speeds), ramp_s, top, factor)
        motion.move(posture, top, 0.4)
        add_sinusoid(motion, amplitude * factor, frequency, cycles, 1.0 / frequency, decay)
        add_multisine(motion, replace(sines, seed=sines.seed + k), factor)
    return motion.move(middle, top, 0.4).build()


#: Of its multisines; the amplitude of its own has another name.
_SINES = tuple(
    replace(option, name=f'multisine_{option.name}', keyword='multisine_amplitude')
    if option.name == 'amplitude'
    else option
    for option in SINES
    if option.name not in ('periods', 'ramp')
)


class Rich(TrajectoryKind):
    """The rich trajectory, by :func:`rich`."""

    name = 'rich'
    label = 'the rich trajectory'
    description = 'speed ladder, decaying reversals and multisine, in two postures'
    options = (
        *options_of(
            rich,
            (
                'offset', 'offset',
                'from the first posture to the second, one for all joints or one for each',
                WAY, (-100.0, 100.0),
            ),
            ('speeds', 'speeds', 'of the ladder, up and then down', SPEED, SPEEDS),
            PLATEAU, RAMP,
            ('amplitude', 'amplitude', 'of the first reversals', WAY, WAYS),
            ('frequency', 'frequency', 'of the reversals', 'Hz', (0.01, 50.0)),
            ('cycles', 'cycles', 'of the reversals', '', (0.5, 1000.0)),
            ('decay', 'decay', 'last amplitude of the reversals over the first', '', (1e-6, 1.0)),
            TOP,
        ),
        *_SINES,
    )  # fmt: skip

    @staticmethod
    def build(
        start: Mapping[str, float], centre: Mapping[str, float], **keywords: Any
    ) -> Trajectory:
        """Return it."""
        sines = {option.keyword: keywords.pop(option.keyword) for option in _SINES}
        settings = MultisineSettings(sines.pop('multisine_amplitude'), **sines)
        return rich(start, centre, settings=settings, **keywords)
