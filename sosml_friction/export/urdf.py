# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""URDF with ``<dynamics>``: Coulomb and viscous friction of each joint."""

import xml.etree.ElementTree as ElementTree

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.target import ExportTarget
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.xml_text import commented

#: Attribute of ``<dynamics>`` by the constant that it holds [Nm, Nm s/rad; N, N s/m].
_ATTRIBUTES = {'coulomb': 'friction', 'viscous': 'damping'}


class UrdfTarget(ExportTarget):
    """Write the model's URDF with friction and damping; the armature has no place in it."""

    identifier = 'urdf'
    file = 'robot.urdf'

    def text(self, model: RobotModelFile) -> str:
        """Return the document; intervals and losses are in a comment at its head."""
        root = self._document(model)
        return commented(root, self.notes(model))

    def _document(self, model: RobotModelFile) -> ElementTree.Element:
        if model.urdf is None:
            raise ConfigurationError(f'model {model.name} has no URDF to write friction into')
        root = ElementTree.fromstring(model.urdf)
        joints = {joint.get('name'): joint for joint in root.findall('joint')}
        for name, own in self.held(model).items():
            if model.joints[name].friction is None and not any(own.constants.values()):
                continue
            dynamics = joints[name].find('dynamics')
            if dynamics is None:
                dynamics = ElementTree.SubElement(joints[name], 'dynamics')
            for key, attribute in _ATTRIBUTES.items():
                dynamics.set(attribute, repr(own.constants[key]))
        return root
