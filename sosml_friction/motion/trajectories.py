# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectories by name, and how one is built from its options."""

from collections.abc import Mapping
from typing import Any

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_option import TrajectoryOption

#: Nobody watches a robot for longer, and a number with a slip in it is found in time [s].
LONGEST_S = 3600.0

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


#: All kinds by name, those that were added later too; the paper's first, T1 to T3.
TRAJECTORIES = TrajectoryKind.registry


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


def find_kind(name: str) -> type[TrajectoryKind]:
    """
    Return the kind of that name, or of that label of the paper (``T1``).

    :raises TrajectoryError: if there is none; the sentence lists those that exist.
    """
    for kind in TRAJECTORIES.values():
        if name and name in (kind.name, kind.label):
            return kind
    raise TrajectoryError(f'trajectory {name!r} is unknown: use {", ".join(TRAJECTORIES)}')
