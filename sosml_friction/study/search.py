# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the study looks for the gains of each observer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sosml_friction.observers.configuration import OBSERVERS
from sosml_friction.observers.observer import Observer

FloatArray = NDArray[np.float64]


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
class StudyObserver:
    """
    Say how an observer takes part in the study.

    :param observer: its identifier in ``OBSERVERS``.
    :param ranges: what is searched.
    :param sweep: a gain that makes it faster, and its power of the bandwidth: the Pareto front is
        drawn by varying them.
    :param fixed: gains that are the same for every motion and condition.

    The gain ``position_noise`` is not searched but told.
    """

    observer: str
    ranges: Mapping[str, SearchRange]
    sweep: tuple[str, float]
    fixed: Mapping[str, float] = field(default_factory=dict)

    def gains(self, points: FloatArray, position_noise: float) -> dict[str, list[float]]:
        """
        Return the gains at points of the unit cube.

        :param points: one per joint, (n, number of ranges).
        :param position_noise: [rad].
        """
        gains: dict[str, NDArray[np.float64]] = {}
        for column, (name, span) in zip(points.T, self.ranges.items(), strict=True):
            gains[name] = span.low * (span.high / span.low) ** column
            if span.of:
                gains[name] = gains[name] * gains[span.of] ** span.power
        return self._complete(gains, len(points), position_noise)

    def _complete(
        self, searched: Mapping[str, FloatArray], n: int, position_noise: float
    ) -> dict[str, list[float]]:
        given = {**self.fixed, 'position_noise': position_noise}
        return {
            name: searched[name].tolist() if name in searched else [given[name]] * n
            for name in OBSERVERS[self.observer].gain_units
        }

    def faster(self, gains: Mapping[str, list[float]], factor: float) -> dict[str, list[float]]:
        """Return the gains for ``factor`` times the bandwidth; ratios of the search are kept."""
        scale = {self.sweep[0]: factor ** self.sweep[1]}
        for name, span in self.ranges.items():
            if span.of in scale:
                scale[name] = scale[span.of] ** span.power
        return {
            name: [scale.get(name, 1.0) * value for value in values]
            for name, values in gains.items()
        }

    def make(self, gains: Mapping[str, list[float]]) -> Observer:
        """Build the observer."""
        return OBSERVERS[self.observer](gains)


_SECOND_ORDER = {
    'linear': SearchRange(1.0, 1e6),
    'linear_damping': SearchRange(0.1, 4.0, 'linear'),
}
_SLIDING = {
    'sliding': SearchRange(1e-3, 1e5),
    'sliding_root': SearchRange(0.1, 10.0, 'sliding'),
    **_SECOND_ORDER,
}
_RATE = SearchRange(1e-3, 1e6)
_JUMP = SearchRange(0.01, 100.0)
# The bandwidth goes with the cube root of the rate.
_KALMAN_SWEEP = ('disturbance_rate', 3.0)
_CROSSING = {
    'disturbance_rate': _RATE,
    'crossing_rate': SearchRange(1.0, 1e4, 'disturbance_rate', 1.0),
    'crossing_velocity': SearchRange(1e-3, 1.0),
}
_LAW = {
    'residual': SearchRange(1e-3, 10.0),
    'residual_time': SearchRange(1e-3, 100.0),
    'friction': SearchRange(0.1, 10.0),
}

#: The observers of the study in the order of its tables.
SEARCH: dict[str, StudyObserver] = {
    'quasi_static': StudyObserver(
        'quasi_static', {'cutoff': SearchRange(0.3, 1e4)}, ('cutoff', 1.0)
    ),
    # The reference of the paper's comparison: a first-order observer that is kept slow.
    'first_order_capped': StudyObserver(
        'first_order', {'cutoff': SearchRange(0.3, 300.0)}, ('cutoff', 1.0)
    ),
    'first_order': StudyObserver(
        'first_order', {'cutoff': SearchRange(0.3, 1e4)}, ('cutoff', 1.0)
    ),
    'first_order_prefiltered': StudyObserver(
        'first_order_prefiltered',
        {
            'cutoff': SearchRange(0.3, 1e4),
            'prefilter_cutoff': SearchRange(0.1, 10.0, 'cutoff', 1.0),
        },
        ('cutoff', 1.0),
    ),
    'linear_second_order': StudyObserver(
        'linear_second_order',
        {'natural_frequency': SearchRange(1.0, 1e5), 'damping_ratio': SearchRange(0.05, 2.0)},
        ('natural_frequency', 1.0),
    ),
    'sosml': StudyObserver('sosml', _SLIDING, ('linear', 2.0)),
    'sosml_explicit': StudyObserver(
        'sosml_explicit', {**_SLIDING, 'boundary': SearchRange(1e-6, 1.0)}, ('linear', 2.0)
    ),
    'kalman': StudyObserver('kalman', {'disturbance_rate': _RATE}, _KALMAN_SWEEP),
    'kalman_adaptive': StudyObserver(
        'kalman_adaptive',
        {'disturbance_rate': _RATE, 'adaptation_rate': SearchRange(0.01, 100.0)},
        _KALMAN_SWEEP,
    ),
    'kalman_scheduled': StudyObserver(
        'kalman_scheduled', {'disturbance_rate': _RATE, 'crossing_jump': _JUMP}, _KALMAN_SWEEP
    ),
    'kalman_imm': StudyObserver(
        'kalman_imm',
        {
            'disturbance_rate': _RATE,
            'crossing_jump': _JUMP,
            'jump_memory': SearchRange(0.01, 3.0),
        },
        _KALMAN_SWEEP,
    ),
    'kalman_stribeck': StudyObserver(
        'kalman_stribeck',
        {
            **_LAW,
            'stribeck_velocity': SearchRange(0.01, 0.1),
            'smoothing_velocity': SearchRange(0.002, 0.02),
        },
        ('residual', 3.0),
        {'viscous': 1.0},
    ),
    # The same with a law whose knee is three times as wide as that of the plant.
    'kalman_stribeck_wrong_knee': StudyObserver(
        'kalman_stribeck',
        _LAW,
        ('residual', 3.0),
        {'viscous': 1.0, 'stribeck_velocity': 0.09, 'smoothing_velocity': 0.015},
    ),
    'smoother': StudyObserver('smoother', _CROSSING, _KALMAN_SWEEP),
}
