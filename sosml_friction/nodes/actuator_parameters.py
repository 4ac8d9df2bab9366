# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of joints as their types of actuator state them, as tables of a node."""

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, replace
from typing import Any

from rclpy.node import Node

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.parameter import Parameter, parameters_of, type_name
from sosml_friction.nodes.parameters import ParameterSpec, declare

_TYPES = {
    'bool': 'bool',
    'float': 'double',
    'int': 'integer',
    'str': 'string',
    'tuple[str, ...]': 'string_array',
}


def specs_of(
    parameters: Mapping[str, tuple[Field[Any], Parameter]], prefix: str = ''
) -> tuple[ParameterSpec, ...]:
    """Return rows for the parameters of a dataclass, see :func:`parameters_of`."""
    return tuple(
        ParameterSpec(
            f'{prefix}{key}',
            _TYPES[type_name(place)],
            None if place.default is MISSING else place.default,
            said.description,
            unit=said.unit,
            range=said.range,
            choices=said.choices,
        )
        for key, (place, said) in parameters.items()
    )


def joint_specs(driver: str, *, mount: bool = False) -> tuple[ParameterSpec, ...]:
    """Return the rows of one type of actuator, with ``mount`` those that say how it is mounted."""
    parameters = parameters_of(Actuator.kind(driver).configuration_type)
    wanted = {key: own for key, own in parameters.items() if own[1].mount or not mount}
    return specs_of(wanted, '{joint}.')


def _driver_spec() -> ParameterSpec:
    return ParameterSpec(
        '{joint}.driver', 'string', None, 'the kind of actuator', choices=tuple(Actuator.registry)
    )


def all_joint_specs(*, mount: bool = False) -> tuple[ParameterSpec, ...]:
    """Return the rows of every type; what several have is one row with what each says of it."""
    rows: dict[str, ParameterSpec] = {}
    for driver in Actuator.registry:
        for spec in joint_specs(driver, mount=mount):
            known = rows.setdefault(spec.name, spec)
            if known.description != spec.description:
                rows[spec.name] = replace(
                    known, description=f'{known.description}; {spec.description}'
                )
    return (_driver_spec(), *rows.values())


def declare_joints(node: Node, joints: Iterable[str], *, mount: bool = False) -> dict[str, Any]:
    """
    Declare the parameters of each joint's type of actuator; return them by full names.

    :raises ConfigurationError: as :func:`declare`, or if there is no such type.
    """
    values: dict[str, Any] = {}
    for joint in joints:
        own = declare(node, [_driver_spec()], joint)
        own |= declare(node, joint_specs(own['driver'], mount=mount), joint)
        values |= {f'{joint}.{key}': value for key, value in own.items()}
    return values
