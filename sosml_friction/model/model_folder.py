# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The model folder: ``model.yaml`` and the URDF it names.

The simulator, the observers and the identifier read this one form; a fitted model is another such
folder with its provenance. ::

    format: sosml_friction/model/1
    name: exoskeleton
    urdf: robot.urdf            # relative to model.yaml
    joints:
      shoulder:
        armature: {value: 0.0054, unit: kg m2}
        friction:               # absent: not known
          law: stribeck
          smoothing_velocity: 0.005
          parameters:
            coulomb: {value: 0.8, unit: Nm}
            ...
    effects:                    # of a diagnosed model: terms of sosml_friction.diagnosis
      - effect: asymmetric_friction
        joint: shoulder         # or '*', all joints
        parameters:
          viscous_asymmetry: {value: 0.1, unit: Nm s/rad}
            ...
    provenance: {...}           # of a fitted model: which data, which versions
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.laws import FrictionLaw, make_friction_law, unit_of
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot

FORMAT = 'sosml_friction/model/1'


@dataclass(frozen=True)
class FrictionParameters:
    """Name a friction law and hold its parameters with their uncertainty."""

    law: str
    smoothing_velocity: float
    parameters: Mapping[str, Parameter]

    def make_law(self) -> FrictionLaw:
        """Build the law; parameters that are flagged take part with their value."""
        values = {name: parameter.value for name, parameter in self.parameters.items()}
        return make_friction_law(self.law, values, self.smoothing_velocity)


@dataclass(frozen=True)
class JointModel:
    """Hold what is known of one joint beyond the URDF. ``armature`` in kg m2 or kg."""

    armature: Parameter
    friction: FrictionParameters | None = None


@dataclass(frozen=True)
class EffectTerm:
    """Hold one term beyond the rigid body and the friction law; ``joint`` '*' is all joints."""

    effect: str
    joint: str
    parameters: Mapping[str, Parameter]


@dataclass(frozen=True)
class RobotModelFile:
    """Hold the content of a model folder; ``urdf`` is the document, not its path."""

    name: str
    joints: Mapping[str, JointModel]
    urdf: str | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    effects: tuple[EffectTerm, ...] = ()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Return the joints in the order of the file."""
        return tuple(self.joints)

    @property
    def is_rigid_body_identified(self) -> bool:
        """Tell whether ``urdf`` has a rigid body that a diagnosis found, in its provenance."""
        found = self.provenance.get('rigid_body')
        return isinstance(found, Mapping) and bool(found.get('written'))

    def make_robot(self, urdf: str | None = None) -> Robot:
        """
        Build the rigid-body model.

        :param urdf: the URDF document of the robot that is really there (``robot_description``);
            the folder's own if None, or where its rigid body was identified: a driver that was
            started with an older one does not know better.
        :raises ConfigurationError: if there is no URDF, or it disagrees with the joints or with
            the units of their parameters (a prismatic joint has N where a revolute has Nm).
        """
        document = urdf
        if urdf is None or (self.urdf is not None and self.is_rigid_body_identified):
            document = self.urdf
        if document is None:
            raise ConfigurationError(
                f'model {self.name} has no URDF: put robot.urdf beside its model.yaml'
            )
        armature = [joint.armature.value for joint in self.joints.values()]
        robot = Robot(document, self.joint_names, armature)
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

    def to_yaml(self, urdf: str = 'robot.urdf') -> str:
        """Return the text of ``model.yaml``; ``urdf`` is the path written into it."""
        joints: dict[str, Any] = {}
        for name, joint in self.joints.items():
            entry: dict[str, Any] = {'armature': joint.armature.to_dict()}
            if joint.friction is not None:
                entry['friction'] = {
                    'law': joint.friction.law,
                    'smoothing_velocity': joint.friction.smoothing_velocity,
                    'parameters': {
                        key: value.to_dict() for key, value in joint.friction.parameters.items()
                    },
                }
            joints[name] = entry
        document: dict[str, Any] = {
            'format': FORMAT,
            'name': self.name,
            'urdf': urdf,
            'joints': joints,
        }
        if self.effects:
            document['effects'] = [
                {
                    'effect': term.effect,
                    'joint': term.joint,
                    'parameters': {key: p.to_dict() for key, p in term.parameters.items()},
                }
                for term in self.effects
            ]
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
    urdf_path = file.parent / str(yaml.safe_load(text).get('urdf', 'robot.urdf'))
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
    try:
        document = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ConfigurationError(f'{where} is not YAML: {_one_line(error)}') from error
    if not isinstance(document, dict) or document.get('format') != FORMAT:
        raise ConfigurationError(f'{where} is not a model: its entry format must be {FORMAT}')
    entries = document.get('joints')
    if not isinstance(entries, dict) or not entries:
        raise ConfigurationError(f'{where} names no joints: list them under joints')
    joints = {
        str(name): _parse_joint(entry, f'{where}: {name}') for name, entry in entries.items()
    }
    provenance = document.get('provenance') or {}
    if not isinstance(provenance, dict):
        raise ConfigurationError(f'{where} has a provenance that is no mapping: remove it')
    effects = _parse_effects(document.get('effects'), tuple(joints), where)
    return RobotModelFile(str(document.get('name', 'robot')), joints, None, provenance, effects)


def _parse_effects(entries: Any, joints: tuple[str, ...], where: str) -> tuple[EffectTerm, ...]:
    if entries is None:
        return ()
    if not isinstance(entries, list):
        raise ConfigurationError(f'{where} has effects that are no list: write one entry for each')
    terms = []
    for k, entry in enumerate(entries):
        label = f'{where}: effects[{k}]'
        if not isinstance(entry, dict) or set(entry) != {'effect', 'joint', 'parameters'}:
            raise ConfigurationError(
                f'{label} must have effect, joint and parameters, and nothing else'
            )
        if entry['joint'] not in (*joints, '*'):
            raise ConfigurationError(
                f'{label} acts in the joint {entry["joint"]!r}: use one of '
                f'{", ".join(joints)}, or * for all'
            )
        if not isinstance(entry['parameters'], dict):
            raise ConfigurationError(f'{label}.parameters is no mapping: name each parameter')
        parameters = {
            str(key): Parameter.from_dict(value, f'{label}.{key}')
            for key, value in entry['parameters'].items()
        }
        terms.append(EffectTerm(str(entry['effect']), str(entry['joint']), parameters))
    return tuple(terms)


def _parse_joint(entry: Any, where: str) -> JointModel:
    if not isinstance(entry, dict) or 'armature' not in entry:
        raise ConfigurationError(
            f'{where} has no armature: give the reflected rotor inertia J N^2, 0 if it is none'
        )
    unknown = sorted(set(entry) - {'armature', 'friction'})
    if unknown:
        raise ConfigurationError(f'{where} has an unknown entry {unknown[0]}: remove it')
    armature = Parameter.from_dict(entry['armature'], f'{where}.armature')
    _require_unit(armature, ('kg m2', 'kg'), f'{where}.armature')
    if not 0.0 <= armature.value < math.inf:
        raise ConfigurationError(
            f'{where}.armature is {armature.value}: give the reflected rotor inertia J N^2, 0 if '
            'it is none'
        )
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
    try:
        smoothing_velocity = float(friction['smoothing_velocity'])
    except (TypeError, ValueError) as error:
        raise ConfigurationError(
            f'{where}.friction.smoothing_velocity is {friction["smoothing_velocity"]!r}: give a '
            'number'
        ) from error
    result = FrictionParameters(str(friction['law']), smoothing_velocity, parameters)
    try:
        result.make_law()
    except ConfigurationError as error:
        raise ConfigurationError(f'{where}.friction: {error}') from error
    return JointModel(armature, result)


def _require_unit(parameter: Parameter, units: tuple[str, ...], where: str) -> None:
    # A value in mNm would be taken for Nm.
    if parameter.unit not in units:
        raise ConfigurationError(
            f'{where} is in {parameter.unit!r}: give it in {units[0]} (revolute) or {units[1]} '
            '(prismatic)'
        )


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split())
