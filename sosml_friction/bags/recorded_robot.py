# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The robot in a bag: its motion, and the model that it was recorded with."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import RobotModelFile, parse_model, read_model
from sosml_friction.model.robot import Robot
from sosml_friction.model.simple_models import skeleton_model
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.text_file import read_text

#: A model: its folder, or what it holds; None: that of the bag.
ModelSource = str | Path | RobotModelFile | None


@dataclass(frozen=True)
class RecordedRobot:
    """Hold the motion in a bag and the robot that made it, joints in the order of the model."""

    bag: Bag
    log: JointLog
    nominal: RobotModelFile

    @property
    def robot(self) -> Robot:
        """Return the rigid body; a ConfigurationError where an armature is not known."""
        return self.nominal.make_robot()


def read_recorded_robot(
    path: str | Path,
    model: ModelSource = None,
    urdf: str | Path | None = None,
    namespace: str | None = None,
    own_urdf: bool = False,
) -> RecordedRobot:
    """
    Read the motion in a bag and the robot that made it; joints in the model's order.

    The URDF's other joints are held still, at 0 or where they were recorded first; and so are
    joints that are not recorded and that the model has for no other reason than that the URDF
    has them.

    :param model: model, or its folder, with the armature of the joints; None for the bag's.
    :param urdf: URDF file, None for the bag's, or where it has none the model's.
    :param namespace: which robot, where a bag holds several.
    :param own_urdf: whether the URDF of the folder ``model`` comes before the bag's: where the
        model is what is put to the test.
    :raises BagError: if the bag cannot be read or has no joint_states.
    :raises ConfigurationError: if no model or URDF is known, or joints disagree.
    :raises DataError: if no joint has effort.
    """
    bag = Bag.open(path, namespace)
    log = bag.joint_log()
    nominal = read_nominal(bag, path, model, urdf, own_urdf)
    nominal = as_recorded(nominal, log)
    log = log.select(nominal.with_armature({'*': 0.0}).make_robot().names)
    log.require_effort()
    return RecordedRobot(bag, log, nominal)


def as_recorded(model: RobotModelFile, log: JointLog) -> RobotModelFile:
    """
    Return the model of the robot in a recording: with the other joints held where they were first.

    Without joints that are not recorded and that it has only because the URDF has them.
    """
    return model.of_measured(log.names).held_where_measured(log.first_positions())


def read_nominal(
    bag: Bag, path: str | Path, model: ModelSource, urdf: str | Path | None, own_urdf: bool = False
) -> RobotModelFile:
    """
    Return the robot in a bag, with its URDF; parameters as for :func:`read_recorded_robot`.

    The URDF of a model whose rigid body was identified comes before the bag's. A bag without a
    model has that of its URDF, with the joints that its joint_states name and no armature.

    :raises ConfigurationError: if no model or URDF is known.
    """
    nominal = _model_of(bag, path, model, urdf)
    own = nominal.urdf if own_urdf or nominal.is_rigid_body_identified else None
    if own is None or urdf is not None:
        document = _urdf_of(bag, urdf) or nominal.urdf
    else:
        document = own
    if document is None:
        raise ConfigurationError(f'bag {path} has no robot_description: give a URDF with --urdf')
    return replace(nominal, urdf=document)


def stated_armature(
    bag: Bag,
    path: str | Path,
    model: ModelSource,
    urdf: str | Path | None,
    armature: Mapping[str, float],
) -> RobotModelFile:
    """
    Return the robot in a bag with the armatures [kg m2 or kg] that its model does not know.

    They are given by joint; '*' is for all others.

    :raises BagError: if the bag has no joint_states.
    :raises ConfigurationError: if no URDF is known, it has none of these joints, or an armature
        cannot be.
    """
    nominal = read_nominal(bag, path, model, urdf, own_urdf=model is not None)
    return nominal.with_armature(armature, 'stated with the recording')


def _model_of(
    bag: Bag, path: str | Path, model: ModelSource, urdf: str | Path | None
) -> RobotModelFile:
    if isinstance(model, RobotModelFile):
        return model
    if model is not None:
        return read_model(model)
    text = bag.text('model_description')
    if text is not None:
        return parse_model(text, f'model_description of {path}')
    document = _urdf_of(bag, urdf)
    if document is None:
        raise ConfigurationError(f'bag {path} has no robot_description: give a URDF with --urdf')
    return skeleton_model(
        document, bag.joint_log().reported_together(read_joints(document).joints)
    )


def _urdf_of(bag: Bag, urdf: str | Path | None) -> str | None:
    return bag.text('robot_description') if urdf is None else read_text(urdf, 'URDF')
