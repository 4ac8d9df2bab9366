# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What people call observers, parameters and methods, where a table or figure names them."""

from collections.abc import Collection, Iterable
from datetime import datetime, timezone
from typing import Any

from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.study.search import study_variants

#: Parameters of a friction law in the order of every table, with their symbols.
SYMBOLS = {
    'coulomb': 'C',
    'viscous': 'B',
    'stribeck': 'S',
    'stribeck_velocity': 'v_s',
    'bias': 'bias',
}
#: What the parameters are, for a person who does not know the symbols.
PLAIN = {
    'coulomb': 'Coulomb friction C',
    'viscous': 'viscous friction B',
    'stribeck': 'more near standstill S',
    'stribeck_velocity': 'fading over the speed v_s',
    'bias': 'bias, the same both ways',
    'exponent': 'the exponent of v / v_s, where it is not 1',
    'nonlinear_viscous': 'friction at unit speed that grows with a power of speed P',
    'power': 'that power of speed p',
    'viscous_asymmetry': 'difference of B by direction',
    'stribeck_asymmetry': 'difference of S by direction',
}
#: Those that only some laws have.
_OF_SOME = {
    'exponent': 'alpha',
    'nonlinear_viscous': 'P',
    'power': 'p',
    'viscous_asymmetry': 'D_B',
    'stribeck_asymmetry': 'D_S',
}
#: Estimates that no observer makes.
_METHODS = {'weak_form': 'Weak form', 'regression': 'Regression', 'output_error': 'Output error'}
#: What the levels, rows or samples of a fit are called in a sentence.
_PAIRS = {
    'segments': 'the levels of {} steady windows',
    'weak': '{} means of position and effort, without an observer',
    'regression': '{} rows of position and effort, beside the rigid body',
    'output_error': '{} samples of a forward simulation',
}
#: What says an earlier year counts from some start, of a machine or of the recording: no robot of
#: ROS is older. Chosen, no measurement.
_FIRST_YEAR = 2000
_UNITS = {'Nm': ('rad', 'rad/s'), 'N': ('m', 'm/s')}


def _labels() -> dict[str, str]:
    """Return what is known: observers and their variants, from simple to elaborate; methods."""
    variants = {name: variant.label for name, variant in study_variants().items()}
    return variants | {name: o.label for name, o in OBSERVERS.items()} | _METHODS


def observer_label(identifier: str) -> str:
    """Return the short name of an observer, its identifier where it has none."""
    return _labels().get(identifier, identifier)


def fit_label(observer: str, method: str) -> str:
    """Return what a fit is called: observer and method, once where they are the same."""
    label = observer_label(observer)
    return label if observer in _METHODS else f'{label}, {method}'


def pairs_text(method: str, count: int) -> str:
    """Return what a fit was made to, in words with its count."""
    return _PAIRS.get(method, '{} samples in motion').format(count)


def symbols_of(*parameters: Collection[str]) -> dict[str, str]:
    """Return name and symbol of each row that a table of such parameters has."""
    extra = {n: s for n, s in _OF_SOME.items() if any(n in some for some in parameters)}
    return SYMBOLS | extra


def in_order(observers: Iterable[str]) -> list[str]:
    """Return each observer once, the known ones first, from simple to elaborate."""
    known = list(_labels())
    unique = dict.fromkeys(observers)
    return sorted(unique, key=lambda name: known.index(name) if name in known else len(known))


def motion_units(effort_unit: str) -> tuple[str, str]:
    """
    Return the units of position and velocity of a joint.

    :param effort_unit: ``Nm`` for a revolute joint, ``N`` for a prismatic one.
    """
    return _UNITS[effort_unit]


def recorded_at(stamp_ns: Any) -> datetime | None:
    """Return a stamp [ns] as a date, None where it is none, or counts from some start."""
    try:
        found = datetime.fromtimestamp(1e-9 * int(stamp_ns), timezone.utc)
    except (TypeError, ValueError, OverflowError, OSError):
        return None
    return None if found.year < _FIRST_YEAR else found
