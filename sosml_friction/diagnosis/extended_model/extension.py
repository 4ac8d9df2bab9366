# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The model with what was found: another rigid body, refitted friction, and other causes as terms.

What a cause is says where it lives. Gravity, inertia, payload, a tilted base and the refitted
base parameters are the rigid body: ``robot.urdf`` and ``armature``. Coulomb and viscous friction
are parameters of the joint's law. The rest are terms in ``effects``. Nothing is in two places: a
term that the model states has other numbers, where it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.model.known_terms import labels, read_term
from sosml_friction.model.model_folder import (
    EffectTerm,
    FrictionParameters,
    JointModel,
    RobotModelFile,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.rigid_changes import (
    cause_change,
    change_name,
    refit_change,
    tilted,
    with_changes,
)
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.plain_document import to_plain

#: Law of a joint whose friction the model did not know.
_PLAIN = ('coulomb', 'viscous', 'bias')


def extended_model(
    model: RobotModelFile, diagnosis: Diagnosis, provenance: Mapping[str, Any]
) -> RobotModelFile:
    """
    Return ``model`` with its parameters refitted within the tolerance, and the causes.

    A change of the rigid body that no bodies of positive mass can have stays a term in
    ``effects``; provenance ``rigid_body`` says which and why. A joint without friction gets the
    Coulomb-viscous law that was refitted in its place. Provenance has all causes with their
    evidence (``causes``) and all deviations (``refit``, and ``tolerated`` where they are terms).

    :raises ConfigurationError: if the model has no URDF.
    """
    terms = [
        EffectTerm(cause.effect, cause.joint, cause.parameters)
        for cause in diagnosis.terms
        if cause.in_model and not cause.stated
    ]
    changes = _changes(diagnosis)
    result, terms, rigid = _with_rigid_body(model, diagnosis, terms)
    result, terms = _with_friction(result, diagnosis, terms, changes)
    return replace(
        result,
        effects=(*_changed(model.effects, changes), *terms),
        provenance=to_plain(
            {
                **provenance,
                'causes': diagnosis.causes,
                'tolerated': diagnosis.tolerated,
                'rigid_body': rigid,
                'refit': diagnosis.refit,
            }
        ),
    )


def _changes(diagnosis: Diagnosis) -> dict[str, Parameter]:
    """
    Return by how much each nominal parameter is off, by name: refit and causes together.

    With its standard error where a cause has one, else NaN.
    """
    result = {name: Parameter(value, '') for name, value in diagnosis.refit.items()}
    for cause in diagnosis.terms:
        for name, change in cause.changes.items() if cause.in_model else ():
            result[name] = replace(change, value=result[name].value + change.value)
    return result


def _changed(entries: Sequence[EffectTerm], changes: Mapping[str, Parameter]) -> list[EffectTerm]:
    """Return the terms of a model with the numbers that they have been found to have."""
    result = []
    for entry, label in zip(entries, labels(entries), strict=True):
        parameters = dict(entry.parameters)
        for key, old in entry.parameters.items():
            if change := changes.get(f'{label} {key}'):
                parameters[key] = Parameter(old.value + change.value, old.unit, change.std_error)
        result.append(replace(entry, parameters=parameters))
    return result


def _with_rigid_body(
    model: RobotModelFile, diagnosis: Diagnosis, terms: list[EffectTerm]
) -> tuple[RobotModelFile, list[EffectTerm], dict[str, Any]]:
    """Return the model, the terms that are not in it, and what was done, for the provenance."""
    # What an earlier diagnosis wrote is in the URDF still, and keeps it before the robot's own.
    earlier = model.provenance['rigid_body'] if model.is_rigid_body_identified else {}
    written = list(earlier.get('written', ()))
    if diagnosis.laboratory is None:
        return model, terms, {'written': written, 'refused': {}}
    result, left = model, []
    robot = diagnosis.laboratory.robot
    changes = [refit_change(robot, diagnosis.refit)]
    for term in terms:
        known = next(iter(read_term(term, model)), None)
        if known is None or not isinstance(known.term, BodyTerm):
            left.append(term)
        elif any(c.gravity.any() for c in known.term.changes(robot, known.joint, known.inner)):
            result = tilted(result, term)
            written.append(change_name(term))
        else:
            changes.append(cause_change(robot, known, change_name(term)))
    found = with_changes(result, changes)
    left += [term for term in terms if change_name(term) in found.refused]
    left.sort(key=terms.index)
    return found.model, left, {
        'written': list(dict.fromkeys([*written, *found.written])),
        'refused': dict(found.refused),
    }  # fmt: skip


def _with_friction(
    model: RobotModelFile,
    diagnosis: Diagnosis,
    terms: list[EffectTerm],
    changes: Mapping[str, Parameter],
) -> tuple[RobotModelFile, list[EffectTerm]]:
    """Return the model with refitted friction, and the terms that are not in it."""
    joints, left = {}, list(terms)
    for name, joint in model.joints.items():
        if joint.friction is None:
            joints[name] = replace(joint, friction=_plain_law(name, joint, diagnosis.refit))
            continue
        parameters = {}
        for key, old in joint.friction.parameters.items():
            change = changes.get(f'{name} {key}', Parameter(0.0, ''))
            value, error = old.value + change.value, change.std_error
            term = next((t for t in left if (t.effect, t.joint) == (key, name)), None)
            if term is not None and _is_of_law(key) and value + _change(term) >= 0.0:
                left.remove(term)
                value += _change(term)
                error = term.parameters['change'].std_error
            parameters[key] = Parameter(value, old.unit, error)
        joints[name] = replace(joint, friction=replace(joint.friction, parameters=parameters))
    return replace(model, joints=joints), left


def _is_of_law(name: str) -> bool:
    """Tell whether a cause is a wrong parameter of the friction law."""
    return name in TERMS.classes and TERMS[name].of_law and TERMS[name].parameter_error


def _change(term: EffectTerm) -> float:
    return term.parameters['change'].value


def _plain_law(
    name: str, joint: JointModel, refit: Mapping[str, float]
) -> FrictionParameters | None:
    """Return the friction that was fitted where the model has none; None if it is none."""
    values = [refit.get(f'{name} {key}', np.nan) for key in _PLAIN]
    if not np.isfinite(values).all() or values[0] < 0.0 or values[1] < 0.0:
        return None
    effort, length = ('Nm', 'rad') if joint.armature.unit == 'kg m2' else ('N', 'm')
    units = (effort, f'{effort} s/{length}', effort)
    parameters = {
        key: Parameter(float(value), unit)
        for key, value, unit in zip(_PLAIN, values, units, strict=True)
    }
    return FrictionParameters('coulomb_viscous', 0.0, parameters)
