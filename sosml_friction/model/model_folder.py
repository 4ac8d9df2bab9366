# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The model folder: ``model.yaml`` and the URDF it names.

The simulator, the observers and the identifier read this one form; a fitted model is another such
folder with its provenance. ::

    format: sosml_friction/model/2
    name: exoskeleton
    urdf: robot.urdf            # relative to model.yaml
    joints:
      shoulder:
        armature: {value: 0.0054, unit: kg m2}
        smoothing_velocity: 0.005   # of the sign in its friction law; absent: the sign itself
      elbow:                    # an armature that is not known has a reason in place of a value
        armature: {value: null, unit: kg m2, reason: the rotor is not known}
    locked:                     # where joints of the URDF that are not above stand; absent: at 0
      finger: 0.02
    terms:                      # in the order in which measurement terms act; absent: not known
      - term: coulomb
        joint: shoulder         # or '*', all joints
        parameters:
          coulomb: {value: 0.8, unit: Nm}
      ...
    provenance: {...}           # of a fitted model: which data, which versions

Terms that are functions of velocity make a joint's friction law. Format 1, which had a law by name
in each joint and the other terms under ``effects``, is read all the same.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.laws import (
    FrictionLaw,
    law_definition,
    law_of,
    make_friction_law,
    unit_of,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.term import DATA_CAUSES, TERMS
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.plain_document import to_plain
from sosml_friction.yaml_text import parse_yaml

#: A joint that moves by more is told not to rest [rad or m]. Chosen, no measurement: it turns a
#: weight by a hundredth.
_REST = 0.01
FORMAT = 'sosml_friction/model/2'
_FORMAT_1 = 'sosml_friction/model/1'


@dataclass(frozen=True)
class FrictionParameters:
    """Name a friction law and hold its parameters with their uncertainty."""

    law: str
    smoothing_velocity: float
    parameters: Mapping[str, Parameter]

    def by_term(self) -> list[tuple[str, dict[str, Parameter]]]:
        """Return the parameters of each term of the law, the fixed ones too."""
        law = law_definition(self.law)
        values = {n: Parameter(x, '1') for n, x in law.fixed.items()} | dict(self.parameters)
        return [
            (kind.identifier, {n: values[n] for n in (*kind.amplitudes, *kind.inner)})
            for kind in law.kinds
        ]

    def make_law(self) -> FrictionLaw:
        """Build the law; parameters that are flagged take part with their value."""
        values = {name: parameter.value for name, parameter in self.parameters.items()}
        return make_friction_law(self.law, values, self.smoothing_velocity)


@dataclass(frozen=True)
class JointModel:
    """
    Hold what is known of one joint beyond the URDF. ``armature`` in kg m2 or kg, NaN: not known.

    ``smoothing_velocity`` [rad/s or m/s]: of the sign in its law, where the law is still to come.
    """

    armature: Parameter
    friction: FrictionParameters | None = None
    smoothing_velocity: float = field(default=0.0, compare=False)

    @property
    def sign_width(self) -> float:
        """Return v0 of the sign of its friction [rad/s or m/s], 0 for the sign itself."""
        return (self.friction or self).smoothing_velocity


@dataclass(frozen=True)
class EffectTerm:
    """Hold one term beyond the rigid body and the friction law; ``joint`` '*' is all joints."""

    effect: str
    joint: str
    parameters: Mapping[str, Parameter]


@dataclass(frozen=True)
class RobotModelFile:
    """
    Hold the content of a model folder; ``urdf`` is the document, not its path.

    ``locked``: positions [rad or m] of joints of the URDF that are held still; those that neither
    ``joints`` nor it names are held at 0. ``remarks``: sentences that its robot is to say.
    """

    name: str
    joints: Mapping[str, JointModel]
    urdf: str | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    effects: tuple[EffectTerm, ...] = ()
    locked: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = field(default=(), compare=False)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Return the joints in the order of the file."""
        return tuple(self.joints)

    @property
    def unknown_armature(self) -> tuple[str, ...]:
        """Return the joints whose armature is not known."""
        return tuple(n for n, joint in self.joints.items() if math.isnan(joint.armature.value))

    def with_armature(self, armature: Mapping[str, float], reason: str = '') -> RobotModelFile:
        """
        Return the model with the armatures that it does not know; those that it does stay.

        :param armature: by joint [kg m2 or kg]; '*' is every joint that is not named.
        :param reason: where the values come from.
        :raises ConfigurationError: if a joint is not of the model or a value cannot be.
        """
        for name, value in armature.items():
            if name not in (*self.joints, '*'):
                raise ConfigurationError(
                    f'an armature is stated for {name}, which is no joint of model {self.name}: '
                    f'use one of {", ".join(self.joints)}'
                )
            if not 0.0 <= value < math.inf:
                raise ConfigurationError(
                    f'the armature of {name} is {value:g}: give the reflected rotor inertia '
                    'J N^2, 0 if the bodies of the URDF have it'
                )
        joints = dict(self.joints)
        for name in self.unknown_armature:
            if name in armature or '*' in armature:
                own = armature[name if name in armature else '*']
                known = Parameter(float(own), joints[name].armature.unit, reason=reason)
                joints[name] = replace(joints[name], armature=known)
        return replace(self, joints=joints)

    def with_locked(self, locked: Mapping[str, float]) -> RobotModelFile:
        """
        Return the model with joints held still at positions [rad or m] beside those that are.

        :raises ConfigurationError: if it is left without a joint.
        """
        joints = {name: joint for name, joint in self.joints.items() if name not in locked}
        if not joints:
            raise ConfigurationError(f'all joints of model {self.name} are locked: leave one')
        return replace(self, joints=joints, locked={**self.locked, **locked})

    @property
    def unseen(self) -> tuple[str, ...]:
        """Return the joints that it has only because a URDF has them: nobody measured them yet."""
        listed = self.provenance.get('not_known')
        return tuple(n for n in self.joints if isinstance(listed, Mapping) and n in listed)

    def of_measured(self, names: Collection[str]) -> RobotModelFile:
        """Return the model without joints that are :attr:`unseen` and not in ``names``."""
        left_out = [name for name in self.unseen if name not in names]
        if len(left_out) == len(self.joints):
            return self
        joints = {name: joint for name, joint in self.joints.items() if name not in left_out}
        effects = tuple(term for term in self.effects if term.joint not in left_out)
        return replace(self, joints=joints, effects=effects)

    def held_where_measured(
        self, measured: Mapping[str, tuple[float, float]], urdf: str | None = None
    ) -> RobotModelFile:
        """
        Return the model with joints that it neither has nor locks held where they were measured.

        :param measured: position and range of joints [rad or m]; those not of the URDF do not
            matter, nor do those that mimic others.
        :param urdf: the document, None for the model's.
        """
        stated = read_joints(urdf or self.urdf or '<robot/>').joints
        locked, remarks = dict(self.locked), list(self.remarks)
        for name, (position, moved) in measured.items():
            joint = stated.get(name)
            if joint is None or name in self.joints or name in self.locked:
                continue
            if joint.mimic is None and joint.is_single and math.isfinite(position):
                locked[name] = position
                way = 'm' if joint.kind == 'prismatic' else 'rad'
                remarks.append(
                    f'joint {name} is not in the model and held at {position:.4g} {way}, where it '
                    'was measured first'
                    + (f'; it moves by {moved:.2g} {way} all the same' if moved > _REST else '')
                )
        return replace(self, locked=locked, remarks=tuple(remarks))

    @property
    def is_rigid_body_identified(self) -> bool:
        """Tell whether ``urdf`` has a rigid body that a diagnosis found, in its provenance."""
        found = self.provenance.get('rigid_body')
        return isinstance(found, Mapping) and bool(found.get('written'))

    def make_robot(self, urdf: str | None = None) -> Robot:
        """
        Build the rigid-body model.

        :param urdf: the URDF document of the actual robot (``robot_description``). The folder's
            own is used if this is None, or if the folder's rigid body was identified: a driver
            that was started before has an older one.
        :raises ConfigurationError: if there is no URDF, or it disagrees with the joints or with
            the units of their parameters (a prismatic joint has N where a revolute has Nm), or if
            an armature is not known.
        """
        document = urdf
        if urdf is None or (self.urdf is not None and self.is_rigid_body_identified):
            document = self.urdf
        if document is None:
            raise ConfigurationError(
                f'model {self.name} has no URDF: put robot.urdf beside its model.yaml'
            )
        if self.unknown_armature:
            raise ConfigurationError(
                f'the armature of joint {", ".join(self.unknown_armature)} is not known (model '
                f'{self.name}): sosml fit finds it, or set it in model.yaml, or state it with '
                '--armature, in a node with the parameter armature: J N^2 of the rotor, 0 if the '
                'bodies of the URDF have it'
            )
        armature = [joint.armature.value for joint in self.joints.values()]
        robot = Robot(document, self.joint_names, armature, self.locked)
        robot.remarks = (*self.remarks, *robot.remarks)
        for (name, joint), effort in zip(self.joints.items(), robot.effort_units, strict=True):
            inertia = 'kg m2' if effort == 'Nm' else 'kg'
            if joint.armature.unit != inertia:
                raise ConfigurationError(
                    f'armature of joint {name} of model {self.name} is in {joint.armature.unit} '
                    f'where the URDF makes its effort {effort}: give it in {inertia}'
                )
            for key, parameter in joint.friction.parameters.items() if joint.friction else ():
                if parameter.unit != unit_of(key, effort):
                    raise ConfigurationError(
                        f'{key} of joint {name} of model {self.name} is in {parameter.unit} where '
                        f'the URDF makes its effort {effort}: give it in {unit_of(key, effort)}'
                    )
        return robot

    def friction_laws(self) -> list[FrictionLaw]:
        """
        Build the friction law of every joint, in order.

        :raises ConfigurationError: if a joint has none.
        """
        laws = []
        for name, joint in self.joints.items():
            if joint.friction is None:
                raise ConfigurationError(
                    f'joint {name} of model {self.name} has no friction: fit one or write it'
                )
            laws.append(joint.friction.make_law())
        return laws

    def law_terms(self) -> list[EffectTerm]:
        """Return the terms that the friction laws of the joints are made of."""
        return [
            EffectTerm(term, name, parameters)
            for name, joint in self.joints.items()
            if joint.friction is not None
            for term, parameters in joint.friction.by_term()
        ]

    def to_yaml(self, urdf: str = 'robot.urdf') -> str:
        """Return the text of ``model.yaml``; ``urdf`` is the path written into it."""
        joints: dict[str, Any] = {}
        for name, joint in self.joints.items():
            joints[name] = {'armature': joint.armature.to_dict()}
            if joint.friction is not None:
                joints[name]['smoothing_velocity'] = joint.friction.smoothing_velocity
        terms = [
            to_plain({'term': x.effect, 'joint': x.joint, 'parameters': x.parameters})
            for x in (*self.law_terms(), *self.effects)
        ]
        document: dict[str, Any] = {
            'format': FORMAT,
            'name': self.name,
            'urdf': urdf,
            'joints': joints,
        }
        if self.locked:
            document['locked'] = dict(self.locked)
        if terms:
            document['terms'] = terms
        if self.provenance:
            document['provenance'] = dict(self.provenance)
        return yaml.safe_dump(document, sort_keys=False, allow_unicode=True)

    def write(self, folder: Path) -> None:
        """
        Write ``model.yaml`` and ``robot.urdf`` into ``folder``, made if absent.

        :raises ConfigurationError: if there is no URDF to write or the folder cannot be written.
        """
        if self.urdf is None:
            raise ConfigurationError(f'model {self.name} has no URDF to write beside model.yaml')
        try:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / 'robot.urdf').write_text(self.urdf, encoding='utf-8')
            (folder / 'model.yaml').write_text(self.to_yaml(), encoding='utf-8')
        except OSError as error:
            raise ConfigurationError(
                f'model folder {folder} cannot be written: {error}'
            ) from error


def read_model(path: str | Path) -> RobotModelFile:
    """
    Read a model folder, or its ``model.yaml``.

    :raises ConfigurationError: if a file is missing, is not YAML, or lacks an entry.
    """
    path = Path(path)
    file = path / 'model.yaml' if path.is_dir() else path
    try:
        text = file.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(
            f'model {path} cannot be read: give a folder that holds model.yaml'
        ) from error
    model = parse_model(text, str(file))
    urdf_path = file.parent / str(parse_yaml(text, str(file)).get('urdf', 'robot.urdf'))
    try:
        urdf = urdf_path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(
            f'the URDF {urdf_path} named in {file} cannot be read: correct its entry urdf'
        ) from error
    return replace(model, urdf=urdf)


def parse_model(text: str, where: str) -> RobotModelFile:
    """
    Read the text of a ``model.yaml``, without its URDF.

    :param where: the file or topic it came from, for the error sentence.
    :raises ConfigurationError: if it is not YAML of this format or lacks an entry.
    """
    document = parse_yaml(text, where)
    version = document.get('format') if isinstance(document, dict) else None
    if version not in (FORMAT, _FORMAT_1):
        raise ConfigurationError(f'{where} is not a model: its entry format must be {FORMAT}')
    entries = document.get('joints')
    if not isinstance(entries, dict) or not entries:
        raise ConfigurationError(f'{where} names no joints: list them under joints')
    if version == _FORMAT_1:
        parse, key, kind = _parse_joint_1, 'effects', 'effect'
    else:
        parse, key, kind = _parse_joint, 'terms', 'term'
        known = ('format', 'name', 'urdf', 'joints', 'locked', 'terms', 'provenance')
        unknown = sorted(map(str, set(document) - set(known)))
        if unknown:
            raise ConfigurationError(
                f'{where} has an unknown entry {unknown[0]}: remove it, or use one of '
                f'{", ".join(known)}'
            )
    joints = {str(name): parse(entry, f'{where}: {name}') for name, entry in entries.items()}
    provenance = document.get('provenance') or {}
    if not isinstance(provenance, dict):
        raise ConfigurationError(f'{where} has a provenance that is no mapping: remove it')
    effects = _parse_terms(document.get(key), tuple(joints), where, key, kind)
    if version == FORMAT:
        joints, effects = _with_laws(joints, effects, where)
    locked = _parse_locked(document.get('locked'), where)
    name = str(document.get('name', 'robot'))
    return RobotModelFile(name, joints, None, provenance, effects, locked)


def _parse_locked(entries: Any, where: str) -> dict[str, float]:
    try:
        return {str(name): float(position) for name, position in (entries or {}).items()}
    except (AttributeError, TypeError, ValueError) as error:
        raise ConfigurationError(
            f'{where} has locked: {entries!r}: give each joint that is held still its position '
            '[rad or m]'
        ) from error


def _parse_terms(
    entries: Any, joints: tuple[str, ...], where: str, key: str, kind: str
) -> tuple[EffectTerm, ...]:
    if entries is None:
        return ()
    if not isinstance(entries, list):
        raise ConfigurationError(f'{where} has {key} that are no list: write one entry for each')
    terms = []
    for k, entry in enumerate(entries):
        label = f'{where}: {key}[{k}]'
        if not isinstance(entry, dict) or set(entry) != {kind, 'joint', 'parameters'}:
            raise ConfigurationError(
                f'{label} must have {kind}, joint and parameters, and nothing else'
            )
        if entry['joint'] not in (*joints, '*'):
            raise ConfigurationError(
                f'{label} acts in the joint {entry["joint"]!r}: use one of '
                f'{", ".join(joints)}, or * for all'
            )
        if not isinstance(entry['parameters'], dict):
            raise ConfigurationError(f'{label}.parameters is no mapping: name each parameter')
        parameters = {
            str(name): Parameter.from_dict(value, f'{label}.{name}')
            for name, value in entry['parameters'].items()
        }
        terms.append(EffectTerm(str(entry[kind]), str(entry['joint']), parameters))
    return tuple(terms)


def _with_laws(
    joints: Mapping[str, JointModel], terms: tuple[EffectTerm, ...], where: str
) -> tuple[dict[str, JointModel], tuple[EffectTerm, ...]]:
    """Return the joints with the laws that their terms make, and the terms that are left."""
    result, left = dict(joints), []
    own: dict[str, list[EffectTerm]] = {}
    for term in terms:
        if term.effect not in (*TERMS, *DATA_CAUSES):
            raise ConfigurationError(
                f'{where} has an unknown term {term.effect!r}: remove it, or use one of '
                f'{", ".join(TERMS)}'
            )
        # A deviation from a law, which a diagnosis writes where it cannot be in the law.
        deviates = 'change' in term.parameters
        if term.effect in TERMS.classes and TERMS[term.effect].of_law and not deviates:
            own.setdefault(term.joint, []).append(term)
        else:
            left.append(term)
    for name, of_law in own.items():
        if name not in result:
            raise ConfigurationError(
                f'{where} has the term {of_law[0].effect} in {name}: a friction law is of a joint'
            )
        parameters: dict[str, Parameter] = {}
        for term in of_law:
            kind = TERMS[term.effect]
            names = (*kind.amplitudes, *kind.inner)
            label = f'{where}: {name}.{term.effect}'
            if set(term.parameters) != set(names):
                raise ConfigurationError(
                    f'{label} has {", ".join(term.parameters) or "no parameters"}: give it '
                    f'{", ".join(names)}'
                )
            for key, parameter in term.parameters.items():
                units = tuple(kind.unit(key, effort) for effort in ('Nm', 'N'))
                _require_unit(parameter, units, f'{label}.{key}')
                if key in parameters and parameters[key].value != parameter.value:
                    raise ConfigurationError(
                        f'{label}.{key} is {parameter.value} where another term of the joint has '
                        f'{parameters[key].value}: they share it'
                    )
                parameters[key] = parameter
        law = law_of([t.effect for t in of_law], {k: p.value for k, p in parameters.items()})
        smoothing = result[name].smoothing_velocity
        values = {key: parameters[key] for key in law.parameter_names}
        friction = FrictionParameters(law.identifier, smoothing, values)
        checked = _checked(friction, f'{where}: {name}')
        result[name] = JointModel(result[name].armature, checked)
    return result, tuple(left)


def _parse_joint(entry: Any, where: str) -> JointModel:
    armature = _parse_armature(entry, where, 'smoothing_velocity')
    smoothing = entry.get('smoothing_velocity', 0.0)
    return JointModel(armature, None, _smoothing_velocity(smoothing, where))


def _parse_armature(entry: Any, where: str, other: str) -> Parameter:
    if not isinstance(entry, dict) or 'armature' not in entry:
        raise ConfigurationError(
            f'{where} has no armature: give the reflected rotor inertia J N^2, 0 if it is none'
        )
    unknown = sorted(set(entry) - {'armature', other})
    if unknown:
        raise ConfigurationError(f'{where} has an unknown entry {unknown[0]}: remove it')
    armature = Parameter.from_dict(entry['armature'], f'{where}.armature')
    _require_unit(armature, ('kg m2', 'kg'), f'{where}.armature')
    if math.isnan(armature.value) and armature.reason:
        return armature
    if not 0.0 <= armature.value < math.inf:
        raise ConfigurationError(
            f'{where}.armature is {armature.value}: give the reflected rotor inertia J N^2, 0 if '
            'it is none, or null with a reason where it is not known'
        )
    return armature


def _smoothing_velocity(value: Any, where: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(
            f'{where}.smoothing_velocity is {value!r}: give a number'
        ) from error


def _checked(friction: FrictionParameters, where: str) -> FrictionParameters:
    """Return a law that can be made; the sentence says what is wrong with one that cannot."""
    try:
        friction.make_law()
    except ConfigurationError as error:
        raise ConfigurationError(f'{where}.friction: {error}') from error
    return friction


def _parse_joint_1(entry: Any, where: str) -> JointModel:
    armature = _parse_armature(entry, where, 'friction')
    friction = entry.get('friction')
    if friction is None:
        return JointModel(armature)
    entries = {'law', 'smoothing_velocity', 'parameters'}
    if not isinstance(friction, dict) or set(friction) != entries:
        raise ConfigurationError(
            f'{where}.friction must have law, smoothing_velocity (0 for the sign itself) and '
            'parameters, and nothing else'
        )
    if not isinstance(friction['parameters'], dict):
        raise ConfigurationError(
            f'{where}.friction.parameters is {friction["parameters"]!r}: give one entry for each '
            'parameter of the law'
        )
    parameters = {}
    for key, value in friction['parameters'].items():
        parameter = Parameter.from_dict(value, f'{where}.friction.{key}')
        units = (unit_of(str(key), 'Nm'), unit_of(str(key), 'N'))
        _require_unit(parameter, units, f'{where}.friction.{key}')
        parameters[str(key)] = parameter
    smoothing = _smoothing_velocity(friction['smoothing_velocity'], f'{where}.friction')
    result = FrictionParameters(str(friction['law']), smoothing, parameters)
    return JointModel(armature, _checked(result, where))


def _require_unit(parameter: Parameter, units: tuple[str, ...], where: str) -> None:
    # A value in mNm would be taken for Nm.
    if parameter.unit not in units:
        raise ConfigurationError(
            f'{where} is in {parameter.unit!r}: give it in {units[0]} (revolute) or {units[1]} '
            '(prismatic)'
        )
