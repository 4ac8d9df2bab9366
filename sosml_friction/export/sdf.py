# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""SDF, Gazebo's form: ``<axis><dynamics>`` of each joint."""

import xml.etree.ElementTree as ElementTree

from sosml_friction.export.common.holding import joint_terms
from sosml_friction.export.common.target import ExportTarget
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.xml_text import commented

#: Element of ``<dynamics>`` by the constant that it holds [Nm, Nm s/rad; N, N s/m].
_ELEMENTS = {'viscous': 'damping', 'coulomb': 'friction'}


class SdfTarget(ExportTarget):
    """
    Write a model with the joints' ``<dynamics>``, to be merged into one's own SDF.

    Gazebo converts a URDF itself: links, frames and shapes are left to it. The armature has no
    place in SDF.
    """

    identifier = 'sdf'
    file = 'joints.sdf'

    def text(self, model: RobotModelFile) -> str:
        """Return the document; intervals and losses are in a comment at its head."""
        root = ElementTree.Element('sdf', {'version': '1.9'})
        robot = ElementTree.SubElement(root, 'model', {'name': model.name})
        stated = {} if model.urdf is None else read_joints(model.urdf).joints
        terms = joint_terms(model)
        for name, own in self.held(model).items():
            prismatic = model.joints[name].armature.unit == 'kg'
            kind = (
                stated[name].kind if name in stated else 'prismatic' if prismatic else 'revolute'
            )
            joint = ElementTree.SubElement(robot, 'joint', {'name': name, 'type': kind})
            axis = ElementTree.SubElement(joint, 'axis')
            dynamics = ElementTree.SubElement(axis, 'dynamics')
            for key, element in _ELEMENTS.items():
                ElementTree.SubElement(dynamics, element).text = repr(own.constants[key])
            springs = [t.amplitude for t in terms[name] if t.term.identifier == 'spring']
            stiffness = float(sum(x[0] for x in springs))
            if stiffness:
                rest = -float(sum(x[1] for x in springs)) / stiffness
                ElementTree.SubElement(dynamics, 'spring_stiffness').text = repr(stiffness)
                ElementTree.SubElement(dynamics, 'spring_reference').text = repr(rest)
        ElementTree.indent(root)
        return commented(root, self.notes(model))
