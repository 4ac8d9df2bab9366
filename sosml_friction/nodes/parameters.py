# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
One declarative table of parameters per node: declared from it, documented from it.

A name may hold ``{joint}``: it then stands for one parameter per joint,
``shoulder.torque_constant`` for ``{joint}.torque_constant``.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from sosml_friction.exceptions import ConfigurationError

_TYPES = {
    'bool': Parameter.Type.BOOL,
    'integer': Parameter.Type.INTEGER,
    'double': Parameter.Type.DOUBLE,
    'string': Parameter.Type.STRING,
    'string_array': Parameter.Type.STRING_ARRAY,
    'double_array': Parameter.Type.DOUBLE_ARRAY,
}


@dataclass(frozen=True)
class ParameterSpec:
    """Describe one parameter; without a ``default`` it must be set. ``range`` is inclusive."""

    name: str
    type: str
    default: Any
    description: str
    unit: str = ''
    range: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = True


def declare(node: Node, specs: Iterable[ParameterSpec], joint: str = '') -> dict[str, Any]:
    """
    Declare the parameters of ``specs`` on ``node`` and return their values by name.

    With ``joint`` the table's ``{joint}`` names are declared for it, and returned without the
    joint's prefix; without it only the names that hold no ``{joint}``. A parameter that is
    declared already is read again.

    :raises ConfigurationError: if a required parameter is not set, or a value has the wrong type,
        is out of range or none of the choices.
    """
    values: dict[str, Any] = {}
    for spec in specs:
        if ('{joint}' in spec.name) != bool(joint):
            continue
        name = spec.name.format(joint=joint)
        key = name.removeprefix(f'{joint}.') if joint else name
        if not node.has_parameter(name):
            _declare_one(node, name, spec)
        value = node.get_parameter_or(name, Parameter(name)).value
        if value is None and spec.default is not None:
            value = spec.default
        if value is None:
            unit = f' [{spec.unit}]' if spec.unit else ''
            raise ConfigurationError(
                f'parameter {name} of {node.get_name()} is not set: give {spec.description}{unit}'
            )
        if spec.choices and value not in spec.choices:
            raise ConfigurationError(
                f'parameter {name} of {node.get_name()} is {value!r}: use one of '
                f'{", ".join(spec.choices)}'
            )
        values[key] = list(value) if spec.type.endswith('_array') else value
    return values


def _declare_one(node: Node, name: str, spec: ParameterSpec) -> None:
    descriptor = ParameterDescriptor(
        description=spec.description + (f' [{spec.unit}]' if spec.unit else ''),
        read_only=spec.read_only,
        additional_constraints=f'one of {", ".join(spec.choices)}' if spec.choices else '',
    )
    if spec.range is not None and spec.type == 'double':
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(spec.range[0]), to_value=float(spec.range[1]))
        ]
    elif spec.range is not None and spec.type == 'integer':
        descriptor.integer_range = [
            IntegerRange(from_value=int(spec.range[0]), to_value=int(spec.range[1]), step=1)
        ]
    # An empty list as default would be declared as a byte array.
    no_default = spec.default is None or (spec.type.endswith('_array') and not spec.default)
    default = _TYPES[spec.type] if no_default else spec.default
    try:
        node.declare_parameter(name, default, descriptor)
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        point = ', with its point as in 7.0' if spec.type.startswith('double') else ''
        limits = f' between {spec.range[0]:g} and {spec.range[1]:g}' if spec.range else ''
        raise ConfigurationError(
            f'parameter {name} of {node.get_name()} does not fit: give a {spec.type}{limits}'
            f'{point} ({" ".join(str(error).split())})'
        ) from error
    if spec.default == [] and node._parameters[name].type_ == Parameter.Type.NOT_SET:
        # Not even rclpy can declare an empty array; without a value, no tool shows any parameter.
        node._parameters[name] = Parameter(name, _TYPES[spec.type], [])
