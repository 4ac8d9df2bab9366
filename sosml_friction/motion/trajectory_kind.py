# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a kind of trajectory says about itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_option import TrajectoryOption


class TrajectoryKind(ABC):
    """
    Name a kind of trajectory; a subclass that says all of this is found by its name.

    ``label`` is what it is called in a sentence; ``role`` what recordings of it are for in the
    paper's rule, if anything: T1, T2 or T3.
    """

    name: ClassVar[str]
    label: ClassVar[str]
    description: ClassVar[str]
    options: ClassVar[tuple[TrajectoryOption, ...]]
    role: ClassVar[str] = ''

    registry: ClassVar[dict[str, type[TrajectoryKind]]] = {}

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        if getattr(cls.build, '__isabstractmethod__', False):
            return
        said = ('name', 'label', 'description', 'options')
        missing = [what for what in said if not hasattr(cls, what)]
        if missing:
            raise TypeError(f'trajectory {cls.__name__} does not say its {", ".join(missing)}')
        other = next(
            (
                kind
                for kind in TrajectoryKind.registry.values()
                if {kind.name, kind.label} & {cls.name, cls.label}
            ),
            None,
        )
        if other is not None:
            raise TypeError(
                f'trajectory {cls.__name__} has the name or label of {other.__name__}: {cls.name}'
            )
        TrajectoryKind.registry[cls.name] = cls

    @classmethod
    @abstractmethod
    def build(
        cls, start: Mapping[str, float], centre: Mapping[str, float], values: Mapping[str, Any]
    ) -> Trajectory:
        """
        Return the trajectory.

        :param start: present position of each joint, at rest [rad or m].
        :param centre: about which each joint moves [rad or m].
        :param values: by the keywords of ``options``, and ``scale`` as every trajectory has it.
        :raises TrajectoryError: if they cannot be used together.
        """
