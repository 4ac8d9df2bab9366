# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction laws: lists of terms with a name, as functions of velocity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import TERMS

#: Between the terms of a law that has no name of its own.
JOINED = '+'


@dataclass(frozen=True)
class LawDefinition:
    """
    Hold a friction law: its terms, whose sum it is, and their fixed parameters.

    Parameters of one name are one parameter: both parts of an asymmetric Stribeck term share v_s.
    """

    identifier: str
    terms: tuple[str, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)

    @property
    def kinds(self) -> tuple[type[EffortTerm], ...]:
        """Return the classes of the terms."""
        found = [TERMS[name] for name in self.terms]
        return tuple(kind for kind in found if issubclass(kind, EffortTerm))

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Return the parameters of all terms that are not fixed, in order."""
        names = [name for kind in self.kinds for name in (*kind.amplitudes, *kind.inner)]
        return tuple(name for name in dict.fromkeys(names) if name not in self.fixed)

    def unit(self, name: str, effort_unit: str) -> str:
        """Return the unit of a parameter of a joint whose effort is in Nm or N."""
        kind = next(k for k in self.kinds if name in k.amplitudes or name in k.inner)
        return kind.unit(name, effort_unit)


_LINEAR = ('coulomb', 'viscous')
_ONE, _TWO = {'exponent': 1.0}, {'exponent': 2.0}
#: The laws with a name: (9), (17) and (10) with alpha = 2 of the paper, each also by direction.
#: The exponent is fixed: plateaus cannot separate it from S and v_s.
FRICTION_LAWS: dict[str, LawDefinition] = {
    law.identifier: law
    for law in (
        LawDefinition('coulomb_viscous', (*_LINEAR, 'bias')),
        LawDefinition('stribeck', (*_LINEAR, 'stribeck', 'bias'), _ONE),
        LawDefinition('stribeck_gaussian', (*_LINEAR, 'stribeck', 'bias'), _TWO),
        LawDefinition('coulomb_viscous_asymmetric', (*_LINEAR, 'bias', 'viscous_asymmetry')),
        LawDefinition(
            'stribeck_asymmetric',
            (*_LINEAR, 'stribeck', 'bias', 'viscous_asymmetry', 'stribeck_asymmetry'),
            _ONE,
        ),
        LawDefinition(
            'stribeck_gaussian_asymmetric',
            (*_LINEAR, 'stribeck', 'bias', 'viscous_asymmetry', 'stribeck_asymmetry'),
            _TWO,
        ),
    )
}

#: Lists of terms with a name that ``sosml fit --law`` takes beside the laws above: the extended
#: friction models for servo actuators, each with all terms of one before it.
TERM_LISTS: dict[str, tuple[str, ...]] = {
    'm1': _LINEAR,
    'm2': (*_LINEAR, 'stribeck'),
    'm3': (*_LINEAR, 'load_dependent_friction'),
    'm4': (*_LINEAR, 'stribeck', 'load_dependent_friction', 'load_dependent_stribeck'),
    'm5': (*_LINEAR, 'stribeck', 'directional_load_friction', 'load_dependent_stribeck'),
    'm6': (
        *_LINEAR, 'stribeck', 'directional_load_friction', 'load_dependent_stribeck',
        'quadratic_load_friction',
    ),
}  # fmt: skip


def law_definition(identifier: str) -> LawDefinition:
    """
    Return a law by its name, or by its terms joined by ``+``.

    :raises ConfigurationError: if no law or term has that name, or a term is no function of
        velocity; the sentence lists those that exist.
    """
    if identifier in FRICTION_LAWS:
        return FRICTION_LAWS[identifier]
    names = tuple(filter(None, identifier.split(JOINED)))
    of_law = [name for name, kind in TERMS.classes.items() if kind.of_law]
    if not names or not all(name in of_law for name in names):
        raise ConfigurationError(
            f'friction law {identifier!r} is unknown: use one of {", ".join(FRICTION_LAWS)}, or '
            f'terms joined by +, of {", ".join(of_law)}'
        )
    return LawDefinition(identifier, names)


def law_of(terms: Sequence[str], values: Mapping[str, float]) -> LawDefinition:
    """
    Return the named law that has these terms and these fixed values.

    Without one, return the law of the terms themselves, all of whose numbers are parameters.
    """
    for law in FRICTION_LAWS.values():
        if set(law.terms) == set(terms) and all(
            values.get(name) == value for name, value in law.fixed.items()
        ):
            return law
    ordered = tuple(dict.fromkeys(terms))
    name = JOINED.join(ordered)
    # One term alone whose name is that of a law.
    return LawDefinition(f'{name}{JOINED}' if name in FRICTION_LAWS else name, ordered)


class FrictionLaw:
    """
    Map velocity to friction torque tau_f [Nm or N], positive for positive velocity.

    The sum of the efforts of its terms in steady motion, with the sign s(v) = tanh(v / v0).

    :param smoothing_velocity: v0 of :func:`~sosml_friction.model.smooth_sign.smooth_sign`.
    :raises ConfigurationError: if a parameter is missing, unknown or not finite, or a velocity
        that it is divided by is not positive.
    """

    def __init__(
        self, definition: LawDefinition, parameters: Mapping[str, float], smoothing_velocity: float
    ) -> None:
        names = definition.parameter_names
        self.identifier, self.definition = definition.identifier, definition
        self.parameter_names = names
        unknown = sorted(set(parameters) - set(names))
        missing = [name for name in names if name not in parameters]
        if unknown or missing:
            raise ConfigurationError(
                f'friction law {self.identifier} takes {", ".join(names)}: '
                f'missing {missing or "none"}, unknown {unknown or "none"}'
            )
        for name in names:
            if not np.isfinite(parameters[name]):
                raise ConfigurationError(
                    f'{name} of friction law {self.identifier} is {parameters[name]}: give it a '
                    'finite value'
                )
            if name == 'stribeck_velocity' and not parameters[name] > 0.0:
                raise ConfigurationError(f'{name} is {parameters[name]}: it must be positive')
        if not 0.0 <= smoothing_velocity < np.inf:
            raise ConfigurationError(
                f'smoothing_velocity of friction law {self.identifier} is {smoothing_velocity}: '
                'give it a finite value >= 0'
            )
        self.parameters = {name: float(parameters[name]) for name in names}
        self.smoothing_velocity = float(smoothing_velocity)
        self._terms = [kind() for kind in definition.kinds]

    def rival(self) -> FrictionLaw:
        """Return the law of the same parameters with the rivals of its terms."""
        result = copy(self)
        result._terms = [next(iter(term.rivals()), term) for term in self._terms]
        return result

    def torque(self, v: ArrayLike) -> FloatArray:
        """Return tau_f at velocity ``v`` [rad/s or m/s], same shape."""
        v = np.asarray(v, dtype=float)
        flat = v.reshape(-1, 1)
        values = {**self.definition.fixed, **self.parameters}
        motion = Motion.steady(flat, smooth_sign(flat, self.smoothing_velocity))
        total = np.zeros(len(flat))
        state = np.zeros((len(flat), 0))
        for term in self._terms:
            inner = {name: values[name] for name in term.inner}
            parts = term.effort(motion, 0, inner, state)
            for name, part in zip(term.amplitudes, parts, strict=True):
                total = total + values[name] * part
        return total.reshape(v.shape)


def make_friction_law(
    identifier: str, parameters: Mapping[str, float], smoothing_velocity: float
) -> FrictionLaw:
    """
    Build a friction law from its name in a model file.

    :raises ConfigurationError: as :func:`law_definition` and :class:`FrictionLaw`.
    """
    return FrictionLaw(law_definition(identifier), parameters, smoothing_velocity)


def unit_of(name: str, effort_unit: str) -> str:
    """
    Return the unit of a parameter of a friction law.

    :param name: parameter name, for instance ``viscous``, or ``velocity``.
    :param effort_unit: ``Nm`` for a revolute joint, ``N`` for a prismatic one.
    """
    if name.endswith('velocity'):
        name = 'stribeck_velocity'
    for kind in TERMS.classes.values():
        if kind.of_law and (name in kind.amplitudes or name in kind.inner):
            return kind.unit(name, effort_unit)
    return effort_unit
