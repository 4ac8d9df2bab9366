# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis changes in the rigid body, as a URDF and rotors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.consistent_inertias import consistent_inertias
from sosml_friction.model.known_terms import KnownTerm
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.body_term import BodyTerm
from sosml_friction.model.terms.kinds.simulated_term import Body
from sosml_friction.model.urdf_bodies import with_bodies, with_turned_base

#: What the refit of base parameters is called among the changes.
REFIT = 'refit'


@dataclass(frozen=True)
class Change:
    """Hold additions to ten numbers per body (n, 10) and to the rotors (n,), and their name."""

    name: str
    bodies: FloatArray
    rotors: FloatArray

    def __bool__(self) -> bool:
        """Tell whether anything changes."""
        return bool(self.bodies.any() or self.rotors.any())


@dataclass(frozen=True)
class RigidResult:
    """
    Hold the model with another rigid body.

    ``written``: names of the changes that it has; ``refused``: by name, why one is not in it.
    """

    model: RobotModelFile
    written: tuple[str, ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)


def change_name(term: EffectTerm) -> str:
    """Return how a cause is called among the changes, ``gravity@shoulder``."""
    return f'{term.effect}@{term.joint}'


def refit_change(robot: Robot, refit: Mapping[str, float]) -> Change:
    """Return the refitted deviations of base parameters, named as in :func:`make_nominal`."""
    bodies, rotors = np.zeros((robot.n, 10)), np.zeros(robot.n)
    for i, joint in enumerate(robot.names):
        rotors[i] = refit.get(f'{joint} armature', 0.0)
        for k in range(10):
            bodies[i, k] = refit.get(f'{joint} body {k}', 0.0)
    return Change(REFIT, bodies, rotors)


def cause_change(robot: Robot, term: KnownTerm, name: str) -> Change:
    """Return what a term of the body adds to the ten numbers of the bodies and to the rotors."""
    kind = term.term
    assert isinstance(kind, BodyTerm)
    body = Body.unchanged(robot.n)
    for change, size in zip(
        kind.changes(robot, term.joint, term.inner), term.amplitude, strict=True
    ):
        body.add(change, float(size))
    return Change(name, body.inertias, body.rotors)


def with_changes(model: RobotModelFile, changes: Sequence[Change]) -> RigidResult:
    """
    Return the model whose URDF and rotors have the changes.

    All of them where bodies can have them together; else one after another those that can be
    had with those before, the refit first.

    :raises ConfigurationError: if the model has no URDF.
    """
    changes = [change for change in changes if change]
    if not changes:
        return RigidResult(model)
    robot = model.make_robot()
    try:
        return RigidResult(_applied(model, robot, changes), tuple(c.name for c in changes))
    except ConfigurationError as error:
        reason = str(error)
    result, kept = model, list[Change]()
    refused = {}
    for change in changes:
        try:
            result = _applied(model, robot, [*kept, change])
            kept.append(change)
        except ConfigurationError as error:
            reason = str(error)
            refused[change.name] = reason
    return RigidResult(result, tuple(c.name for c in kept), refused)


def _applied(model: RobotModelFile, robot: Robot, changes: Sequence[Change]) -> RobotModelFile:
    """
    Return the model with the changes.

    :raises ConfigurationError: if no bodies are so.
    """
    own = robot.inertial_parameters()
    rotors = np.array(robot.armature) + sum(c.rotors for c in changes)
    bodies, rotors = consistent_inertias(robot, own + sum(c.bodies for c in changes), rotors)
    names = model.joint_names
    changed = {name: bodies[i] for i, name in enumerate(names) if (bodies[i] != own[i]).any()}
    assert model.urdf is not None
    joints = {}
    for i, (name, joint) in enumerate(model.joints.items()):
        armature = joint.armature
        if rotors[i] != armature.value:
            armature = Parameter(float(rotors[i]), armature.unit)
        joints[name] = replace(joint, armature=armature)
    return replace(model, joints=joints, urdf=with_bodies(model.urdf, changed, robot.held))


def tilted(model: RobotModelFile, term: EffectTerm) -> RobotModelFile:
    """
    Return the model whose base is turned by ``rotation_x`` and ``rotation_y`` [rad].

    A rotation by their vector: the effect's columns are its first order.
    """
    assert model.urdf is not None
    vector = [term.parameters[f'rotation_{axis}'].value for axis in 'xy']
    return replace(model, urdf=with_turned_base(model.urdf, np.array([*vector, 0.0])))
