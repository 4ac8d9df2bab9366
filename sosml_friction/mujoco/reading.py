# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
An MJCF as a model of this package: MuJoCo compiles it, and what it compiled is read.

Each body becomes a link and each named hinge or slide a joint of a URDF with the same masses,
frames and axes, so that all that works with a URDF works with it. A joint's position is that of
``qpos``: where MJCF has a ``ref``, it is in the joint's frame. Rotors, friction, damping and
springs of joints become armature and terms.
"""

import warnings
from collections.abc import Iterator
from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import (
    EffectTerm,
    FrictionParameters,
    JointModel,
    RobotModelFile,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.urdf_bodies import inertial_element
from sosml_friction.mujoco.engine import compiled, engine, joint_id
from sosml_friction.xml_text import number_list

#: The gravity that a URDF is under [m/s2], and the share by which one of an MJCF may differ: some
#: write 9.8 or 9.80665.
_GRAVITY, _NEARLY = 9.81, 2e-3
#: Why joints of an MJCF that were not recorded are held.
_ALL_OF_IT = 'a joint of the MJCF'


class Frame(NamedTuple):
    """Hold where a frame is in another: ``at`` (3,) [m] and ``turn`` (3, 3)."""

    at: FloatArray
    turn: FloatArray

    def then(self, at: FloatArray, turn: FloatArray) -> 'Frame':
        """Return the frame that is at ``at`` and turned by ``turn`` in this one."""
        return Frame(self.at + self.turn @ at, self.turn @ turn)


def read_mjcf(path: str | Path, free_rotors: bool = False) -> RobotModelFile:
    """
    Read an MJCF file; all its named hinges and slides are joints.

    Friction of nothing at all, MJCF's default, is friction that is not known. Joints that are
    not recorded, free and ball joints and those without a name are held where the MJCF has them.

    :param free_rotors: whether an armature of 0, MJCF's default, is one that is not known.
    :raises ConfigurationError: if it cannot be read or compiled, no joint has a name, a name is
        taken twice by a link, gravity is not that of the earth, or it has what has no place in a
        model: gravity compensation, springs or damping that are no line.
    """
    model = model_of(compiled(Path(path)), Path(path).stem)
    if not free_rotors:
        return model
    joints = {
        name: replace(joint, armature=replace(joint.armature, value=nan))
        if joint.armature.value == 0.0
        else joint
        for name, joint in model.joints.items()
    }
    return replace(model, joints=joints)


def model_of(m: Any, name: str) -> RobotModelFile:
    """Return the model of an MjModel; errors as of :func:`read_mjcf`."""
    _refuse(m)
    robot = ElementTree.Element('robot', {'name': name})
    ElementTree.SubElement(robot, 'link', {'name': 'world'})
    frames = {0: ('world', upright(m))}
    remarks = []
    for body in range(1, m.nbody):
        parent, frame = frames[int(m.body_parentid[body])]
        # Its link: "world" alone is taken by the root.
        label = f'body {m.body(body).name or body}'
        frame = frame.then(m.body_pos[body], matrix(m.body_quat[body]))
        own = list(_joints(m, body))
        if len(own) < int(m.body_jntnum[body]):
            remarks.append(
                f'{label} has a joint that is free, a ball or without a '
                'name: it is held where the MJCF has it'
            )
        for k, (j, joint) in enumerate(own):
            child = label if k == len(own) - 1 else f'{label} {joint}'
            turn = np.eye(3)
            shift = m.jnt_pos[j]
            if _turns(m, j):
                turn = Rotation.from_rotvec(-m.qpos0[m.jnt_qposadr[j]] * m.jnt_axis[j]).as_matrix()
            else:
                shift = shift - m.qpos0[m.jnt_qposadr[j]] * m.jnt_axis[j]
            link = _joint(robot, m, j, parent, child, frame.then(shift, turn))
            # The link's frame is the body's but for the joint's place in it.
            parent, frame = child, Frame(-m.jnt_pos[j], np.eye(3))
        if not own:
            _, link = _link(robot, f'{label} fixed', 'fixed', parent, label, frame)
            parent, frame = label, Frame(np.zeros(3), np.eye(3))
        _inertial(link, m, body, frame)
        frames[body] = (parent, frame)
    joints = {joint: _joint_model(m, j) for b in range(1, m.nbody) for j, joint in _joints(m, b)}
    if not joints:
        raise ConfigurationError('the MJCF has no hinge or slide with a name: give joints names')
    return RobotModelFile(
        name,
        joints,
        ElementTree.tostring(robot, encoding='unicode'),
        # These bodies come before those of a robot_description beside the recording.
        provenance={
            'not_known': dict.fromkeys(joints, _ALL_OF_IT),
            'rigid_body': {'written': ['mjcf'], 'refused': {}},
        },
        effects=tuple(_springs(m, joints)),
        remarks=tuple(remarks + _couplings(m)),
    )


def _refuse(m: Any) -> None:
    size = float(np.linalg.norm(m.opt.gravity))
    if abs(size - _GRAVITY) > _NEARLY * _GRAVITY:
        raise ConfigurationError(
            f'gravity of the MJCF is {size:g} m/s2: a model is under {_GRAVITY} m/s2; set '
            'option gravity to that'
        )
    for body in range(1, m.nbody):
        if m.body_gravcomp[body] != 0.0:
            raise ConfigurationError(
                f'body {m.body(body).name or body} of the MJCF has gravcomp, an effort that no '
                'actuator spends: take it out of the copy that is put to the test'
            )
    for name in ('dof_dampingpoly', 'jnt_stiffnesspoly'):
        if np.any(getattr(m, name, 0.0)):
            raise ConfigurationError(
                f'the MJCF has a polynomial in {name}, which no term of a model is: leave it its '
                'first number'
            )


def upright(m: Any) -> Frame:
    """Return the world's frame, turned so that gravity is along -z."""
    down = np.asarray(m.opt.gravity) / np.linalg.norm(m.opt.gravity)
    turn, _ = Rotation.align_vectors([[0.0, 0.0, -1.0]], [down])
    straight = abs(down[2] + 1.0) < 1e-15
    return Frame(np.zeros(3), np.eye(3) if straight else turn.as_matrix())


def _joints(m: Any, body: int) -> Iterator[tuple[int, str]]:
    """Yield number and name of the hinges and slides of a body."""
    slide = int(engine().mjtJoint.mjJNT_SLIDE)
    for j in range(int(m.body_jntadr[body]), int(m.body_jntadr[body] + m.body_jntnum[body])):
        name = m.joint(j).name
        if name and (_turns(m, j) or int(m.jnt_type[j]) == slide):
            yield j, name


def _turns(m: Any, j: int) -> bool:
    return int(m.jnt_type[j]) == int(engine().mjtJoint.mjJNT_HINGE)


def matrix(quaternion: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) of a quaternion as MuJoCo has it, w first."""
    w, x, y, z = quaternion
    return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())


def _link(
    robot: ElementTree.Element, name: str, kind: str, parent: str, child: str, frame: Frame
) -> tuple[ElementTree.Element, ElementTree.Element]:
    """Add a joint of that name and kind and the link at its end, and return both."""
    joint = ElementTree.SubElement(robot, 'joint', {'name': name, 'type': kind})
    ElementTree.SubElement(joint, 'parent', {'link': parent})
    ElementTree.SubElement(joint, 'child', {'link': child})
    with warnings.catch_warnings():
        # Where two angles turn about one axis, any pair of the right sum is right.
        warnings.simplefilter('ignore', UserWarning)
        angles = Rotation.from_matrix(frame.turn).as_euler('xyz')
    place = {'xyz': number_list(frame.at), 'rpy': number_list(angles)}
    ElementTree.SubElement(joint, 'origin', place)
    return joint, ElementTree.SubElement(robot, 'link', {'name': child})


def _joint(
    robot: ElementTree.Element, m: Any, j: int, parent: str, child: str, frame: Frame
) -> ElementTree.Element:
    """Add a hinge or slide and its link, and return the link."""
    turns = _turns(m, j)
    limited = bool(m.jnt_limited[j])
    kind = 'revolute' if limited and turns else 'continuous' if turns else 'prismatic'
    joint, link = _link(robot, m.joint(j).name, kind, parent, child, frame)
    ElementTree.SubElement(joint, 'axis', {'xyz': number_list(m.jnt_axis[j])})
    if limited:
        low, high = m.jnt_range[j]
        ElementTree.SubElement(
            joint, 'limit', {'lower': repr(float(low)), 'upper': repr(float(high))}
        )
    follow = _leader(m, j)
    if follow is not None:
        leader, offset, multiplier = follow
        line = {'joint': leader, 'multiplier': repr(multiplier), 'offset': repr(offset)}
        ElementTree.SubElement(joint, 'mimic', line)
    return link


def _equalities(m: Any) -> Iterator[int]:
    for k in range(m.neq):
        if int(m.eq_type[k]) == int(engine().mjtEq.mjEQ_JOINT) and m.eq_active0[k]:
            yield k


def _leader(m: Any, j: int) -> tuple[str, float, float] | None:
    """Return which joint a joint follows by a line, the offset and the multiplier."""
    for k in _equalities(m):
        leader = int(m.eq_obj2id[k])
        if m.eq_obj1id[k] == j and leader >= 0 and not np.any(m.eq_data[k, 2:5]):
            start, slope = map(float, m.eq_data[k, :2])
            own, other = (float(m.qpos0[m.jnt_qposadr[x]]) for x in (j, leader))
            return str(m.joint(leader).name), own + start - slope * other, slope
    return None


def _couplings(m: Any) -> list[str]:
    """Return a sentence where the MJCF ties the robot together in a way that no model has."""
    lines = sum(_leader(m, int(m.eq_obj1id[k])) is not None for k in _equalities(m))
    if int(m.neq) == lines and not m.ntendon:
        return []
    return [
        'equality constraints and tendons of the MJCF are not in the model, but for joints '
        'that follow another by a line: what they carry is part of what is not explained'
    ]


def _inertial(link: ElementTree.Element, m: Any, body: int, frame: Frame) -> None:
    mass = float(m.body_mass[body])
    if not mass > 0.0:
        return
    own = frame.then(m.body_ipos[body], matrix(m.body_iquat[body]))
    tensor = own.turn @ np.diag(m.body_inertia[body]) @ own.turn.T
    link.append(inertial_element(mass, own.at, tensor))


def _units(m: Any, j: int) -> tuple[str, str, str]:
    turns = _turns(m, j)
    return ('Nm', 'rad', 'kg m2') if turns else ('N', 'm', 'kg')


def _joint_model(m: Any, j: int) -> JointModel:
    effort, length, inertia = _units(m, j)
    dof = int(m.jnt_dofadr[j])
    armature = Parameter(float(m.dof_armature[dof]), inertia)
    level, slope = float(m.dof_frictionloss[dof]), float(m.dof_damping[dof])
    friction = None
    if level or slope:
        parameters = {
            'coulomb': Parameter(level, effort),
            'viscous': Parameter(slope, f'{effort} s/{length}'),
            'bias': Parameter(0.0, effort),
        }
        friction = FrictionParameters('coulomb_viscous', 0.0, parameters)
    return JointModel(armature, friction)


def _springs(m: Any, joints: dict[str, JointModel]) -> Iterator[EffectTerm]:
    for name in joints:
        j = joint_id(m, name)
        stiffness = float(m.jnt_stiffness[j])
        if stiffness:
            effort, length, _ = _units(m, j)
            rest = float(m.qpos_spring[m.jnt_qposadr[j]])
            parameters = {
                'stiffness': Parameter(stiffness, f'{effort}/{length}'),
                'offset': Parameter(-stiffness * rest, effort),
            }
            yield EffectTerm('spring', name, parameters)
