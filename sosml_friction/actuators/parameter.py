# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters as fields of a dataclass: stated once for values, checks, nodes and documents."""

import math
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any

from sosml_friction.exceptions import ConfigurationError

# A YAML file read without ROS may hold anything.
_KINDS: dict[str, tuple[tuple[type, ...], str]] = {
    'float': ((float, int), 'a number'),
    'int': ((int,), 'a whole number'),
    'bool': ((bool,), 'true or false'),
    'str': ((str,), 'a word'),
    'tuple[str, ...]': ((list, tuple), 'a list of words'),
}


@dataclass(frozen=True)
class Parameter:
    """
    Describe one parameter.

    ``range``: what a node takes, inclusive. A number must be finite and above ``above``, or at
    least ``least``, where one is given; where it is ``conditional`` only if something needs it.
    ``mount``: it says how the actuator is mounted, which the emulated hardware must know too.
    ``key``: its name as a parameter where that is not the field's.
    """

    description: str
    unit: str = ''
    range: tuple[float, float] | None = None
    choices: tuple[str, ...] = ()
    above: float | None = None
    least: float | None = None
    conditional: bool = False
    mount: bool = False
    key: str = ''


def parameter(description: str, default: Any = MISSING, **rest: Any) -> Any:
    """Return a field with a :class:`Parameter`; without a default it must be given."""
    return field(default=default, metadata={'parameter': Parameter(description, **rest)})


def parameters_of(kind: Any) -> dict[str, tuple[Field[Any], Parameter]]:
    """Return field and parameter of every parameter of a dataclass, by the parameter's name."""
    found = ((own, own.metadata.get('parameter')) for own in fields(kind))
    return {said.key or own.name: (own, said) for own, said in found if said is not None}


def type_name(place: Field[Any]) -> str:
    """Return a field's type as it is written."""
    kind: Any = place.type
    return str(getattr(kind, '__name__', kind) if kind in (float, int, bool, str) else kind)


def check_parameters(own: Any, prefix: str = '') -> None:
    """
    Refuse values of the wrong type, outside their bounds or none of the choices.

    :raises ConfigurationError: with ``prefix`` and name of the first.
    """
    for key, (place, said) in parameters_of(own).items():
        kinds, words = _KINDS[type_name(place)]
        value = getattr(own, place.name)
        # To Python a bool is a whole number, to a reader it is not.
        mistaken = isinstance(value, bool) and bool not in kinds
        if mistaken or not isinstance(value, kinds):
            raise ConfigurationError(f'{prefix}{key} is {value!r}: it must be {words}')
        if said.choices and value not in said.choices:
            raise ConfigurationError(
                f'{prefix}{key} is {value!r}: use one of {", ".join(said.choices)}'
            )
        if not said.conditional:
            require_bounds(own, key, prefix)


def require_bounds(own: Any, key: str, prefix: str = '') -> None:
    """
    Refuse a number that is not finite or outside its bounds; without bounds all is good.

    :raises ConfigurationError: with its name.
    """
    place, said = parameters_of(own)[key]
    value = getattr(own, place.name)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return
    if not math.isfinite(value):
        raise ConfigurationError(f'{prefix}{key} is {value}: it must be a finite number')
    if said.above is not None and not value > said.above:
        raise ConfigurationError(f'{prefix}{key} is {value:g}: it must be above {said.above:g}')
    if said.least is not None and not value >= said.least:
        raise ConfigurationError(f'{prefix}{key} is {value:g}: it must be {said.least:g} or more')
    low, high = said.range or (-math.inf, math.inf)
    if not low <= value <= high:
        raise ConfigurationError(
            f'{prefix}{key} is {value:g}: it must be from {low:g} to {high:g}'
        )
