# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Isaac Lab: an ``ImplicitActuatorCfg`` of each joint, by PhysX's law of joint friction."""

import math
import re

from sosml_friction.export.common.target import ExportTarget
from sosml_friction.model.model_folder import RobotModelFile


class IsaacLabTarget(ExportTarget):
    """
    Write a Python file with ``ACTUATORS``, for ``ArticulationCfg(actuators=...)``.

    PhysX: up to ``friction`` [Nm or N] a joint stands, then ``dynamic_friction`` and
    ``viscous_friction`` [Nm s/rad or N s/m] act; dynamic is at most static. ``stiffness`` and
    ``damping`` are gains of the drive and no friction: None leaves those of the asset.
    """

    identifier = 'isaaclab'
    file = 'actuators.py'
    holds_armature = True

    def text(self, model: RobotModelFile) -> str:
        """Return the file; intervals and losses are comments at its head."""
        lines = [f'# {note}' for note in self.notes(model)]
        lines += [
            '# stiffness and damping are the gains of the drive, and no friction.',
            'from isaaclab.actuators import ImplicitActuatorCfg',
            '',
            'ACTUATORS = {',
        ]
        for name, own in self.held(model).items():
            numbers: dict[str, float | None] = {
                'friction': own.standing,
                'dynamic_friction': own.constants['coulomb'],
                'viscous_friction': own.constants['viscous'],
            }
            armature = model.joints[name].armature.value
            # NaN is no number to write: None leaves what the asset has.
            numbers['armature'] = armature if math.isfinite(armature) else None
            # Isaac Lab matches all of a name by a regular expression.
            given = {'joint_names_expr': [re.escape(name)], 'stiffness': None, 'damping': None}
            lines.append(f'    {name!r}: ImplicitActuatorCfg(')
            lines += [f'        {key}={value!r},' for key, value in {**given, **numbers}.items()]
            lines.append('    ),')
        return '\n'.join([*lines, '}', ''])
