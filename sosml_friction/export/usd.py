# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""USD, Isaac Sim's form: ``PhysxJointAxisAPI`` of each joint, as a layer over one's own stage."""

import math
import re

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.target import ExportTarget
from sosml_friction.model.model_folder import RobotModelFile


class UsdTarget(ExportTarget):
    """
    Write a layer that goes before one's own stage, by PhysX's law of joint friction.

    Static and dynamic friction are efforts [Nm or N], viscous friction of what turns is per degree
    [Nm s/deg], in a stage of metres and kilograms. Joints are at ``/MODEL/joints/JOINT``, where
    Isaac Sim's URDF importer has them; links, frames and drives are left to the stage.
    """

    identifier = 'usd'
    file = 'joints.usda'
    holds_armature = True

    def text(self, model: RobotModelFile) -> str:
        """
        Return the layer; intervals and losses are comments at its head.

        :raises ConfigurationError: if two joints have one name in USD.
        """
        robot = _identifier(model.name)
        stage = f'defaultPrim = "{robot}"\n    kilogramsPerUnit = 1\n    metersPerUnit = 1'
        lines = [f'#usda 1.0\n(\n    {stage}\n)', *(f'# {note}' for note in self.notes(model))]
        lines += [
            '# It goes before your own, in a stage with subLayers = [@joints.usda@, @robot.usd@].',
            '# Joints that are elsewhere there: change the paths below.',
            f'\nover "{robot}"\n{{\n    over "joints"\n    {{',
        ]
        known: dict[str, str] = {}
        for name, own in self.held(model).items():
            prim = _identifier(name)
            if prim in known:
                raise ConfigurationError(
                    f'joints {known[prim]} and {name} are both {prim} in USD: rename one'
                )
            known[prim] = name
            joint = model.joints[name]
            turns = joint.armature.unit == 'kg m2'
            axis = 'angular' if turns else 'linear'
            numbers = {
                'armature': joint.armature.value,
                'dynamicFrictionEffort': own.constants['coulomb'],
                'staticFrictionEffort': own.standing,
                'viscousFrictionCoefficient': own.constants['viscous']
                * (math.pi / 180.0 if turns else 1.0),
            }
            # An armature that is not known is left to the stage.
            given = [
                f'            float physxJointAxis:{axis}:{key} = {value!r}'
                for key, value in numbers.items()
                if math.isfinite(value)
            ]
            schemas = f'prepend apiSchemas = ["PhysxJointAxisAPI:{axis}"]'
            lines += [f'        over "{prim}" (\n            {schemas}\n        )\n        {{']
            lines += [*given, '        }']
        return '\n'.join([*lines, '    }', '}', ''])


def _identifier(name: str) -> str:
    """Return a name as USD can have it, as ``Tf.MakeValidIdentifier`` makes it."""
    return re.sub(rb'^\d|[^A-Za-z0-9_]', b'_', name.encode()).decode() or '_'
