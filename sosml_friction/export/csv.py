# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A table of every parameter, for a spreadsheet."""

import csv
import io

from sosml_friction.export.common.target import ExportTarget, entries
from sosml_friction.model.model_folder import RobotModelFile


class CsvTarget(ExportTarget):
    """Write a row for each parameter: joint, term, parameter, value, standard error, unit."""

    identifier = 'csv'
    file = 'model.csv'
    holds_all = True

    def text(self, model: RobotModelFile) -> str:
        """Return the table, its head first; what is not known is empty."""
        stream = io.StringIO()
        writer = csv.writer(stream)
        writer.writerow(['joint', 'term', 'parameter', 'value', 'std_error', 'unit'])
        rows = [(n, 'body', 'armature', j.armature) for n, j in model.joints.items()]
        for joint, term, name, p in [*rows, *entries(model)]:
            error = '' if p.std_error != p.std_error else repr(float(p.std_error))
            writer.writerow([joint, term, name, repr(float(p.value)), error, p.unit])
        return stream.getvalue()
