# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Another mass distribution, or another stand of the base, written into a URDF."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Collection, Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.xml_text import number_list, parse_xml

#: Name of the link and the joint that turn a base; a number is added where it is taken.
_TURNED = 'turned_base'
#: Share of an inertia about the joint that its difference to that of a point mass is wrong by: the
#: equations of a fit have a ridge of 1e-10, and all bodies beyond are no points.
_ROUNDED = 1e-9


def with_bodies(urdf: str, bodies: Mapping[str, FloatArray], held: Collection[str] = ()) -> str:
    """
    Return the URDF with other mass distributions.

    What is fixed to a joint's link, or on a joint that is held still, is one body with it: the
    link gets the whole, and the inertias of the others go away. Shapes and everything else stay.

    :param bodies: by joint, m, m c (x, y, z), I (xx, xy, yy, xz, yz, zz) of the body it moves, in
        the joint's frame and about its origin [kg, kg m, kg m2].
    :param held: joints that are held still (:attr:`Robot.held`).
    :raises ConfigurationError: if a joint is not there or a body has no positive mass.
    """
    root = parse_xml(urdf)
    joints = {joint.get('name'): joint for joint in root.findall('joint')}
    links = {link.get('name'): link for link in root.findall('link')}
    for name, body in bodies.items():
        if name not in joints:
            raise ConfigurationError(f'the URDF has no joint {name}: its inertia is not written')
        if not body[0] > 0.0:
            raise ConfigurationError(f'the body of joint {name} has the mass {body[0]:g} kg')
        child = _of(joints[name], 'child')
        for other in _fixed_to(root, child, held):
            for inertial in links[other].findall('inertial'):
                links[other].remove(inertial)
        for inertial in links[child].findall('inertial'):
            links[child].remove(inertial)
        links[child].insert(0, _inertial(body))
    return _text(root)


def with_turned_base(urdf: str, rotation: FloatArray) -> str:
    """
    Return the URDF with its base turned, by a link before its root.

    :param rotation: vector (3,) [rad]: about its direction, by its length, in the root's frame.
    """
    root = parse_xml(urdf)
    names = {element.get('name') for element in root.iter() if element.tag in ('link', 'joint')}
    name, k = _TURNED, 1
    while name in names or f'{name}_mount' in names:
        k += 1
        name = f'{_TURNED}_{k}'
    children = {_of(joint, 'child') for joint in root.findall('joint')}
    first = next(link for link in root.findall('link') if link.get('name') not in children)
    angles = Rotation.from_rotvec(rotation).as_euler('xyz')
    joint = ElementTree.Element('joint', {'name': f'{name}_mount', 'type': 'fixed'})
    ElementTree.SubElement(joint, 'parent', {'link': name})
    ElementTree.SubElement(joint, 'child', {'link': str(first.get('name'))})
    ElementTree.SubElement(joint, 'origin', {'xyz': '0 0 0', 'rpy': number_list(angles)})
    root.insert(0, joint)
    root.insert(0, ElementTree.Element('link', {'name': name}))
    return _text(root)


def _text(root: ElementTree.Element) -> str:
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding='unicode') + '\n'


def _of(joint: ElementTree.Element, what: str) -> str:
    element = joint.find(what)
    return '' if element is None else str(element.get('link'))


def _fixed_to(root: ElementTree.Element, link: str, held: Collection[str]) -> list[str]:
    """Return the links that fixed or held joints hang on a link, and those on them."""
    found = []
    for joint in root.findall('joint'):
        is_still = joint.get('type') == 'fixed' or joint.get('name') in held
        if is_still and _of(joint, 'parent') == link:
            child = _of(joint, 'child')
            found += [child, *_fixed_to(root, child, held)]
    return found


def _inertial(body: FloatArray) -> ElementTree.Element:
    """Return the element of a body: mass, centre, and inertia about the centre."""
    m, first = float(body[0]), body[1:4]
    xx, xy, yy, xz, yz, zz = body[4:]
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    c = first / m
    own = tensor - m * (float(c @ c) * np.eye(3) - np.outer(c, c))
    # What is left of the difference of two equal numbers is none: all mass is in one point.
    none = np.abs(own).max(axis=0) <= _ROUNDED * np.abs(tensor).max()
    own[none], own[:, none] = 0.0, 0.0
    return inertial_element(m, c, own)


def inertial_element(mass: float, centre: FloatArray, tensor: FloatArray) -> ElementTree.Element:
    """Return the element of a body: mass [kg], centre [m], inertia about the centre [kg m2]."""
    element = ElementTree.Element('inertial')
    ElementTree.SubElement(element, 'origin', {'xyz': number_list(centre), 'rpy': '0 0 0'})
    ElementTree.SubElement(element, 'mass', {'value': repr(mass)})
    names = ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')
    values = tensor[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    ElementTree.SubElement(
        element, 'inertia', {k: repr(float(x)) for k, x in zip(names, values, strict=True)}
    )
    return element
