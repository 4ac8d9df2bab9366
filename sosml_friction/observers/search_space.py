# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the gains of an observer are searched."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from sosml_friction.arrays import FloatArray

Gains = dict[str, list[float]]


@dataclass(frozen=True)
class SearchRange:
    """
    Bound a gain: from ``low`` to ``high``, searched in its logarithm.

    With ``of`` the bounds are of gain / of^power, where ``of`` is another gain with a range of its
    own, listed before: a damping is searched as a ratio.
    """

    low: float
    high: float
    of: str = ''
    power: float = 0.5


@dataclass(frozen=True)
class SearchSpace:
    """
    Say where the study searches the gains of an observer.

    :param ranges: what is searched, by gain. The gain ``position_noise`` is not searched but told.
    :param sweep: a gain that makes the observer faster, and its power of the bandwidth: the Pareto
        front is drawn by varying them.
    :param fixed: gains that are the same for every motion and condition.
    :param label: what a person calls the observer with these gains; its own label if empty.
    :param remark: what is special about these gains, for the legend.
    """

    ranges: Mapping[str, SearchRange]
    sweep: tuple[str, float]
    fixed: Mapping[str, float] = field(default_factory=dict)
    label: str = ''
    remark: str = ''

    def gains(self, points: FloatArray, position_noise: float) -> Gains:
        """
        Return the gains at points of the unit cube.

        :param points: one per joint, (n, number of ranges).
        :param position_noise: what an observer that asks for it is told [rad].
        """
        found: dict[str, FloatArray] = {}
        for column, (name, span) in zip(points.T, self.ranges.items(), strict=True):
            found[name] = span.low * (span.high / span.low) ** column
            if span.of:
                found[name] = found[name] * found[span.of] ** span.power
        same = {**self.fixed, 'position_noise': position_noise}
        return {name: [value] * len(points) for name, value in same.items()} | {
            name: column.tolist() for name, column in found.items()
        }

    def faster(self, gains: Mapping[str, list[float]], factor: float) -> Gains:
        """Return the gains for ``factor`` times the bandwidth; ratios of the search are kept."""
        scale = {self.sweep[0]: factor ** self.sweep[1]}
        for name, span in self.ranges.items():
            if span.of in scale:
                scale[name] = scale[span.of] ** span.power
        return {
            name: [scale.get(name, 1.0) * value for value in values]
            for name, values in gains.items()
        }
