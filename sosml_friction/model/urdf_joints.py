# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The joints and bodies that a URDF states: what every reader of one goes by."""

import math
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.plain_number import plain_number

#: Types of one degree of freedom: the only ones that a model can name.
_SINGLE = ('revolute', 'continuous', 'prismatic')
_KINDS = (*_SINGLE, 'fixed', 'floating', 'planar')
_MOMENTS = ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')
#: A moment of inertia below 0 by this share of the largest is one that was rounded: CAD programs
#: write three digits and more.
_ROUNDED = 1e-3
#: Beside a larger number of a body [SI] a double has no room for those of a robot's.
_LARGEST = 1e9
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
    """
    Hold one joint of a URDF as it is stated; ``mimic`` is None where it moves by itself.

    ``dynamics``: the attributes of that element that are not 0, as they are written: a
    simulator's friction.
    """

    name: str
    kind: str
    child: str
    limits: JointLimits
    mimic: Mimic | None
    dynamics: Mapping[str, str] = field(default_factory=dict)

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
        raise _refused(' '.join(str(error).split())) from error
    if root.tag != 'robot':
        raise _refused(f'its root is <{root.tag}> where <robot> is needed')
    if any('xacro' in str(element.tag) for element in root.iter()):
        raise _refused('it is xacro still; run xacro over it and use what it prints')
    plain = ElementTree.Element('robot', {'name': root.get('name') or 'robot'})
    links = dict.fromkeys(_names(root, 'link'))
    # Those of a transmission or a plugin stand deeper, and are other elements of the same name.
    elements = root.findall('joint')
    names = _names(root, 'joint')
    stated = [_joint(*pair) for pair in zip(elements, names, strict=True)]
    joints = {joint.name: joint for joint in stated if joint.kind != 'fixed'}
    moved = {joint.child for joint in joints.values()}
    weighed = set()
    for link, name in zip(root.findall('link'), links, strict=True):
        body = _plain_link(link, name, name in moved)
        plain.append(body)
        if len(body):
            weighed.add(name)
    for element, joint in zip(elements, stated, strict=True):
        plain.append(_plain_joint(element, joint, links))
    _check_tree(plain, links)
    _check_mimics(joints)
    unweighed = tuple(j.child for j in joints.values() if j.child not in weighed)
    text = ElementTree.tostring(plain, encoding='unicode')
    return UrdfJoints(root.get('name', ''), joints, text, unweighed)


def _refused(what: str) -> ConfigurationError:
    return ConfigurationError(f'the URDF cannot be read: {what}')


def _names(root: ElementTree.Element, tag: str) -> list[str]:
    """Return the names of the links or joints, each of which has its own."""
    names = [element.get('name', '') for element in root.findall(tag)]
    for name, times in Counter(names).items():
        if not name.strip():
            raise _refused(f'a {tag} has no name')
        if times > 1:
            raise _refused(f'it has {tag} {name} twice')
    return names


def _plain_link(link: ElementTree.Element, name: str, moves: bool) -> ElementTree.Element:
    """
    Return a link with the numbers of its body alone, which are those of a body.

    :param moves: whether a joint moves it. One that is fixed to another may be a frame: without
        mass it has no body, whatever else is stated of it, and one without moments is a point.
    """
    plain = ElementTree.Element('link', {'name': name})
    found = link.findall('inertial')
    if not found:
        return plain
    if len(found) > 1:
        raise _refused(f'link {name} has {len(found)} inertials: leave it one')
    inertial = found[0]
    mass, inertia = inertial.find('mass'), inertial.find('inertia')
    if not moves and mass is None and inertia is None:
        return plain
    if mass is None or (moves and inertia is None):
        raise _refused(
            f'the inertial of link {name} has no {"mass" if mass is None else "inertia"}: give '
            'it one, or leave the inertial out of a link that has no mass'
        )
    m = _number(mass.get('value'), f'the mass of link {name}')
    if m == 0.0 and not moves:
        return plain
    moments = [0.0] * len(_MOMENTS) if inertia is None else _moments(inertia, name)
    if m == 0.0 and not any(moments):
        return plain
    if not m > 0.0:
        raise _refused(
            f'the mass of link {name} is {m:g} kg: give a mass above 0, or leave the inertial out'
        )
    _check_moments(moments, name)
    body = ElementTree.SubElement(plain, 'inertial')
    body.append(_plain_origin(inertial, f'the inertial of link {name}'))
    ElementTree.SubElement(body, 'mass', {'value': repr(m)})
    numbers = {key: repr(x) for key, x in zip(_MOMENTS, moments, strict=True)}
    ElementTree.SubElement(body, 'inertia', numbers)
    return plain


def _moments(inertia: ElementTree.Element, name: str) -> list[float]:
    """Return the moments of inertia in the order of their names; a missing product is 0."""
    missing = {key: '0' for key in ('ixy', 'ixz', 'iyz')}
    return [
        _number(inertia.get(key, missing.get(key)), f'{key} of link {name}') for key in _MOMENTS
    ]


def _check_moments(moments: Sequence[float], name: str) -> None:
    xx, xy, xz, yy, yz, zz = moments
    size = max(map(abs, moments))
    if size == 0.0:
        return
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / size
    least = float(np.linalg.eigvalsh(tensor)[0])
    if min(xx, yy, zz) < 0.0 or not least >= -_ROUNDED:
        values = ', '.join(f'{key} {x:g}' for key, x in zip(_MOMENTS, moments, strict=True))
        raise _refused(
            f'link {name} has a negative moment of inertia ({values}; least {least * size:.3g} '
            'kg m2): no body has that, correct it'
        )


def _plain_origin(element: ElementTree.Element, where: str) -> ElementTree.Element:
    origin = element.find('origin')
    stated = {} if origin is None else origin.attrib
    numbers = {
        key: _vector(stated.get(key, '').strip() or '0 0 0', f'{key} in the origin of {where}')
        for key in ('xyz', 'rpy')
    }
    return ElementTree.Element(
        'origin', {key: ' '.join(map(repr, vector.tolist())) for key, vector in numbers.items()}
    )


def _joint(element: ElementTree.Element, name: str) -> UrdfJoint:
    kind = element.get('type', '')
    if kind not in _KINDS:
        raise _refused(f'joint {name} is of type {kind!r}: use one of {", ".join(_KINDS)}')
    child = element.find('child')
    limit = element.find('limit')
    stated: dict[str, float] = {}
    for key in ('lower', 'upper', 'velocity', 'effort'):
        text = None if limit is None else limit.get(key)
        if text is not None:
            stated[key] = _limit(text, f'the {key} limit of joint {name}')
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
    link = '' if child is None else child.get('link', '')
    entry = element.find('dynamics')
    dynamics = {} if entry is None else {k: x for k, x in entry.items() if not _is_zero(x)}
    return UrdfJoint(name, kind, link, limits, mimic, dynamics)


def _is_zero(text: str) -> bool:
    try:
        return float(text) == 0.0
    except ValueError:
        return False


def _limit(text: str, what: str) -> float:
    """Return a limit; "inf", and what is larger than a number can be, say that there is none."""
    try:
        if math.isinf(value := float(text)):
            return value
    except ValueError:
        pass
    return _number(text, what, math.inf)


def _number(text: str | None, what: str, largest: float = _LARGEST) -> float:
    if text is None:
        raise _refused(f'{what} is missing: give a number')
    try:
        number = plain_number(text)
        if abs(number) > largest:
            raise ValueError
        return number
    except ValueError as error:
        way = ': it is xacro still; use what xacro prints' if '${' in text else ''
        raise _refused(f'{what} is {text!r}, no number of a robot{way}') from error


def _vector(text: str, what: str) -> FloatArray:
    values = [_number(part, what) for part in text.split()]
    if len(values) != 3:
        raise _refused(f'{what} is {text!r}: give three numbers')
    return np.array(values)


def _plain_joint(
    element: ElementTree.Element, joint: UrdfJoint, links: Collection[str]
) -> ElementTree.Element:
    # A continuous joint turned as a revolute one has an angle for its position, of any size.
    kind = 'revolute' if joint.kind == 'continuous' else joint.kind
    plain = ElementTree.Element('joint', {'name': joint.name, 'type': kind})
    for tag in ('parent', 'child'):
        end = element.find(tag)
        link = '' if end is None else end.get('link', '')
        if link not in links:
            raise _refused(f'the {tag} of joint {joint.name} is {link!r}, which is no link of it')
        ElementTree.SubElement(plain, tag, {'link': link})
    plain.append(_plain_origin(element, f'joint {joint.name}'))
    axis = element.find('axis')
    if axis is not None and joint.kind not in ('fixed', 'floating'):
        text = axis.get('xyz', '1 0 0')
        direction = _vector(text, f'the axis of joint {joint.name}')
        # Its length says nothing, and too small or large a one cannot be made 1.
        if not 1e-6 < float(np.abs(direction).max()) < 1e6:
            raise _refused(
                f'the axis of joint {joint.name} is {text!r}, which is no direction: give a '
                'vector of length 1'
            )
        ElementTree.SubElement(plain, 'axis', {'xyz': ' '.join(map(repr, direction.tolist()))})
    if joint.is_single:
        low, high = f'-{_UNLIMITED}', _UNLIMITED
        limit = {'lower': low, 'upper': high, 'velocity': high, 'effort': high}
        ElementTree.SubElement(plain, 'limit', limit)
    return plain


def _check_tree(plain: ElementTree.Element, links: Collection[str]) -> None:
    """See that the links hang on one another as a tree, from one root."""
    parents: dict[str, str] = {}
    for joint in plain.findall('joint'):
        parent, child = (joint[i].get('link', '') for i in range(2))
        if child in parents:
            raise _refused(f'link {child} is the child of two joints: a link hangs on one')
        parents[child] = parent
    roots = [link for link in links if link not in parents]
    if len(roots) > 1:
        raise _refused(
            f'the links {", ".join(roots)} hang on none: join all but one of them to the others'
        )
    reached = set(roots)
    children: dict[str, list[str]] = {}
    for child, parent in parents.items():
        children.setdefault(parent, []).append(child)
    waiting = list(roots)
    while waiting:
        more = children.get(waiting.pop(), [])
        reached.update(more)
        waiting += more
    around = [link for link in links if link not in reached]
    if around:
        raise _refused(f'the links {", ".join(around)} hang on one another in a ring')


def _check_mimics(joints: dict[str, UrdfJoint]) -> None:
    for joint in joints.values():
        seen, at = {joint.name}, joint
        while at.mimic is not None:
            leader = at.mimic.leader
            if leader not in joints or leader in seen:
                raise _refused(
                    f'joint {at.name} mimics {leader!r}, which '
                    f'{"mimics it" if leader in seen else "is no joint that moves"}'
                )
            seen.add(leader)
            at = joints[leader]
