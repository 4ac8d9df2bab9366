# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""URDF with ``<dynamics>``: Coulomb and viscous friction of each joint."""

import xml.etree.ElementTree as ElementTree
from typing import ClassVar

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.target import ExportTarget, entries
from sosml_friction.model.model_folder import RobotModelFile

#: Attribute of ``<dynamics>`` by the parameter that it holds [Nm, Nm s/rad; N, N s/m].
_ATTRIBUTES = {'coulomb': 'friction', 'viscous': 'damping'}


class UrdfTarget(ExportTarget):
    """Write the model's URDF with friction and damping; the armature has no place in it."""

    identifier: ClassVar[str] = 'urdf'
    file: ClassVar[str] = 'robot.urdf'

    def lost(self, model: RobotModelFile) -> list[str]:
        """Return the terms and armatures that URDF has no field for."""
        rotors = [f'armature of {n}' for n, j in model.joints.items() if j.armature.value != 0.0]
        return [*super().lost(model), *rotors]

    def text(self, model: RobotModelFile) -> str:
        """Return the document; intervals and losses are in a comment at its head."""
        if model.urdf is None:
            raise ConfigurationError(f'model {model.name} has no URDF to write friction into')
        root = ElementTree.fromstring(model.urdf)
        joints = {joint.get('name'): joint for joint in root.iter('joint')}
        notes = [f'Lost: {", ".join(self.lost(model)) or "nothing"}.']
        for entry in entries(model):
            attribute = _ATTRIBUTES.get(entry.name)
            if attribute is None or entry.term != entry.name:
                continue
            joint, p = joints[entry.joint], entry.parameter
            dynamics = joint.find('dynamics')
            if dynamics is None:
                dynamics = ElementTree.SubElement(joint, 'dynamics')
            dynamics.set(attribute, repr(float(p.value)))
            notes.append(f'{entry.joint} {attribute}: {p.value:.6g} ({p.std_error:.2g}) {p.unit}')
        comment = '; '.join(notes).replace('--', '- -')
        return f'<!-- {comment} -->\n{ElementTree.tostring(root, encoding="unicode")}\n'
