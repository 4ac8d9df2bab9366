# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The model that a node was started with, or that robot_description makes with an armature."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import RobotModelFile, read_model
from sosml_friction.model.robot import Robot
from sosml_friction.model.simple_models import skeleton_model
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.nodes.parameters import ParameterSpec
from sosml_friction.share import share_directory

#: The robot of the model that is taken where none is stated, as its URDF names it.
_EXOSKELETON = 'exoskeleton'

#: For every node that can do without a model.
WITHOUT_MODEL = (
    ParameterSpec(
        'armature',
        'double_array',
        [],
        'inertia of the rotor at the joint, J N^2, where the model does not know it: one for all '
        'joints, or one for each of the model; 0 where the bodies of the URDF have it. With it '
        'and without a model, the robot is that of robot_description',
        'kg m2 or kg',
    ),
    ParameterSpec(
        'joints',
        'string_array',
        [],
        'with armature and without a model: the joints of the robot; the others are held still. '
        'Empty: those that joint_states names',
    ),
)


class StatedModel:
    """
    Hold what parameters ``model``, ``armature`` and ``joints`` state.

    ``model`` is None as long as it is to be made of robot_description and ``joints``, or those
    that are measured where they are empty (:meth:`make`); ``label`` says where it comes from.

    :raises ConfigurationError: if the model cannot be read or the armature does not fit.
    """

    def __init__(self, parameters: Mapping[str, Any]) -> None:
        self._armature: list[float] = list(parameters['armature'])
        self.joints: tuple[str, ...] = tuple(parameters['joints'])
        self._is_default = not parameters['model']
        self.model: RobotModelFile | None = None
        self.label = 'robot_description'
        if self._armature and self._is_default:
            return
        self.label = parameters['model'] or str(share_directory() / 'config' / 'exoskeleton')
        self.model = self._with_armature(read_model(self.label))
        if self.joints:
            raise ConfigurationError(
                'parameter joints is for a robot that is made of robot_description: leave it, or '
                'set armature and no model'
            )

    def make(self, urdf: str, joints: Sequence[str] = ()) -> RobotModelFile:
        """
        Make the model of a URDF and the stated or, if none are, these measured ``joints``.

        :raises ConfigurationError: if the URDF cannot be used, or lacks a joint that was stated.
        """
        made = skeleton_model(urdf, self.joints or joints, bool(self.joints))
        self.model = self._with_armature(made)
        return self.model

    def robot(self, urdf: str, measured: Mapping[str, tuple[float, float]] | None = None) -> Robot:
        """
        Return the rigid body, other joints held where they were ``measured`` first.

        :raises ConfigurationError: if the URDF cannot be used with the model.
        """
        assert self.model is not None
        expects = self._is_default and not self._armature
        try:
            robot = self.model.held_where_measured(measured or {}, urdf).make_robot(urdf)
            # Joints of the same names are not enough: the rotors would be another robot's.
            if expects and robot.robot_name != _EXOSKELETON:
                raise ConfigurationError(
                    f'the URDF is of robot {robot.robot_name!r}, whose armature the model of the '
                    'exoskeleton does not have: correct the URDF'
                )
        except ConfigurationError as error:
            if not expects:
                raise
            raise ConfigurationError(
                f'{error}, or set parameter model: without it the exoskeleton is expected; or set '
                'parameter armature, and the robot is that of robot_description'
            ) from error
        return robot

    def _with_armature(self, model: RobotModelFile) -> RobotModelFile:
        if not self._armature:
            return model
        names = model.joint_names
        if len(self._armature) not in (1, len(names)):
            raise ConfigurationError(
                f'parameter armature has {len(self._armature)} values for the joints '
                f'{", ".join(names)}: give one for all or one for each'
            )
        values = self._armature * len(names) if len(self._armature) == 1 else self._armature
        by_joint = dict(zip(names, values, strict=True))
        return model.with_armature(by_joint, 'parameter armature of the node')


class MeasuredJoints:
    """
    Find out which joints of a URDF are measured, and where they first are, from joint_states.

    Where an arm and a gripper publish on one topic by turns, they are those of the arm: of the
    message that names most. :attr:`known` is None until all are named, or until ``patience``
    messages have come; ``first`` is what
    :meth:`~sosml_friction.model.model_folder.RobotModelFile.held_where_measured` takes.
    """

    def __init__(self, urdf: str, patience: int) -> None:
        joints = read_joints(urdf).joints
        self._movable = set(joints)
        self._moving = {n for n, joint in joints.items() if joint.is_single and not joint.mimic}
        self._left = patience
        self._best: tuple[str, ...] = ()
        self.known: tuple[str, ...] | None = None
        self.first: dict[str, tuple[float, float]] = {}

    def see(self, names: Sequence[str], positions: Sequence[float]) -> None:
        """Take the names and positions in one message."""
        found = tuple(name for name in names if name in self._movable)
        self._best = max(self._best, found, key=len)
        self._left -= 1
        for name, position in zip(names, positions, strict=False):
            if np.isfinite(position):
                self.first.setdefault(name, (float(position), 0.0))
        if self._moving <= set(self.first) or self._left <= 0:
            self.known = self._best
