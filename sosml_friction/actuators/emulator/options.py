# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How good the emulated hardware is: of the bus, and of each type of actuator."""

from __future__ import annotations

from dataclasses import Field, dataclass
from typing import Any

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.emulator.emulated_actuator import EmulatedActuator
from sosml_friction.actuators.parameter import Parameter, parameter, parameters_of
from sosml_friction.exceptions import ConfigurationError


@dataclass(frozen=True)
class _BusOptions:
    latency: float = parameter('from a request to its reply', 3e-4, unit='s')
    latency_jitter: float = parameter(
        'standard deviation of the half-normal time added to it', 5e-5, unit='s'
    )


class EmulatorOptions:
    """
    Hold the options that are not as their types of actuator have them by default.

    ``rmd_current_noise=0.0`` and the like: each type's own ``options_type`` says what there is,
    besides ``latency`` from request to reply [s] and half-normal ``latency_jitter`` [s].

    :raises ConfigurationError: if there is no such option.
    """

    def __init__(self, **values: Any) -> None:
        known = self.parameters()
        for key in values:
            if key not in known:
                raise ConfigurationError(
                    f'the emulator has no option {key}: use one of {", ".join(known)}'
                )
        self._values = values
        bus = _BusOptions(**self._own(_BusOptions))
        self.latency, self.latency_jitter = bus.latency, bus.latency_jitter

    def changed(self, **values: Any) -> EmulatorOptions:
        """Return these options with others in the place of some."""
        return EmulatorOptions(**{**self._values, **values})

    def of(self, kind: type[EmulatedActuator]) -> Any:
        """Return the options of one type of actuator, an object of its ``options_type``."""
        return kind.options_type(**self._own(kind.options_type))

    def _own(self, kind: type) -> dict[str, Any]:
        return {key: self._values[key] for key in parameters_of(kind) if key in self._values}

    @staticmethod
    def parameters() -> dict[str, tuple[Field[Any], Parameter]]:
        """Return every option there is, by name."""
        types = [kind.emulated_type.options_type for kind in Actuator.registry.values()]
        return {
            key: said for own in (*types, _BusOptions) for key, said in parameters_of(own).items()
        }
