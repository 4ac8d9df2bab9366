# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The terms that a model lists beside its friction laws, with their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import (
    DATA_CAUSES,
    ROBOT,
    TERMS,
    Inner,
    Term,
)
from sosml_friction.model.terms.kinds.transmission_term import TransmissionTerm

#: Terms of a law whose numbers are nominal parameters wherever there is friction.
CONSTANTS = ('coulomb', 'viscous', 'bias')


@dataclass(frozen=True)
class KnownTerm:
    """
    Hold a term of known size; ``joint`` is 0 or ``ROBOT`` where it is of the whole robot.

    ``names``: what its amplitudes are called among the parameters of the model, such as
    ``shoulder spring stiffness``, or ``shoulder stribeck`` where it is part of a law.
    """

    term: Term
    joint: int
    inner: Inner
    amplitude: FloatArray
    names: tuple[str, ...] = ()

    def following(self, displacement: float) -> KnownTerm | None:
        """Return the term that follows its level over a displacement; None where none can."""
        further = self.term.further(displacement)
        return further and replace(self, inner={**self.inner, **further[1]})

    def lacks(self, signals: Recording, other: KnownTerm) -> FloatArray:
        """Return what the same term has more of effort (N, n) with other inner parameters."""
        if self.inner == other.inner:
            return np.zeros_like(signals.q)
        after, before = (x.term.columns(signals, x.joint, x.inner) for x in (other, self))
        return np.asarray((after - before) @ self.amplitude)

    def simulated(self, robot: Robot) -> SimulatedTerm:
        """Return how it enters the simulation."""
        return self.term.simulated(robot, self.joint, self.inner, self.amplitude)


def known_terms(model: RobotModelFile) -> list[KnownTerm]:
    """
    Return the terms that a model lists, a harmonic each.

    The parameters of the second harmonic end in ``_2``, and so on.

    :raises ConfigurationError: if one is unknown, lacks a parameter, or is in the wrong joint.
    """
    return [
        replace(found, names=tuple(f'{label} {key}' for key in found.names))
        for entry, label in zip(model.effects, labels(model.effects), strict=True)
        for found in read_term(entry, model)
    ]


def labels(entries: Sequence[EffectTerm]) -> list[str]:
    """Return what each entry is called, ``shoulder spring``; the second alike has a 2 besides."""
    result: list[str] = []
    seen: dict[tuple[str, str], int] = {}
    for entry in entries:
        number = seen[entry.joint, entry.effect] = seen.get((entry.joint, entry.effect), 0) + 1
        result.append(f'{entry.joint} {entry.effect}{f" {number}" if number > 1 else ""}')
    return result


def stated_terms(model: RobotModelFile) -> list[KnownTerm]:
    """
    Return the terms that a model states with numbers that may be off, but for C, B and the bias.

    Those of its laws, and those that it lists. The amplitude of a gear is no number of it.
    """
    result = []
    for entry in model.law_terms():
        if entry.effect not in CONSTANTS:
            term, i = TERMS[entry.effect](), model.joint_names.index(entry.joint)
            names = tuple(f'{entry.joint} {key}' for key in term.amplitudes)
            result.append(KnownTerm(term, i, *term.restore(entry.parameters), names))
    listed = known_terms(model)
    return result + [own for own in listed if not isinstance(own.term, TransmissionTerm)]


def read_term(entry: EffectTerm, model: RobotModelFile) -> list[KnownTerm]:
    """Return the harmonics of one entry, named as in it; errors as of :func:`known_terms`."""
    where = f'effect {entry.effect!r} of model {model.name}'
    # A fault of data or of one occasion: a folder may list it, and nothing comes of it.
    if entry.effect in DATA_CAUSES:
        return []
    if entry.effect not in TERMS.classes:
        raise ConfigurationError(
            f'{where} is unknown: remove it, or use one of {", ".join(TERMS)}'
        )
    kind = TERMS[entry.effect]
    term = kind.acting_in(entry.joint)
    if term is None:
        wanted = '*, all joints' if kind.of_robot else 'one joint'
        raise ConfigurationError(f'{where} is in joint {entry.joint}: it acts in {wanted}')
    joint = ROBOT if kind.counterpart else 0
    if not term.of_robot:
        joint = model.joint_names.index(entry.joint)
    result = []
    for number, own in enumerate(_harmonics(entry, term)):
        try:
            own = dict(term.of_older(own, model.make_robot))
            inner, amplitude = term.restore(own)
        except ConfigurationError as error:
            text = str(error) if number == 0 else f'{error} (part {number + 1})'
            raise ConfigurationError(f'{where} {text}') from None
        ending = f'_{number + 1}' if number else ''
        keys = (name if name in own else term.reported_as[name] for name in term.amplitudes)
        names = tuple(f'{key}{ending}' for key in keys)
        result.append(KnownTerm(term, joint, inner, amplitude, names))
    return result


def _harmonics(entry: EffectTerm, term: Term) -> list[dict[str, Parameter]]:
    """Return the parameters of each harmonic by the names of the first."""
    names = {term.reported_as.get(k, k) for k in (*term.amplitudes, *term.inner)}
    names |= {*term.amplitudes, *term.inner}
    parts: dict[int, dict[str, Parameter]] = {1: {}}
    for key, value in entry.parameters.items():
        base, _, number = key.rpartition('_')
        if base in names and number.isdigit() and int(number) > 1:
            parts.setdefault(int(number), {})[base] = value
        else:
            parts[1][key] = value
    return [parts[number] for number in sorted(parts)]


def model_friction(model: RobotModelFile) -> JointFriction:
    """Return the friction laws of a model for the simulation; a joint without one has none."""
    return JointFriction(
        [
            None if joint.friction is None else joint.friction.make_law()
            for joint in model.joints.values()
        ]
    )
