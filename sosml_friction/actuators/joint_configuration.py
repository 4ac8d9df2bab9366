# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver is told about one joint: its actuator, how it is mounted and driven."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from sosml_friction.actuators.parameter import check_parameters, parameter, require_bounds
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import JointLimits


class HostLoop(NamedTuple):
    """
    Hold the loop on the host: tau = feed-forward + kp (q_r - q) + kd (q_r' - q'), limited.

    ``kp`` [Nm/rad or N/m], ``kd`` [Nm s/rad or N s/m], ``limit`` [Nm or N] of the effort,
    ``rate_limit`` [Nm/s or N/s] of its change.
    """

    kp: float
    kd: float
    limit: float
    rate_limit: float


@dataclass(frozen=True)
class JointConfiguration(ABC):
    """
    Say which actuator a joint has, how it is mounted and how it is driven.

    With i its current and x its position, both in its own direction: tau = direction *
    torque_constant * i [Nm or N] and q = direction * x + zero_offset [rad or m]. A subclass adds
    the parameters of one type of actuator, whose name in a parameter file is ``driver``.

    :raises ConfigurationError: if a value does not fit.
    """

    driver: ClassVar[str]

    name: str
    direction: int = parameter('1 where it turns as the URDF says, or -1', mount=True)
    zero_offset: float = parameter(
        "the joint's position at the actuator's zero", unit='rad or m', mount=True, above=-math.inf
    )
    torque_constant: float = parameter(
        'effort at the joint per ampere', unit='Nm/A or N/A', mount=True, above=0.0
    )
    temperature_limit: float = parameter(
        'temperature above which it is a fault', 75.0, unit='degC', above=0.0
    )
    tracking_limit: float = parameter(
        'distance from the reference beyond which it is a fault',
        0.2,
        unit='rad or m',
        range=(1e-4, 10.0),
        above=0.0,
    )

    def __post_init__(self) -> None:
        check_parameters(self, f'{self.name}.')
        if self.direction not in (-1, 1):
            raise ConfigurationError(
                f'{self.name}.direction is {self.direction}: give 1 where the actuator turns the '
                'way of the URDF, -1 where it turns against it'
            )

    def require(self, *keys: str) -> None:
        """Refuse, with a ConfigurationError, parameters without a value within their bounds."""
        for key in keys:
            require_bounds(self, key, f'{self.name}.')

    @abstractmethod
    def check_drive(self) -> None:
        """
        Refuse what is enough to mount an actuator but not to drive it.

        :raises ConfigurationError: with what is missing.
        """

    @abstractmethod
    def loop(self, limits: JointLimits) -> HostLoop | str:
        """Return the loop on the host, or in words where the actuator's own loop is."""
