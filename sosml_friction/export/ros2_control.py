# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""URDF with ``<ros2_control>``: every number of a joint as a parameter of its hardware."""

import xml.etree.ElementTree as ElementTree

from sosml_friction.export.common.target import ExportTarget, entries
from sosml_friction.export.urdf import UrdfTarget
from sosml_friction.model.model_folder import RobotModelFile


class Ros2ControlTarget(UrdfTarget):
    """
    Write the model's URDF with ``<dynamics>`` and a ``<ros2_control>`` block.

    A simulation reads ``<dynamics>``, which holds Coulomb and viscous friction; a hardware
    interface or a controller of one's own finds each parameter of the model as ``<param>`` of
    the joint, ``TERM.PARAMETER``, and its ``armature``.
    """

    identifier = 'ros2-control'
    file = 'robot_ros2_control.urdf'
    _plugin = 'mock_components/GenericSystem'

    def _document(self, model: RobotModelFile) -> ElementTree.Element:
        root = super()._document(model)
        block = ElementTree.SubElement(
            root, 'ros2_control', {'name': model.name, 'type': 'system'}
        )
        hardware = ElementTree.SubElement(block, 'hardware')
        ElementTree.SubElement(hardware, 'plugin').text = self._plugin
        for name, joint in model.joints.items():
            element = ElementTree.SubElement(block, 'joint', {'name': name})
            ElementTree.SubElement(element, 'command_interface', {'name': 'effort'})
            for state in ('position', 'velocity', 'effort'):
                ElementTree.SubElement(element, 'state_interface', {'name': state})
            values = {f'{e.term}.{e.name}': e.parameter for e in entries(model) if e.joint == name}
            for key, parameter in {'armature': joint.armature, **values}.items():
                param = ElementTree.SubElement(element, 'param', {'name': key})
                param.text = repr(float(parameter.value))
        return root

    def notes(self, model: RobotModelFile) -> list[str]:
        """Return the lines of a comment."""
        return [*ExportTarget.notes(self, model),
                f'Put your hardware in the place of {self._plugin}.']  # fmt: skip
