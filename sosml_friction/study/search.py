# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What takes part in the study: every observer, in the variants that its class names."""

from typing import NamedTuple

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.observer import Observer
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.observers.search_space import Gains, SearchSpace


class StudyVariant(NamedTuple):
    """Hold an observer and where its gains are searched."""

    observer: type[Observer]
    space: SearchSpace

    @property
    def label(self) -> str:
        """Return what a person calls it."""
        return self.space.label or self.observer.label

    def gains(self, points: FloatArray, position_noise: float) -> Gains:
        """
        Return the gains at points of the unit cube.

        :param points: one per joint, (n, number of ranges).
        """
        found = self.space.gains(points, position_noise)
        return {name: found[name] for name in self.observer.gain_units}


def study_variants() -> dict[str, StudyVariant]:
    """Return them by name in the order of the tables; the slowest come last."""
    return {
        name: StudyVariant(observer, space)
        for observer in OBSERVERS.values()
        for name, space in observer.study.items()
    }
