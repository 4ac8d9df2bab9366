# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A table of every parameter, for a paper."""

import math

from sosml_friction.export.common.target import ExportTarget, entries
from sosml_friction.model.model_folder import RobotModelFile

_ESCAPED = str.maketrans({c: '\\' + c for c in '_&%$#{}'})


class LatexTarget(ExportTarget):
    """Write a ``tabular`` with value, standard error and unit of each parameter."""

    identifier = 'latex'
    file = 'model.tex'
    holds_all = True

    def text(self, model: RobotModelFile) -> str:
        """Return the environment; it needs no package."""
        lines = [r'\begin{tabular}{lllrrl}', r'\hline',
                 r'joint & term & parameter & value & error & unit \\', r'\hline']  # fmt: skip
        for joint, term, name, p in entries(model):
            error = f'{p.std_error:.2g}' if math.isfinite(p.std_error) else '--'
            cells = [joint, term, name, f'{p.value:.5g}', error, p.unit]
            lines.append(' & '.join(cell.translate(_ESCAPED) for cell in cells) + r' \\')
        return '\n'.join([*lines, r'\hline', r'\end{tabular}', ''])
