# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""MJCF, MuJoCo's form: joints that hold, ripple, and the model for ``sosml_friction.mujoco``."""

from pathlib import Path

from sosml_friction.export.common.motion import KnownMotion
from sosml_friction.export.common.target import NO_MOTION, ExportTarget
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.mujoco.writing import write_mjcf


class MjcfTarget(ExportTarget):
    """
    Write armature, damping and frictionloss that sticks into an MJCF.

    Into the one that was given, else into what MuJoCo makes of the model's URDF, else a snippet to
    be included. The whole model is in it as text, for ``sosml_friction.mujoco.apply_friction``.

    :param bodies: the model that ``base`` was read as, where bodies and gravity that differ from
        its are written, too; None: those of ``base`` stay.
    """

    identifier = 'mjcf'
    file = 'robot.xml'
    holds_armature = True
    takes_base = True

    def __init__(
        self,
        motion: KnownMotion = NO_MOTION,
        base: Path | None = None,
        bodies: RobotModelFile | None = None,
    ) -> None:
        super().__init__(motion, base)
        self._bodies = bodies

    def text(self, model: RobotModelFile) -> str:
        """Return the document; intervals and losses are in a comment at its head."""
        constants = {name: own.constants for name, own in self.held(model).items()}
        return write_mjcf(model, constants, self.notes(model), self.base, self._bodies)
