# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Write ``docs/parameters.md`` from the nodes' own tables.

``python -m validation.parameter_tables > docs/parameters.md``
"""

from collections.abc import Sequence

from sosml_friction.nodes import (
    driver_node,
    emulator_node,
    identifier_node,
    observer_node,
    replay_node,
)
from sosml_friction.nodes.parameters import ParameterSpec

_NODES = (driver_node, observer_node, identifier_node, replay_node, emulator_node)


def parameter_document() -> str:
    """Return the page: one table per node."""
    parts = [
        '# Parameters',
        'All are read when the node starts; those that say so may be changed at run time.',
        '`{joint}.x` stands for one parameter per joint. The values for the exoskeleton are in',
        '`config/exoskeleton.yaml`.',
    ]
    text = f'{parts[0]}\n\n' + '\n'.join(parts[1:]) + '\n'
    for node in _NODES:
        name = node.__name__.rpartition('.')[2]
        text += f'\n## {name}\n\n{markdown_table(node.PARAMETERS)}\n'
    return text


def markdown_table(specs: Sequence[ParameterSpec]) -> str:
    """Return the table of parameters for the README."""
    lines = [
        '| parameter | type | default | unit | range | what it is |',
        '|---|---|---|---|---|---|',
    ]
    for spec in specs:
        default = 'required' if spec.default is None else f'`{spec.default}`'
        limits = (
            f'{spec.range[0]:g} .. {spec.range[1]:g}' if spec.range else ', '.join(spec.choices)
        )
        cells = (f'`{spec.name}`', spec.type, default, spec.unit, limits, spec.description)
        lines.append(f'| {" | ".join(cells)} |')
    return '\n'.join(lines)


if __name__ == '__main__':
    print(parameter_document(), end='')
