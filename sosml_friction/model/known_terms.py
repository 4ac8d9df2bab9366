# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The terms that a model lists beside its friction laws, with their numbers."""

from dataclasses import dataclass

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import (
    ALL_JOINTS,
    DATA_CAUSES,
    ROBOT,
    TERMS,
    Inner,
    Term,
)


@dataclass(frozen=True)
class KnownTerm:
    """Hold a term of known size; ``joint`` is 0 or ``ROBOT`` where it is of the whole robot."""

    term: Term
    joint: int
    inner: Inner
    amplitude: FloatArray

    def simulated(self, robot: Robot) -> SimulatedTerm:
        """Return how it enters the simulation."""
        return self.term.simulated(robot, self.joint, self.inner, self.amplitude)


def known_terms(model: RobotModelFile) -> list[KnownTerm]:
    """
    Return the terms that a model lists, a harmonic each.

    The parameters of the second harmonic end in ``_2``, and so on.

    :raises ConfigurationError: if one is unknown, lacks a parameter, or is in the wrong joint.
    """
    return [found for entry in model.effects for found in read_term(entry, model)]


def read_term(entry: EffectTerm, model: RobotModelFile) -> list[KnownTerm]:
    """Return the harmonics of one entry; errors as of :func:`known_terms`."""
    where = f'effect {entry.effect!r} of model {model.name}'
    # A fault of data or of one occasion: a folder may list it, and nothing comes of it.
    if entry.effect in DATA_CAUSES:
        return []
    if entry.effect not in TERMS.classes:
        raise ConfigurationError(
            f'{where} is unknown: remove it, or use one of {", ".join(TERMS)}'
        )
    kind = TERMS[entry.effect]
    everywhere = entry.joint == ALL_JOINTS and kind.everywhere is not None
    term = kind.everywhere() if everywhere and kind.everywhere else kind()
    if term.of_robot != (entry.joint == ALL_JOINTS):
        wanted = '*, all joints' if term.of_robot else 'one joint'
        raise ConfigurationError(f'{where} is in joint {entry.joint}: it acts in {wanted}')
    joint = ROBOT if everywhere else 0
    if not term.of_robot:
        joint = model.joint_names.index(entry.joint)
    result = []
    for number, own in enumerate(_harmonics(entry, term)):
        try:
            result.append(KnownTerm(term, joint, *term.restore(own)))
        except ConfigurationError as error:
            text = str(error) if number == 0 else f'{error} (part {number + 1})'
            raise ConfigurationError(f'{where} {text}') from None
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
