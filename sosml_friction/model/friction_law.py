# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The abstract base of static friction laws, and how a law is found by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sosml_friction.exceptions import ConfigurationError


class FrictionLaw(ABC):
    """
    Map velocity to friction torque tau_f [Nm or N], positive for positive velocity.

    ``smoothing_velocity`` is v0 of :func:`~sosml_friction.model.smooth_sign.smooth_sign`.
    """

    identifier: ClassVar[str]
    parameter_names: ClassVar[tuple[str, ...]]

    def __init__(self, parameters: Mapping[str, float], smoothing_velocity: float) -> None:
        unknown = sorted(set(parameters) - set(self.parameter_names))
        missing = [name for name in self.parameter_names if name not in parameters]
        if unknown or missing:
            raise ConfigurationError(
                f'friction law {self.identifier} takes {", ".join(self.parameter_names)}: '
                f'missing {missing or "none"}, unknown {unknown or "none"}'
            )
        for name in self.parameter_names:
            if not np.isfinite(parameters[name]):
                raise ConfigurationError(
                    f'{name} of friction law {self.identifier} is {parameters[name]}: give it a '
                    'finite value'
                )
        if not 0.0 <= smoothing_velocity < np.inf:
            raise ConfigurationError(
                f'smoothing_velocity of friction law {self.identifier} is {smoothing_velocity}: '
                'give it a finite value >= 0'
            )
        self.parameters = {name: float(parameters[name]) for name in self.parameter_names}
        self.smoothing_velocity = float(smoothing_velocity)

    @abstractmethod
    def torque(self, v: ArrayLike) -> NDArray[np.float64]:
        """Return tau_f at velocity ``v`` [rad/s or m/s], same shape."""


def unit_of(name: str, effort_unit: str) -> str:
    """
    Return the unit of a friction parameter.

    :param name: parameter name, for instance ``viscous``.
    :param effort_unit: ``Nm`` for a revolute joint, ``N`` for a prismatic one.
    """
    length = 'rad' if effort_unit == 'Nm' else 'm'
    if name.startswith('viscous'):
        return f'{effort_unit} s/{length}'
    if name.endswith('velocity'):
        return f'{length}/s'
    return effort_unit
