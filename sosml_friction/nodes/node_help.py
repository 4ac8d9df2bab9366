# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a node says of itself on ``--help``."""

import sys
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from sosml_friction.nodes.parameters import ParameterSpec

_WIDTH = 96


@dataclass(frozen=True)
class NodeHelp:
    """Hold what a node prints on ``--help``, such as the arguments of one useful call."""

    name: str
    purpose: str
    example: str
    parameters: Sequence[ParameterSpec]

    @staticmethod
    def asked_for(args: Sequence[str] | None) -> bool:
        """Tell whether ``--help`` or ``-h`` is among the program's own arguments, not ROS's."""
        own = list(sys.argv[1:] if args is None else args)
        if '--ros-args' in own:
            own = own[: own.index('--ros-args')]
        return bool({'--help', '-h'} & set(own))

    def text(self) -> str:
        """Return purpose, usage, example and every parameter, in lines of 96 columns."""
        parts = [
            f'Usage: {self.name} [--ros-args [-p NAME:=VALUE]... [--params-file FILE]...]',
            '',
            *textwrap.wrap(self.purpose, _WIDTH),
            '',
            f'Example: {self.name} {self.example}',
        ]
        if self.parameters:
            parts += [
                '',
                'Parameters, read at the start unless they say otherwise ({joint}.x: one per '
                'joint):',
            ]
        for spec in self.parameters:
            parts.append(f'  {spec.name} ({", ".join(_facts(spec))})')
            parts += textwrap.wrap(
                spec.description, _WIDTH, initial_indent='      ', subsequent_indent='      '
            )
        return '\n'.join(parts) + '\n'


def _facts(spec: ParameterSpec) -> list[str]:
    """Return type with unit, limits and default of a parameter."""
    facts = [spec.type + (f' [{spec.unit}]' if spec.unit else '')]
    if spec.range is not None:
        facts.append(f'{spec.range[0]:g} to {spec.range[1]:g}')
    if spec.choices:
        facts.append('one of ' + ' | '.join(spec.choices))
    empty = spec.default in ('', [])
    facts.append(
        'required'
        if spec.default is None
        else f'default {"empty" if empty else str(spec.default).replace(chr(39), "")}'
    )
    return facts
