# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The joints that a URDF states, and the part of it that moves."""

import copy
import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

from sosml_friction.exceptions import ConfigurationError

#: Types of one degree of freedom: the only ones that a model can name.
_SINGLE = ('revolute', 'continuous', 'prismatic')
#: Stands for "no limit" in what the parser reads, which knows no infinity; nobody reads it back.
_UNLIMITED = '1e300'


@dataclass(frozen=True)
class JointLimits:
    """
    Limits the URDF states: position [rad or m], velocity [rad/s or m/s], effort [Nm or N].

    ``lower`` and ``upper`` are infinite where the position has no limit, ``velocity`` and
    ``effort`` are NaN where none is stated.
    """

    lower: float
    upper: float
    velocity: float
    effort: float


@dataclass(frozen=True)
class Mimic:
    """Say that a joint is at ``multiplier`` times the position of ``leader`` plus ``offset``."""

    leader: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class UrdfJoint:
    """Hold one joint of a URDF as it is stated; ``mimic`` is None where it moves by itself."""

    name: str
    kind: str
    child: str
    limits: JointLimits
    mimic: Mimic | None

    @property
    def is_single(self) -> bool:
        """Tell whether it has one degree of freedom."""
        return self.kind in _SINGLE


@dataclass(frozen=True)
class UrdfJoints:
    """
    Hold what of a URDF moves.

    ``joints``: by name, in the order of the document, without the fixed ones. ``plain``: the
    document with bodies and joints alone, every joint with a limit and without mimic, for a
    parser that wants them so; what it is drawn with, transmissions and plugins are left out.
    ``unweighed``: links that joints move and that have no inertial.
    """

    robot_name: str
    joints: dict[str, UrdfJoint]
    plain: str
    unweighed: tuple[str, ...]


def read_joints(urdf: str) -> UrdfJoints:
    """
    Read the joints of a URDF document.

    :raises ConfigurationError: if it is no URDF, in one sentence.
    """
    try:
        root = ElementTree.fromstring(urdf.strip())
    except (ElementTree.ParseError, ValueError) as error:
        raise ConfigurationError(
            f'the URDF cannot be read: {" ".join(str(error).split())}'
        ) from error
    if root.tag != 'robot':
        raise ConfigurationError(
            f'the URDF cannot be read: its root is <{root.tag}> where <robot> is needed'
        )
    if any('xacro' in str(element.tag) for element in root.iter()):
        raise ConfigurationError(
            'the URDF cannot be read: it is xacro still; run xacro over it and use what it prints'
        )
    plain = ElementTree.Element('robot', {'name': root.get('name') or 'robot'})
    for link in root.findall('link'):
        body = ElementTree.SubElement(plain, 'link', {'name': link.get('name', '')})
        body.extend(copy.deepcopy(link.findall('inertial')))
    joints = {}
    # Those of a transmission or a plugin stand deeper, and are other elements of the same name.
    for element in root.findall('joint'):
        joint = _joint(element)
        if joint.name in joints:
            raise ConfigurationError(f'the URDF cannot be read: it has joint {joint.name} twice')
        if joint.kind != 'fixed':
            joints[joint.name] = joint
        plain.append(_plain_joint(element, joint))
    _check_mimics(joints)
    weighed = {
        link.get('name') for link in root.findall('link') if link.find('inertial') is not None
    }
    unweighed = tuple(j.child for j in joints.values() if j.child not in weighed)
    text = ElementTree.tostring(plain, encoding='unicode')
    return UrdfJoints(root.get('name', ''), joints, text, unweighed)


def _joint(element: ElementTree.Element) -> UrdfJoint:
    name, kind = element.get('name', ''), element.get('type', '')
    child = element.find('child')
    limit = element.find('limit')
    stated: dict[str, float] = {}
    for key in ('lower', 'upper', 'velocity', 'effort'):
        text = None if limit is None else limit.get(key)
        if text is not None:
            stated[key] = _number(text, f'the {key} limit of joint {name}')
    # One side alone leaves the other at 0, as the format says; none at all limits nothing.
    free = kind == 'continuous' or not stated.keys() & {'lower', 'upper'}
    limits = JointLimits(
        -math.inf if free else stated.get('lower', 0.0),
        math.inf if free else stated.get('upper', 0.0),
        stated.get('velocity', math.nan),
        stated.get('effort', math.nan),
    )
    entry = element.find('mimic')
    mimic = None
    if entry is not None:
        mimic = Mimic(
            entry.get('joint', ''),
            _number(entry.get('multiplier', '1'), f'the multiplier of the mimic joint {name}'),
            _number(entry.get('offset', '0'), f'the offset of the mimic joint {name}'),
        )
    return UrdfJoint(name, kind, '' if child is None else child.get('link', ''), limits, mimic)


def _number(text: str, what: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise ConfigurationError(
            f'the URDF cannot be read: {what} is {text!r}, no number'
        ) from error


def _plain_joint(element: ElementTree.Element, joint: UrdfJoint) -> ElementTree.Element:
    # A continuous joint turned as a revolute one has an angle for its position, of any size.
    kind = 'revolute' if joint.kind == 'continuous' else joint.kind
    plain = ElementTree.Element('joint', {'name': joint.name, 'type': kind})
    for tag in ('parent', 'child', 'origin', 'axis'):
        plain.extend(copy.deepcopy(element.findall(tag)))
    if joint.is_single:
        low, high = f'-{_UNLIMITED}', _UNLIMITED
        limit = {'lower': low, 'upper': high, 'velocity': high, 'effort': high}
        ElementTree.SubElement(plain, 'limit', limit)
    return plain


def _check_mimics(joints: dict[str, UrdfJoint]) -> None:
    for joint in joints.values():
        seen, at = {joint.name}, joint
        while at.mimic is not None:
            leader = at.mimic.leader
            if leader not in joints or leader in seen:
                raise ConfigurationError(
                    f'the URDF cannot be read: joint {at.name} mimics {leader!r}, which '
                    f'{"mimics it" if leader in seen else "is no joint that moves"}'
                )
            seen.add(leader)
            at = joints[leader]
