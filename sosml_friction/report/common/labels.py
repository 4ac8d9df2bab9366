# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What people call observers, parameters and methods, where a table or figure names them."""

from __future__ import annotations

from collections.abc import Collection, Iterable

#: Parameters of a friction law in the order of every table, with their symbols.
SYMBOLS = {
    'coulomb': 'C',
    'viscous': 'B',
    'stribeck': 'S',
    'stribeck_velocity': 'v_s',
    'bias': 'bias',
}
#: Those that only laws have that differ with direction.
_ASYMMETRIES = {'viscous_asymmetry': 'D_B', 'stribeck_asymmetry': 'D_S'}
_OBSERVERS = {
    'first_order_capped': 'FO capped',
    'quasi_static': 'Quasi-static',
    'first_order': 'FO',
    'first_order_prefiltered': 'FO+prefilter',
    'linear_second_order': 'LIN2',
    'sosml': 'SOSML',
    'sosml_explicit': 'SOSML explicit',
    'kalman': 'Kalman',
    'kalman_adaptive': 'Kalman adaptive',
    'kalman_scheduled': 'Kalman scheduled',
    'kalman_imm': 'Kalman IMM',
    'kalman_stribeck': 'Kalman+law',
    'kalman_stribeck_wrong_knee': 'Kalman+wrong law',
    'smoother': 'Smoother',
    'weak_form': 'Weak form',
    'output_error': 'Output error',
}
_UNITS = {'Nm': ('rad', 'rad/s'), 'N': ('m', 'm/s')}


def observer_label(identifier: str) -> str:
    """Return the short name of an observer, its identifier where it has none."""
    return _OBSERVERS.get(identifier, identifier)


def fit_label(observer: str, method: str) -> str:
    """Return what a fit is called: observer and method, once where they are the same."""
    label = observer_label(observer)
    return label if observer in ('weak_form', 'output_error') else f'{label}, {method}'


def symbols_of(*parameters: Collection[str]) -> dict[str, str]:
    """Return name and symbol of each row that a table of such parameters has."""
    extra = {n: s for n, s in _ASYMMETRIES.items() if any(n in some for some in parameters)}
    return SYMBOLS | extra


def in_order(observers: Iterable[str]) -> list[str]:
    """Return each observer once, the known ones first, from simple to elaborate."""
    known = list(_OBSERVERS)
    unique = dict.fromkeys(observers)
    return sorted(unique, key=lambda name: known.index(name) if name in known else len(known))


def motion_units(effort_unit: str) -> tuple[str, str]:
    """
    Return the units of position and velocity of a joint.

    :param effort_unit: ``Nm`` for a revolute joint, ``N`` for a prismatic one.
    """
    return _UNITS[effort_unit]
