# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
A model written into an MJCF: into one's own, into that of its URDF, or as a snippet.

Friction that holds needs a constraint as hard as the step allows: a joint under a torque creeps
by tau / J (1 - d0) / d0 d_max tc / 2, with tc = 2 h the time constant of ``solreffriction`` and
d0, d_max the first numbers of ``solimpfriction``: 3 mrad/s by MuJoCo's defaults, a few urad/s by
these.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.consistent_inertias import body_numbers, pseudo_inertia
from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.mujoco.engine import compiled, joint_id, spec_of
from sosml_friction.mujoco.friction import RIPPLE, TEXT, embedded
from sosml_friction.mujoco.reading import matrix, upright
from sosml_friction.text_file import read_text
from sosml_friction.xml_text import commented, number_list, parse_xml

_IMPEDANCE = '0.999 0.9999 0.001'
#: Least frictionloss [Nm or N]: a joint that is compiled without has no constraint for the module.
_LEAST = 1e-6
#: Motor constant of an actuator that only ripples: 3.17 refuses 0; it damps by its square.
_NO_MOTOR = '1e-9'
#: MuJoCo's own time step [s], where an MJCF says none.
_STEP = 2e-3
#: What in an MJCF names files.
_FOLDERS = ('assetdir', 'meshdir', 'texturedir')

Element = ElementTree.Element


def write_mjcf(
    model: RobotModelFile,
    constants: Mapping[str, Mapping[str, float]],
    notes: Sequence[str],
    base: Path | None = None,
    bodies: RobotModelFile | None = None,
) -> str:
    """
    Return an MJCF with the friction of a model.

    :param constants: by joint, ``coulomb`` and ``viscous`` for a simulation without the module.
    :param base: MJCF whose joints get it; None: that of the model's URDF, or a snippet to be
        included where it has none.
    :param bodies: the model that ``base`` was read as, where bodies and gravity that differ from
        its are written, too; None: those of ``base`` stay.
    :raises ConfigurationError: if MuJoCo refuses ``base``, the URDF or what was written, or a
        joint of the model is not in it.
    """
    if base is None and model.urdf is None:
        return _text(_snippet(model, constants), notes)
    if base is not None:
        root = _read(base)
    else:
        assert model.urdf is not None
        root = parse_xml(spec_of(_without_meshes(model.urdf))[0].to_xml())
        _add_followers(root, model.urdf)
    joints = _joint_elements(root)
    if base is not None and any(name not in joints for name in model.joints):
        # They are in a file that it includes, or do not exist.
        root = parse_xml(spec_of(base)[0].to_xml())
        joints = _joint_elements(root)
    missing = [name for name in model.joints if name not in joints]
    if missing:
        raise ConfigurationError(
            f'the MJCF has no joint {", ".join(missing)}: it has {", ".join(joints) or "none"}'
        )
    if base is not None:
        _absolute(root, base.resolve().parent)
    m = compiled(ElementTree.tostring(root, encoding='unicode'))
    compiler = root.find('compiler')
    degrees = compiler is None or compiler.get('angle', 'degree') == 'degree'
    for name in model.joints:
        joints[name].attrib.update(_attributes(model, name, constants[name], m.opt.timestep))
        _spring(joints[name], model, name, degrees)
    actuators = _section(root, 'actuator')
    for element in list(actuators):
        # Of an earlier export.
        if str(element.get('name')).startswith(RIPPLE):
            actuators.remove(element)
    actuators.extend(_ripples(model))
    if not len(actuators):
        root.remove(actuators)
    _embed(_section(root, 'custom'), model)
    if bodies is not None:
        _write_bodies(root, m, bodies.make_robot(), model.make_robot())
    text = _text(root, [*notes, *_usage(m.opt.timestep)])
    compiled(text)
    return text


def _usage(step: float) -> Iterator[str]:
    yield f'frictionloss holds for the time step {step:g} s: solreffriction is two of them.'
    yield 'frictionloss and damping alone are the best constants; for all of the model:'
    yield '    from sosml_friction.mujoco import apply_friction'
    yield '    apply_friction(model, data)   # before each mujoco.mj_step(model, data)'


def _attributes(
    model: RobotModelFile, name: str, constants: Mapping[str, float], step: float
) -> dict[str, str]:
    armature = model.joints[name].armature.value
    level = max(constants['coulomb'], _LEAST)
    found = {
        'damping': repr(constants['viscous']), 'frictionloss': repr(level),
        'solreffriction': f'{2.0 * step!r} 1', 'solimpfriction': _IMPEDANCE,
    }  # fmt: skip
    return found | ({'armature': repr(float(armature))} if math.isfinite(armature) else {})


def _spring(joint: Element, model: RobotModelFile, name: str, degrees: bool) -> None:
    springs = [
        t for t in known_terms(model)
        if t.term.identifier == 'spring' and model.joint_names[t.joint] == name
    ]  # fmt: skip
    stiffness = sum(float(t.amplitude[0]) for t in springs)
    if stiffness > 0.0:
        joint.set('stiffness', repr(stiffness))
        rest = -sum(float(t.amplitude[1]) for t in springs) / stiffness
        turns = model.joints[name].armature.unit == 'kg m2'
        joint.set('springref', repr(math.degrees(rest) if degrees and turns else rest))


def _ripples(model: RobotModelFile) -> Iterator[Element]:
    """Yield a passive actuator for each ripple of a joint, a harmonic each."""
    for k, known in enumerate(known_terms(model)):
        if known.term.identifier != 'cogging':
            continue
        name = model.joint_names[known.joint]
        cosine, sine = map(float, known.amplitude)
        # What the actuator spends, A cos w q + B sin w q, acts on the joint with the other sign.
        size, phase = math.hypot(cosine, sine), math.atan2(-cosine, -sine)
        yield Element(
            'dcmotor', name=f'{RIPPLE}{name} {k}', joint=name, input='none',
            motorconst=_NO_MOTOR, resistance='1',
            cogging=f'{size!r} {known.inner["frequency"]!r} {phase!r}',
        )  # fmt: skip


def _snippet(model: RobotModelFile, constants: Mapping[str, Mapping[str, float]]) -> Element:
    root = Element('mujocoinclude')
    default = ElementTree.SubElement(root, 'default')
    classes = ElementTree.SubElement(default, 'default', {'class': 'sosml'})
    for name in model.joints:
        own = ElementTree.SubElement(classes, 'default', {'class': name})
        ElementTree.SubElement(own, 'joint', _attributes(model, name, constants[name], _STEP))
    actuator = Element('actuator')
    actuator.extend(_ripples(model))
    if len(actuator):
        root.append(actuator)
    _embed(ElementTree.SubElement(root, 'custom'), model)
    return root


def _read(path: Path) -> Element:
    try:
        return parse_xml(read_text(path, 'MJCF'))
    except ElementTree.ParseError as error:
        raise ConfigurationError(f'MJCF {path} is no XML: {error}') from error


def _without_meshes(urdf: str) -> str:
    """Return a URDF as MuJoCo is to read it: masses as stated, shapes that need no file."""
    root = parse_xml(urdf)
    for link in root.iter('link'):
        for shape in [*link.findall('visual'), *link.findall('collision')]:
            if shape.tag == 'collision' or shape.find('.//mesh') is not None:
                link.remove(shape)
    # MuJoCo refuses a point mass; the bound is far below the inertia of any body.
    _section(_section(root, 'mujoco'), 'compiler').attrib.update(
        discardvisual='false',
        inertiafromgeom='false',
        balanceinertia='true',
        boundinertia='1e-12',
        fusestatic='false',
    )
    return ElementTree.tostring(root, encoding='unicode')


def _add_followers(root: Element, urdf: str) -> None:
    """Tie the joints that mimic others, which MuJoCo's reading of a URDF leaves free."""
    for name, joint in read_joints(urdf).joints.items():
        if joint.mimic is not None and joint.is_single:
            line = f'{joint.mimic.offset!r} {joint.mimic.multiplier!r} 0 0 0'
            tie = {'joint1': name, 'joint2': joint.mimic.leader, 'polycoef': line}
            ElementTree.SubElement(_section(root, 'equality'), 'joint', tie)


def _joint_elements(root: Element) -> dict[str, Element]:
    found = (x for body in root.iter('worldbody') for x in body.iter('joint'))
    return {str(x.get('name')): x for x in found if x.get('name')}


def _embed(custom: Element, model: RobotModelFile) -> None:
    for text in custom.findall('text'):
        # Of an earlier export.
        if text.get('name') == TEXT:
            custom.remove(text)
    ElementTree.SubElement(custom, 'text', {'name': TEXT, 'data': embedded(model)})


def _section(root: Element, tag: str, first: bool = False) -> Element:
    """Return a child of the root, a new one at its beginning or its end where there is none."""
    found = root.find(tag)
    if found is None:
        found = Element(tag)
        root.insert(0 if first else len(root), found)
    return found


def _absolute(root: Element, folder: Path) -> None:
    """Let an MJCF name its files from any folder."""
    for include in root.iter('include'):
        include.set('file', str(folder / str(include.get('file'))))
    if root.find('.//*[@file]') is None and root.find('.//*[@fileright]') is None:
        return
    compiler = _section(root, 'compiler', first=True)
    stated = compiler.get('assetdir', '')
    for name in _FOLDERS[1:]:
        compiler.set(name, str(folder / compiler.get(name, stated)))
    compiler.attrib.pop('assetdir', None)


def _write_bodies(root: Element, m: Any, before: Robot, after: Robot) -> None:
    """Write the bodies and the gravity that differ, as the model has them."""
    own, new = before.inertial_parameters(), after.inertial_parameters()
    parents = {child: parent for parent in root.iter() for child in parent}
    joints = _joint_elements(root)
    changed = False
    for i, name in enumerate(after.names):
        if np.array_equal(own[i], new[i]):
            continue
        j = joint_id(m, name)
        body = parents[joints[name]]
        changed = True
        for inertial in body.findall('inertial'):
            body.remove(inertial)
        change = pseudo_inertia(new[i] - own[i])
        body.append(_inertial(_body(m, j) + _moved(change, np.eye(3), m.jnt_pos[j])))
    compiler = root.find('compiler')
    if changed and compiler is not None and compiler.get('inertiafromgeom') == 'true':
        compiler.set('inertiafromgeom', 'auto')
    turned = after.base_rotation @ before.base_rotation.T
    if not np.allclose(turned, np.eye(3), atol=1e-12):
        # The model's base is upright, wherever gravity of the MJCF points.
        stand = upright(m).turn
        gravity = stand.T @ turned.T @ stand @ np.asarray(m.opt.gravity)
        _section(root, 'option', first=True).set('gravity', number_list(gravity))


def _moved(body: FloatArray, turn: FloatArray, at: FloatArray) -> FloatArray:
    """Return the pseudo-inertia (4, 4) of a body that is turned and then moved to ``at``."""
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turn, at
    return np.asarray(place @ body @ place.T)


def _body(m: Any, j: int) -> FloatArray:
    """Return the pseudo-inertia of the body of a joint in the body's frame."""
    body = int(m.jnt_bodyid[j])
    xx, yy, zz = m.body_inertia[body]
    numbers = np.array([m.body_mass[body], 0.0, 0.0, 0.0, xx, 0.0, yy, 0.0, 0.0, zz])
    return _moved(pseudo_inertia(numbers), matrix(m.body_iquat[body]), m.body_ipos[body])


def _inertial(body: FloatArray) -> Element:
    mass = float(body[3, 3])
    centre = body[:3, 3] / mass
    full = body_numbers(_moved(body, np.eye(3), -centre))[[4, 6, 9, 5, 7, 8]]
    return Element(
        'inertial', pos=number_list(centre), mass=repr(mass), fullinertia=number_list(full)
    )


def _text(root: Element, notes: Sequence[str]) -> str:
    ElementTree.indent(root)
    return commented(root, notes)
