# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a kind of trajectory says about itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_option import TrajectoryOption
from sosml_friction.registry import Registry


class TrajectoryKind:
    """
    Name a kind of trajectory; a subclass says all of this, and is found by its name.

    ``label`` is what it is called in a sentence; ``role`` what recordings of it are for in the
    paper's rule, if anything: T1, T2 or T3. ``build`` takes start and centre, each a mapping from
    joint to position [rad or m], the keywords of ``options``, and ``scale`` as every trajectory
    has it; it raises a TrajectoryError if they cannot be used together.

    :raises TypeError: if a subclass leaves something out, or has the name or label of another.
    """

    name: ClassVar[str]
    label: ClassVar[str]
    description: ClassVar[str]
    options: ClassVar[tuple[TrajectoryOption, ...]]
    build: ClassVar[Callable[..., Trajectory]]
    role: ClassVar[str] = ''

    registry: ClassVar[Registry[TrajectoryKind]] = Registry(
        'trajectory', 'sosml_friction.motion.trajectory_kinds', lambda kind: kind.label
    )

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        said = ('name', 'label', 'description', 'options', 'build')
        missing = [what for what in said if not hasattr(cls, what)]
        if missing:
            raise TypeError(f'trajectory {cls.__name__} does not say its {", ".join(missing)}')
        for other in cls.registry.known.values():
            if {other.name, other.label} & {cls.name, cls.label}:
                raise TypeError(
                    f'trajectory {cls.__name__} has the name or label of {other.__name__}'
                )
        cls.registry.add(cls, cls.name)
