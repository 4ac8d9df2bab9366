# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A robot: rigid body, rotors, friction and the effects that are known of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.bag import Bag
from sosml_friction.bags.recorded_robot import stated_armature
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import JointModel, RobotModelFile, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.simple_models import skeleton_model
from sosml_friction.mujoco.reading import read_mjcf
from sosml_friction.text_file import read_text


class Model:
    """
    Hold a model; made by :meth:`read`, :meth:`from_urdf`, :meth:`from_mjcf` or :meth:`from_bag`.

    ``content`` is all that the model folder holds.

    :raises ConfigurationError: if it is something else, as the path of the folder.
    """

    def __init__(self, content: RobotModelFile) -> None:
        if not isinstance(content, RobotModelFile):
            raise ConfigurationError(
                f'{content!r} is no content of a model folder: sf.Model.read(folder) reads it'
            )
        self.content = content

    @classmethod
    def read(cls, folder: str | Path) -> Model:
        """
        Read a model folder, or its model.yaml.

        :raises ConfigurationError: if a file is missing, is not YAML, or lacks an entry.
        """
        return cls(read_model(folder))

    @classmethod
    def from_urdf(
        cls,
        urdf: str | Path,
        armature: Mapping[str, float] | float | None = None,
        name: str = '',
        locked: Mapping[str, float] | None = None,
    ) -> Model:
        """
        Make a model without friction from a URDF.

        :param urdf: the document itself, or its path.
        :param armature: by joint, the rotor's inertia at the joint, J N^2 [kg m2 or kg]; 0 where
            the URDF's bodies have it already, NaN where :func:`sosml_friction.fit` is to find it.
            The joints are in this order; a number is that of each joint that moves, None NaN.
        :param name: of the model; the robot's in the URDF if empty.
        :param locked: where joints of the URDF that are not in ``armature`` are held still [rad
            or m]; the others at 0. One that mimics a joint of ``armature`` follows it.
        :raises ConfigurationError: if the URDF cannot be read, or lacks a joint.
        """
        if isinstance(urdf, Path) or '<' not in urdf:
            urdf = read_text(urdf, 'URDF')
        if not isinstance(armature, Mapping):
            each = math.nan if armature is None else armature
            armature = dict.fromkeys(skeleton_model(urdf).joints, each)
        known = [0.0 if math.isnan(value) else value for value in armature.values()]
        robot = Robot(urdf, tuple(armature), known, locked)
        units = ['kg m2' if effort == 'Nm' else 'kg' for effort in robot.effort_units]
        joints = {
            joint: JointModel(Parameter(float(value), unit))
            for (joint, value), unit in zip(armature.items(), units, strict=True)
        }
        own = name or robot.robot_name or 'robot'
        return cls(RobotModelFile(own, joints, urdf, locked=dict(locked or {})))

    @classmethod
    def from_mjcf(cls, path: str | Path) -> Model:
        """
        Read MuJoCo's model of a robot: its bodies, rotors, friction and springs.

        :raises ConfigurationError: as of :func:`sosml_friction.mujoco.reading.read_mjcf`.
        """
        return cls(read_mjcf(path))

    @classmethod
    def from_bag(
        cls,
        bag: str | Path,
        namespace: str | None = None,
        armature: Mapping[str, float] | None = None,
    ) -> Model:
        """
        Return the model that a bag was recorded with.

        :param namespace: which robot, where a bag holds several.
        :param armature: as for :meth:`from_urdf`, where the model does not know it; '*' is every
            other joint. robot_description is enough: the joints are then those recorded.
        :raises BagError: if the bag cannot be read.
        :raises ConfigurationError: if it holds no robot_description.
        """
        opened = Bag.open(bag, namespace)
        return cls(stated_armature(opened, bag, None, None, armature or {}))

    @property
    def name(self) -> str:
        """Return the name of the model."""
        return self.content.name

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the joints, in the order of the columns of all that is computed."""
        return self.content.joint_names

    @property
    def urdf(self) -> str | None:
        """Return the URDF document."""
        return self.content.urdf

    def parameters(self) -> dict[str, dict[str, Parameter]]:
        """Return the friction parameters by joint and name; a joint without friction has none."""
        return {
            name: dict(joint.friction.parameters) if joint.friction else {}
            for name, joint in self.content.joints.items()
        }

    def friction(self, velocity: ArrayLike) -> FloatArray:
        """
        Compute the friction torque at velocities, positive for positive velocity.

        :param velocity: (..., n) [rad/s or m/s]; of one joint also (N,) or a number.
        :return: tau_f [Nm or N], same shape; NaN for a joint whose friction is not known.
        :raises ConfigurationError: if the last axis is not that of the joints.
        """
        v = np.asarray(velocity, dtype=float)
        columns = v[..., None] if len(self.joints) == 1 and v.ndim <= 1 else v
        if columns.shape[-1:] != (len(self.joints),):
            raise ConfigurationError(
                f'velocity has shape {v.shape}: its last axis must be that of the joints '
                f'{", ".join(self.joints)}'
            )
        tau_f = np.full(columns.shape, np.nan)
        for i, joint in enumerate(self.content.joints.values()):
            if joint.friction is not None:
                tau_f[..., i] = joint.friction.make_law().torque(columns[..., i])
        return tau_f.reshape(v.shape)

    def write(self, folder: str | Path) -> Path:
        """
        Write model.yaml and robot.urdf into a folder, made if absent, and return it.

        :raises ConfigurationError: if there is no URDF or the folder cannot be written.
        """
        self.content.write(Path(folder))
        return Path(folder)

    def __repr__(self) -> str:
        parts = []
        for name, joint in self.content.joints.items():
            parts.append(f'{name}: {joint.friction.law if joint.friction else "no friction"}')
        parts += [f'{effect.effect} of {effect.joint}' for effect in self.content.effects]
        return f'<Model {self.name}; {"; ".join(parts)}>'


def one_model(
    model: Model | None, mjcf: str | Path | None, free_rotors: bool = False
) -> RobotModelFile:
    """
    Return what a model holds, or an MJCF.

    :param free_rotors: whether an armature of 0 in the MJCF is one that is not known.
    :raises ConfigurationError: if none or both are given.
    """
    if (model is None) == (mjcf is None):
        raise ConfigurationError('give model or mjcf, and not both')
    return content_of(model) if mjcf is None else read_mjcf(mjcf, free_rotors)


def content_of(model: Model | None) -> RobotModelFile:
    """
    Return what a model holds.

    :raises ConfigurationError: if it is none.
    """
    if not isinstance(model, Model):
        raise ConfigurationError(f'model is {model!r}: give an sf.Model, as sf.Model.read(folder)')
    return model.content
