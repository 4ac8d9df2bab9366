# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Models that need no file by hand: a pendulum, an axis, a shaft, and the skeleton of any URDF.

What nobody stated is unknown in them: its value is absent and its reason is there
(:class:`~sosml_friction.model.parameter.Parameter`), in ``model.yaml`` as well.
"""

import math
from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import JointModel, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.urdf_joints import UrdfJoint, read_joints

#: Why the armature of a joint is absent, and what to do about it.
UNKNOWN_ARMATURE = (
    'not stated: give the inertia of the rotor times the square of the gear ratio, or 0 if the '
    'bodies of the URDF have it'
)
#: Turns about y: gravity, along -z, turns what hangs below back to 0 from either side.
_PENDULUM_AXIS, _SLIDE_AXIS, _SHAFT_AXIS = '0 1 0', '1 0 0', '0 0 1'


def pendulum_model(
    mass: float,
    length: float,
    inertia: float | None = None,
    armature: float | None = None,
    joint: str = 'joint',
) -> RobotModelFile:
    """
    Return a body that hangs below a level axis: (I + m l^2 + armature) q'' + m g l sin(q).

    It hangs straight down at q = 0. Turning either way needs an effort of the sign of sin(q), so
    the sign of q and effort may be any as long as both have the same.

    :param mass: m [kg].
    :param length: l, from the axis to the centre of mass [m].
    :param inertia: I, about the centre of mass and parallel to the axis [kg m2]; None: all mass
        is in one point.
    :param armature: inertia of the rotor at the joint, J N^2 [kg m2]; None: not known.
    :raises ConfigurationError: if a number cannot be.
    """
    _require_positive(mass, 'mass', 'kg')
    _require_positive(length, 'length', 'm')
    _require_not_negative(inertia or 0.0, 'inertia', 'kg m2')
    assumed = ['gravity is 9.81 m/s2 and the axis is level', 'position 0 is straight down']
    if inertia is None:
        assumed.append('all mass is in one point: no inertia about the centre of mass was stated')
    urdf = _one_joint(
        'pendulum',
        joint,
        ('continuous', _PENDULUM_AXIS),
        mass,
        f'0 0 {-float(length)!r}',
        float(inertia or 0.0),
    )
    return _simple('pendulum', joint, urdf, _armature(armature, 'kg m2'), assumed)


def axis_model(mass: float, joint: str = 'joint') -> RobotModelFile:
    """
    Return a mass on a level slide: m q''.

    :param mass: m, all that moves, the motor's inertia seen at the slide included [kg].
    :raises ConfigurationError: if it cannot be.
    """
    _require_positive(mass, 'mass', 'kg')
    urdf = _one_joint('axis', joint, ('prismatic', _SLIDE_AXIS), mass, '0 0 0', 0.0)
    rotor = Parameter(0.0, 'kg', reason='it is in the mass that was stated')
    return _simple(
        'axis',
        joint,
        urdf,
        rotor,
        ['the axis is level: gravity does no work along it', "the motor's inertia is in the mass"],
    )


def free_model(inertia: float, joint: str = 'joint') -> RobotModelFile:
    """
    Return a shaft that gravity does not turn: I q''.

    :param inertia: I, all that turns, the rotor's at the shaft included [kg m2].
    :raises ConfigurationError: if it cannot be.
    """
    _require_positive(inertia, 'inertia', 'kg m2')
    # A body needs a mass; on the axis, and with gravity along it, nothing feels which.
    urdf = _one_joint('shaft', joint, ('continuous', _SHAFT_AXIS), 1.0, '0 0 0', inertia)
    rotor = Parameter(0.0, 'kg m2', reason='it is in the inertia that was stated')
    assumed = ['gravity does not turn the shaft', "the rotor's inertia, at the joint, is in it"]
    return _simple('shaft', joint, urdf, rotor, assumed)


def skeleton_model(
    urdf_text: str, joints: Sequence[str] | None = None, require_all: bool = False
) -> RobotModelFile:
    """
    Return a model of a URDF in which all that the URDF does not state is marked as not known.

    It has every joint that moves by itself: revolute, continuous or prismatic, no mimic.
    ``provenance`` has ``not_known``, by joint, what is missing and what for.

    :param joints: these alone, as many as there are; the others are held still. One that mimics
        another follows it even if it is named here.
    :param require_all: whether each of ``joints`` must be there.
    :raises ConfigurationError: if the URDF cannot be read or no joint is left.
    """
    stated = read_joints(urdf_text)
    absent = [name for name in joints or () if name not in stated.joints]
    if require_all and absent:
        raise ConfigurationError(
            f'the URDF has no joint {", ".join(absent)} that moves: use some of '
            f'{", ".join(stated.joints)}'
        )
    chosen = {
        name: joint
        for name, joint in stated.joints.items()
        if joint.is_single and joint.mimic is None and (joints is None or name in joints)
    }
    if not chosen:
        among = '' if joints is None else f' among {", ".join(joints)}'
        raise ConfigurationError(
            f'the URDF has no joint of type revolute, continuous or prismatic{among}: give the '
            'URDF of a robot that moves'
        )
    entries = {
        name: JointModel(_armature(None, 'kg' if joint.kind == 'prismatic' else 'kg m2'))
        for name, joint in chosen.items()
    }
    missing = {
        name: _missing(joint, joint.child in stated.unweighed) for name, joint in chosen.items()
    }
    name = stated.robot_name or 'robot'
    return RobotModelFile(name, entries, urdf_text, {'not_known': missing})


def _missing(joint: UrdfJoint, is_unweighed: bool) -> dict[str, str]:
    found = {'friction': 'sosml fit finds it from a recording'}
    if joint.dynamics:
        said = ', '.join(f'{key} {value}' for key, value in joint.dynamics.items())
        found['friction'] += (
            f'; <dynamics> of the URDF, {said}, is what a simulator takes for it: to have it put '
            'to the test, state it in model.yaml, as coulomb and viscous of the joint'
        )
    if is_unweighed:
        found['inertial'] = (
            f'link {joint.child} has no mass in the URDF: right only if it is next to nothing'
        )
    for what in ('effort', 'velocity'):
        if not getattr(joint.limits, what) > 0.0:
            found[f'{what} limit'] = (
                'not in the URDF: a driver and a trajectory need it, a fit does not'
            )
    if math.isinf(joint.limits.upper) and joint.kind != 'continuous':
        found['position limits'] = (
            'not in the URDF: a driver and a trajectory need them, a fit does not'
        )
    return found


def _armature(value: float | None, unit: str) -> Parameter:
    if value is None:
        return Parameter(math.nan, unit, reason=UNKNOWN_ARMATURE)
    _require_not_negative(value, 'armature', unit)
    return Parameter(float(value), unit)


def _simple(
    name: str, joint: str, urdf: str, armature: Parameter, assumed: Sequence[str]
) -> RobotModelFile:
    return RobotModelFile(name, {joint: JointModel(armature)}, urdf, {'assumed': list(assumed)})


def _one_joint(
    name: str, joint: str, motion: tuple[str, str], mass: float, centre: str, inertia: float
) -> str:
    """Return the URDF of one body on one joint, without limits: nobody stated any."""
    if not joint.strip():
        raise ConfigurationError('the joint has no name: give it one')
    kind, axis = motion
    # The same about all axes: only that of the joint is felt.
    m, own = repr(float(mass)), repr(float(inertia))
    inertial = (
        f'\n    <inertial>\n      <origin xyz="{centre}"/>\n      <mass value="{m}"/>\n'
        f'      <inertia ixx="{own}" ixy="0" ixz="0" iyy="{own}" iyz="0" izz="{own}"/>\n'
        '    </inertial>\n  '
    )
    return (
        f'<?xml version="1.0"?>\n<robot name="{name}">\n  <link name="base"/>\n'
        f'  <link name="body">{inertial}</link>\n'
        f'  <joint name={quoteattr(joint)} type="{kind}">\n    <parent link="base"/>\n'
        f'    <child link="body"/>\n    <axis xyz="{axis}"/>\n  </joint>\n</robot>\n'
    )


def _require_positive(value: float, what: str, unit: str) -> None:
    if not 0.0 < value < math.inf:
        raise ConfigurationError(f'the {what} is {value:g} {unit}: give a positive number')


def _require_not_negative(value: float, what: str, unit: str) -> None:
    if not 0.0 <= value < math.inf:
        raise ConfigurationError(
            f'the {what} is {value:g} {unit}: give a number that is not negative'
        )
