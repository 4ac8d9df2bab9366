# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What people call observers, parameters and methods, where a table or figure names them."""

from __future__ import annotations

from collections.abc import Iterable

#: Parameters of a friction law in the order of every table, with their symbols.
SYMBOLS = {
    'coulomb': 'C',
    'viscous': 'B',
    'stribeck': 'S',
    'stribeck_velocity': 'v_s',
    'bias': 'bias',
}
#: Parameters that cannot be negative.
NON_NEGATIVE = ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity')

_OBSERVERS = {'first_order': 'FO', 'sosml': 'SOSML'}
_UNITS = {'Nm': ('rad', 'rad/s'), 'N': ('m', 'm/s')}


def observer_label(identifier: str) -> str:
    """Return the short name of an observer, its identifier where it has none."""
    return _OBSERVERS.get(identifier, identifier)


def in_order(observers: Iterable[str]) -> list[str]:
    """Return each observer once, the known ones first and in the order FO, SOSML."""
    known = list(_OBSERVERS)
    unique = dict.fromkeys(observers)
    return sorted(unique, key=lambda name: known.index(name) if name in known else len(known))


def motion_units(effort_unit: str) -> tuple[str, str]:
    """
    Return the units of position and velocity of a joint.

    :param effort_unit: ``Nm`` for a revolute joint, ``N`` for a prismatic one.
    """
    return _UNITS[effort_unit]
