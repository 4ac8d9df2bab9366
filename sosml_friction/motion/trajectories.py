# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectories by name, each with the options it is made from."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kinds.multisine import MultisineSettings, multisine
from sosml_friction.motion.trajectory_kinds.reversal import reversal
from sosml_friction.motion.trajectory_kinds.rich import rich
from sosml_friction.motion.trajectory_kinds.slow_ladder import slow_ladder
from sosml_friction.motion.trajectory_kinds.slow_s_shape import slow_s_shape
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.motion.trajectory_kinds.symmetric_reversals import symmetric_reversals
from sosml_friction.motion.trajectory_option import TrajectoryOption

#: Nobody watches a robot for longer, and a number with a slip in it is found in time [s].
LONGEST_S = 3600.0
_SPEED, _WAY = 'rad/s or m/s', 'rad or m'


@dataclass(frozen=True)
class TrajectoryKind:
    """
    Name a kind of trajectory.

    ``label`` is what it is called in a sentence. ``build`` takes start and centre, each a mapping
    from joint to position, and the keywords of ``options`` and of :data:`COMMON`.
    """

    name: str
    label: str
    description: str
    build: Callable[..., Trajectory]
    options: tuple[TrajectoryOption, ...]


#: Every trajectory has these.
COMMON = (
    TrajectoryOption(
        'scale',
        'scale',
        (1.0,),
        'factor on all speeds and amplitudes, one for all joints or one for each; 0 keeps a joint '
        'at its centre',
        '',
        (0.0, 1000.0),
    ),
)


def build_trajectory(
    name: str,
    start: Mapping[str, float],
    centre: Mapping[str, float],
    values: Mapping[str, Any] | None = None,
) -> Trajectory:
    """
    Return the trajectory ``name``.

    :param start: present position of each joint, at rest [rad or m].
    :param centre: about which each joint moves [rad or m].
    :param values: options by name; those that are not given have their defaults.
    :raises TrajectoryError: if there is no such trajectory or option, a value cannot be used, or
        the motion would last longer than :data:`LONGEST_S`.
    """
    kind = find_kind(name)
    options = {option.name: option for option in (*kind.options, *COMMON)}
    for key in values or {}:
        if key not in options:
            raise TrajectoryError(f'{name} has no option {key!r}: use {", ".join(options)}')
    chosen = {key: option.default for key, option in options.items()} | dict(values or {})
    keywords = {option.keyword: option.check(chosen[key]) for key, option in options.items()}
    trajectory = kind.build(start, centre, **keywords)
    if trajectory.duration > LONGEST_S:
        raise TrajectoryError(
            f'{name} would last {trajectory.duration:.0f} s, more than {LONGEST_S:.0f} s: use '
            'fewer or faster pieces'
        )
    return trajectory


def find_kind(name: str) -> TrajectoryKind:
    """
    Return the kind of that name, or of that label of the paper (``T1``).

    :raises TrajectoryError: if there is none; the sentence lists those that exist.
    """
    for kind in TRAJECTORIES.values():
        if name and name in (kind.name, kind.label):
            return kind
    raise TrajectoryError(f'trajectory {name!r} is unknown: use {", ".join(TRAJECTORIES)}')


def _multisine(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    top_speed: float,
    scale: tuple[float, ...],
    **settings: Any,
) -> Trajectory:
    return multisine(start, centre, MultisineSettings(**settings), top_speed, scale)


def _rich(
    start: Mapping[str, float],
    centre: Mapping[str, float],
    sine_amplitude: float,
    peak_speed: float,
    peak_acceleration: float,
    band: tuple[float, float],
    period_s: float,
    seed: int,
    **keywords: Any,
) -> Trajectory:
    settings = MultisineSettings(
        sine_amplitude, peak_speed, peak_acceleration, band, period_s, seed=seed
    )
    return rich(start, centre, settings=settings, **keywords)


def _options(
    function: Callable[..., Any],
    *rows: tuple[str, str, str, str, tuple[float, float]],
) -> tuple[TrajectoryOption, ...]:
    """Return options with the defaults that ``function`` has for the keywords."""
    parameters = inspect.signature(function).parameters
    return tuple(
        TrajectoryOption(name, keyword, parameters[keyword].default, description, unit, limits)
        for name, keyword, description, unit, limits in rows
    )


def _renamed(option: TrajectoryOption, name: str, keyword: str) -> TrajectoryOption:
    return dataclasses.replace(option, name=name, keyword=keyword)


_SPEEDS = (1e-4, 100.0)
_PLATEAU = ('plateau', 'plateau_s', 'length of a plateau', 's', (0.1, 60.0))
_RAMP = ('ramp', 'ramp_s', 'length of a ramp to or from a plateau', 's', (0.02, 10.0))
_TURN = ('turn', 'turn_s', 'from one speed to the opposite one', 's', (0.04, 20.0))
_TOP = ('top_speed', 'top_speed', 'limit of the moves between pieces', _SPEED, (1e-3, 100.0))
_CYCLES = ('cycles', 'cycles', 'pairs of half-cycles at each speed', '', (1, 100))

_SINES = _options(
    MultisineSettings,
    ('amplitude', 'amplitude', 'largest displacement from the centre', _WAY, (1e-5, 100.0)),
    ('peak_speed', 'peak_speed', 'largest speed', _SPEED, (1e-4, 100.0)),
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

#: The trajectories, in the order of every list.
TRAJECTORIES: Mapping[str, TrajectoryKind] = {
    kind.name: kind
    for kind in (
        TrajectoryKind(
            'speed_ladder',
            'T1',
            'T1: plateaus of rising then falling speed, each in both directions',
            speed_ladder,
            (
                TrajectoryOption(
                    'speeds', 'speeds', (0.05, 0.1, 0.2, 0.35, 0.5, 0.7),
                    'plateau speeds, taken up and then down', _SPEED, _SPEEDS,
                ),
                *_options(speed_ladder, _PLATEAU, _RAMP, _TOP),
            ),
        ),
        TrajectoryKind(
            'symmetric_reversals',
            'T2',
            'T2: trains of short half-cycles at low speeds, to and fro without a rest',
            symmetric_reversals,
            _options(
                symmetric_reversals,
                ('speeds', 'speeds', 'of the half-cycles, up and then down', _SPEED, _SPEEDS),
                _PLATEAU,
                _TURN,
                _CYCLES,
                _TOP,
            ),
        ),
        TrajectoryKind(
            'slow_ladder',
            'T3',
            'T3: long plateaus at low speeds, each in both directions',
            slow_ladder,
            _options(
                slow_ladder,
                ('speeds', 'speeds', 'plateau speeds, taken up and then down', _SPEED, _SPEEDS),
                ('plateau', 'plateau_s', 'least length of a plateau', 's', (0.1, 60.0)),
                ('way', 'way', 'least way of a plateau', _WAY, (1e-6, 10.0)),
                _RAMP,
                _TOP,
            ),
        ),
        TrajectoryKind(
            'slow_s_shape',
            'the slow S-shape',
            'one low speed to and fro, with turns as long as the plateaus',
            slow_s_shape,
            _options(
                slow_s_shape,
                ('speed', 'speed', 'of the plateaus', _SPEED, _SPEEDS),
                _PLATEAU,
                _TURN,
                ('cycles', 'cycles', 'pairs of half-cycles', '', (1, 100)),
                _TOP,
            ),
        ),
        TrajectoryKind(
            'reversal',
            'the reversal',
            'a sinusoid that comes out of rest and goes back to it',
            reversal,
            _options(
                reversal,
                ('amplitude', 'amplitude', 'of the sinusoid', _WAY, (1e-5, 100.0)),
                ('frequency', 'frequency', 'of the sinusoid', 'Hz', (0.01, 50.0)),
                ('cycles', 'cycles', 'at full amplitude', '', (0.5, 1000.0)),
                ('ramp', 'ramp_s', 'from and to rest', 's', (0.1, 60.0)),
                _TOP,
            ),
        ),
        TrajectoryKind(
            'multisine',
            'the multisine',
            'a periodic sum of sinusoids of random phase within a band',
            _multisine,
            (*_SINES, *_options(multisine, _TOP)),
        ),
        TrajectoryKind(
            'rich',
            'the rich trajectory',
            'speed ladder, decaying reversals and multisine, in two postures',
            _rich,
            (
                *_options(
                    rich,
                    (
                        'offset', 'offset',
                        'from the first posture to the second, one for all joints or one for each',
                        _WAY, (-100.0, 100.0),
                    ),
                    ('speeds', 'speeds', 'of the ladder, up and then down', _SPEED, _SPEEDS),
                    _PLATEAU,
                    _RAMP,
                    ('amplitude', 'amplitude', 'of the first reversals', _WAY, (1e-5, 100.0)),
                    ('frequency', 'frequency', 'of the reversals', 'Hz', (0.01, 50.0)),
                    ('cycles', 'cycles', 'of the reversals', '', (0.5, 1000.0)),
                    (
                        'decay', 'decay', 'last amplitude of the reversals over the first', '',
                        (1e-6, 1.0),
                    ),
                    _TOP,
                ),
                *(
                    _renamed(o, 'multisine_amplitude', 'sine_amplitude')
                    if o.name == 'amplitude'
                    else o
                    for o in _SINES
                    if o.name not in ('periods', 'ramp')
                ),
            ),
        ),
    )
}  # fmt: skip
