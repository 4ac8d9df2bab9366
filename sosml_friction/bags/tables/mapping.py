# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The mapping file of an import: which variable is what, in which unit.

docs/import.md has every key. Each quantity is ``value = variable * unit * scale + offset`` in SI
units (rad, m, Nm, N, degC); a position that wraps is unwrapped before. What is not known has no
default: an effort in A, mA, V, mV, percent or counts needs its ``scale`` (Nm or N per unit), a
position in counts its ``counts_per_unit`` or ``counts_per_turn``.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sosml_friction.bags.tables.units import (
    ANGULAR_UNITS,
    KELVIN_OFFSET,
    LINEAR_UNITS,
    TIME_UNITS,
    UNITS,
    known_unit,
    known_units,
)
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.yaml_text import read_yaml

#: What to do where a joint has a velocity alone. It is not integrated unasked: a sum drifts with
#: the bias of a velocity, and where it begins is not known, on which gravity depends.
NO_POSITION = (
    '{} does not say where the joint is, on which gravity and the checks of units rest: log the '
    'position too, or where there is no gravity (--axis, --free) put the sum of velocity times '
    'step into the table as its position'
)
#: What a proposed mapping has in the places that the data leave open.
FILL_IN = 'FILL_IN'

_TOP_KEYS = (
    'time', 'sample_rate', 'start_time', 'joints', 'urdf', 'model', 'tags', 'rows', 'columns',
)  # fmt: skip
_SERIES_KEYS = ('variable', 'column', 'row')
_SIGNAL_KEYS = (*_SERIES_KEYS, 'unit', 'scale', 'offset')
_CONTROLLER = 'controller'
_INJECTED = 'injected'
_GAINS = ('kp', 'kv', 'scale', 'limit')
_COUNT_KEYS = ('counts_per_unit', 'counts_per_turn')


@dataclass(frozen=True)
class Series:
    """Name one series of numbers: a variable, or one column or row (from 0) of a table."""

    variable: str
    column: int | None = None
    row: int | None = None


@dataclass(frozen=True)
class Signal:
    """
    Say how a series becomes a physical quantity: ``series * factor * scale + offset``.

    ``factor`` comes from ``unit``; ``scale`` and ``offset`` are numbers, or the name of a variable
    that holds one. ``wrap``: the period at which the series jumps back [its own unit], 0 if it
    does not, None if that is to be recognised.
    """

    series: Series
    unit: str
    factor: float
    scale: float | str
    offset: float | str
    wrap: float | None = None


@dataclass(frozen=True)
class ControllerSource:
    """
    Say where the wanted position of a joint and the gains of its controller come from.

    ``gains``: ``kp``, ``kv``, and ``scale`` and ``limit`` where given; numbers, or the names of
    variables that hold one.
    """

    reference: Signal
    gains: Mapping[str, float | str]


@dataclass(frozen=True)
class ImportMapping:
    """
    Hold a checked mapping file.

    Either ``time`` with ``ns_per_time_unit``, or ``sample_rate`` [Hz] (a number or a variable's
    name); ``nanoseconds`` are added to a time of whole seconds. ``joints`` maps each joint to its
    signals by quantity, ``injected`` to what was added to its controller's command. ``urdf`` and
    ``model`` are whole paths.
    """

    path: Path
    joints: Mapping[str, Mapping[str, Signal]]
    time: Series | None = None
    ns_per_time_unit: int = 1
    nanoseconds: Series | None = None
    sample_rate: float | str | None = None
    start_time_ns: int = 0
    urdf: Path | None = None
    model: Path | None = None
    tags: Mapping[str, str] = field(default_factory=dict)
    rows: tuple[str, ...] | None = None
    columns: tuple[str, ...] | None = None
    controllers: Mapping[str, ControllerSource] = field(default_factory=dict)
    injected: Mapping[str, Signal] = field(default_factory=dict)


class _Reader:
    """Take a mapping file apart, naming the file and the key in every complaint."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def error(self, where: str, what: str) -> ConfigurationError:
        return ConfigurationError(f'{self.path}: {where} {what}')

    def table(self, value: Any, where: str, keys: tuple[str, ...] | None = None) -> dict[str, Any]:
        """Return a mapping whose keys are strings, all of them among ``keys``."""
        if not isinstance(value, dict) or not value:
            raise self.error(where, f'is {value!r}: a mapping of names to values is needed')
        for key in value:
            if not isinstance(key, str):
                raise self.error(where, f'has the key {key!r}: put it in quotes')
            if keys is not None and key not in keys:
                raise self.error(
                    where, f'has the unknown key {key!r}: known are {", ".join(keys)}'
                )
        return value

    def text(self, value: Any, where: str) -> str:
        if not isinstance(value, str) or not value:
            raise self.error(where, f'is {value!r}: a name is needed')
        return value

    def variable(self, value: Any, where: str) -> str:
        """Return the name of a variable, or its number as text."""
        return str(value) if type(value) is int and value >= 0 else self.text(value, where)

    def number(self, value: Any, where: str) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.error(where, f'is {value!r}: a number is needed')
        if not math.isfinite(value):
            raise self.error(where, f'is {value!r}: a finite number is needed')
        return float(value)

    def factor(self, value: Any, where: str) -> float | str:
        """Return a number that is not 0, or the name of a variable."""
        if isinstance(value, str):
            return self.text(value, where)
        number = self.number(value, where)
        if number == 0.0:
            raise self.error(where, 'is 0: that would erase the quantity')
        return number

    def names(self, value: Any, where: str) -> tuple[str, ...]:
        if not isinstance(value, list) or not value:
            raise self.error(where, f'is {value!r}: a list of names is needed')
        return tuple(self.text(name, where) for name in value)

    def series(self, value: dict[str, Any], where: str) -> Series:
        if 'variable' not in value:
            raise self.error(where, 'has no variable: name the one that holds it')
        if 'column' in value and 'row' in value:
            raise self.error(where, 'has both column and row: give one of them')
        place: dict[str, int] = {}
        for key in ('column', 'row'):
            if key in value:
                if type(value[key]) is not int or value[key] < 0:
                    raise self.error(f'{where}.{key}', f'is {value[key]!r}: count from 0')
                place[key] = value[key]
        return Series(self.variable(value['variable'], f'{where}.variable'), **place)

    def unit(self, value: dict[str, Any], where: str, quantity: str) -> str:
        unit = value.get('unit')
        found = known_unit(unit, quantity) if isinstance(unit, str) else ''
        if not found:
            said = 'has no unit' if unit is None else f'has the unknown unit {unit!r}'
            raise self.error(where, f'{said}: known are {known_units(quantity)}')
        return found

    def signal(self, value: Any, where: str, quantity: str) -> Signal:
        """Return a checked signal of a joint."""
        countable = quantity in ('position', 'velocity')
        keys = _SIGNAL_KEYS + (_COUNT_KEYS if countable else ())
        keys += ('wrap',) if quantity == 'position' else ()
        value = self.table(value, where, keys)
        unit = self.unit(value, where, quantity)
        factor = UNITS[quantity][unit]
        counts = [key for key in _COUNT_KEYS if key in value]
        if countable and factor is None:
            if len(counts) != 1:
                raise self.error(
                    where,
                    f'is in {unit}: give counts_per_unit (counts per rad or per m) or '
                    'counts_per_turn',
                )
            per = self.factor(value[counts[0]], f'{where}.{counts[0]}')
            if isinstance(per, str):
                raise self.error(f'{where}.{counts[0]}', f'is {per!r}: a number is needed')
            factor = (2.0 * math.pi if counts[0] == 'counts_per_turn' else 1.0) / per
        elif counts:
            raise self.error(where, f'has {counts[0]} but is in {unit}: remove one of the two')
        elif factor is None:
            if 'scale' not in value:
                raise self.error(
                    where,
                    f'is in {unit} and has no scale: give the Nm (or N) per {unit}, as a number '
                    'or the name of a variable; there is no default',
                )
            factor = 1.0
        offset: float | str = KELVIN_OFFSET if unit == 'K' else 0.0
        if 'offset' in value:
            if unit == 'K':
                raise self.error(where, 'is in K and has an offset: give it in degC instead')
            given = value['offset']
            offset = given if isinstance(given, str) else self.number(given, f'{where}.offset')
        scale = self.factor(value.get('scale', 1.0), f'{where}.scale')
        wrap = None if quantity == 'position' else 0.0
        if 'wrap' in value:
            wrap = self.wrap(value['wrap'], f'{where}.wrap')
        return Signal(self.series(value, where), unit, factor, scale, offset, wrap)

    def wrap(self, value: Any, where: str) -> float:
        """Return the period of a range ``[lowest, highest]``, of a period, or 0 of ``no``."""
        if value is False:
            return 0.0
        if isinstance(value, list) and len(value) == 2:
            low, high = (self.number(x, where) for x in value)
            value = high - low
        period = self.number(value, where)
        if period <= 0.0:
            raise self.error(
                where, f'is {value!r}: give the period, [lowest, highest], or no where none is'
            )
        return period

    def controller(self, value: Any, where: str) -> ControllerSource:
        """Return a checked controller of a joint."""
        value = self.table(value, where, ('reference', *_GAINS))
        for key in ('reference', 'kp', 'kv'):
            if key not in value:
                raise self.error(where, f'has no {key}: the loop cannot be simulated without it')
        gains = {key: self.factor(value[key], f'{where}.{key}') for key in _GAINS if key in value}
        reference = self.signal(value['reference'], f'{where}.reference', 'position')
        return ControllerSource(reference, gains)

    def each_its_own(self, joints: Mapping[str, Mapping[str, Signal]]) -> None:
        """Refuse one series for two joints, but for a temperature, which they may share."""
        of: dict[tuple[str, Series], str] = {}
        for joint, signals in joints.items():
            for quantity, signal in signals.items():
                other = of.setdefault((quantity, signal.series), joint)
                if other != joint and quantity != 'temperature':
                    raise self.error(
                        f'joints.{joint}.{quantity}',
                        f'is that of {other}, too: name the one of {joint}, or leave {joint} out '
                        f'if it follows {other}',
                    )

    def file(self, value: Any, where: str) -> Path:
        path = self.path.parent / self.text(value, where)
        try:
            exists = path.is_file()
        except (OSError, ValueError):  # a name that no file can have
            exists = False
        if not exists:
            raise self.error(where, f'is {value!r} and {path} does not exist')
        return path


def read_mapping(path: str | Path, rate: float | None = None) -> ImportMapping:
    """
    Return the checked content of a mapping file; ``rate`` [Hz] is for one that has no time.

    What is wrong or lacking is a ConfigurationError that names the key.
    """
    path = Path(path)
    needed = 'give a YAML file that says which variable is what'
    content = read_yaml(path, 'the mapping', needed)
    if rate is not None and isinstance(content, dict):
        for key in ('time', 'sample_rate'):
            if content.get(key, FILL_IN) != FILL_IN:
                raise ConfigurationError(f'{path} has {key} already: leave the rate out')
        content = {key: x for key, x in content.items() if key != 'time'}
        content['sample_rate'] = rate
    return parse_mapping(content, path)


def open_places(content: Any, where: str = '') -> list[str]:
    """Return the keys, with dots, whose values are still to be filled in."""
    if content == FILL_IN:
        return [where]
    inner = content.items() if isinstance(content, dict) else ()
    return [place for key, x in inner for place in open_places(x, f'{where}.{key}'.lstrip('.'))]


def parse_mapping(content: Any, path: Path) -> ImportMapping:
    """
    Return the checked mapping ``content``; ``path`` is where its files are looked for.

    :raises ConfigurationError: as :func:`read_mapping`.
    """
    read = _Reader(path)
    content = read.table(content, 'the mapping', _TOP_KEYS)
    places = open_places(content)
    if places:
        raise read.error(', '.join(places), f'is left open ({FILL_IN}): fill it in')
    if ('time' in content) == ('sample_rate' in content):
        raise read.error('the mapping', 'needs either time or sample_rate, or --rate beside it')
    if 'joints' not in content:
        raise read.error('the mapping', 'has no joints: name at least one')
    found: dict[str, Any] = {}
    if 'time' in content:
        value = read.table(content['time'], 'time', (*_SERIES_KEYS, 'unit', 'nanoseconds'))
        found['time'] = read.series(value, 'time')
        if 'nanoseconds' in value:
            fine = read.variable(value['nanoseconds'], 'time.nanoseconds')
            found['nanoseconds'] = Series(fine)
        found['ns_per_time_unit'] = TIME_UNITS[read.unit(value, 'time', 'time')]
    else:
        rate = found['sample_rate'] = read.factor(content['sample_rate'], 'sample_rate')
        if not isinstance(rate, str) and rate < 0:
            raise read.error('sample_rate', f'is {rate:g} Hz: it must be positive')
    start = content.get('start_time', 0)
    read.number(start, 'start_time')
    # A whole number of seconds keeps every digit.
    found['start_time_ns'] = start * 10**9 if isinstance(start, int) else round(start * 1e9)
    joints: dict[str, dict[str, Signal]] = {}
    controllers: dict[str, ControllerSource] = {}
    injected: dict[str, Signal] = {}
    for joint, value in read.table(content['joints'], 'joints').items():
        where = f'joints.{joint}'
        quantities = read.table(value, where, (*UNITS, _CONTROLLER, _INJECTED))
        if 'position' not in quantities:
            raise read.error(where, f'has no position: {NO_POSITION.format("its velocity")}')
        joints[joint] = {
            quantity: read.signal(quantities[quantity], f'{where}.{quantity}', quantity)
            for quantity in UNITS
            if quantity in quantities
        }
        units = [signal.unit for signal in joints[joint].values()]
        if _CONTROLLER in quantities:
            loop = read.controller(quantities[_CONTROLLER], f'{where}.{_CONTROLLER}')
            controllers[joint] = loop
            units.append(loop.reference.unit)
        if _INJECTED in quantities:
            added = read.signal(quantities[_INJECTED], f'{where}.{_INJECTED}', 'effort')
            injected[joint] = added
            units.append(added.unit)
        angular = [unit for unit in units if unit in ANGULAR_UNITS]
        linear = [unit for unit in units if unit in LINEAR_UNITS]
        if angular and linear:
            raise read.error(
                where,
                f'has both {angular[0]} and {linear[0]}: a joint either turns (rad, Nm) or slides '
                '(m, N)',
            )
    read.each_its_own(joints)
    found |= {key: read.file(content[key], key) for key in ('urdf', 'model') if key in content}
    if tags := content.get('tags'):
        found['tags'] = {key: str(x) for key, x in read.table(tags, 'tags').items()}
    found |= {key: read.names(content[key], key) for key in ('rows', 'columns') if key in content}
    return ImportMapping(path, joints, controllers=controllers, injected=injected, **found)
