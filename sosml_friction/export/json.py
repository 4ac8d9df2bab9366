# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The whole model as JSON, for a program of one's own."""

import json

import yaml

from sosml_friction.export.common.target import ExportTarget
from sosml_friction.model.model_folder import RobotModelFile


class JsonTarget(ExportTarget):
    """Write what ``model.yaml`` has, its URDF as text, as one JSON object."""

    identifier = 'json'
    file = 'model.json'
    holds_all = True

    def text(self, model: RobotModelFile) -> str:
        """Return the object; what is not known is null."""
        document = yaml.safe_load(model.to_yaml())
        document['urdf'] = model.urdf
        return json.dumps(document, indent=2, ensure_ascii=False, default=str) + '\n'
