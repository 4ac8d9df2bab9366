# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A proposed mapping: its content, the reason of each entry, and the file that it makes."""

import json
from dataclasses import dataclass, field
from typing import Any

from sosml_friction.bags.tables.mapping import FILL_IN, open_places

#: Words that YAML takes for something else.
_YAML_WORDS = frozenset(('y', 'n', 'yes', 'no', 'on', 'off', 'true', 'false', 'null'))


@dataclass
class Guess:
    """
    Hold a proposed mapping.

    ``content``: as in a mapping file, with ``FILL_IN`` where the data leave it open; ``reasons``
    by key, such as ``joints.arm.velocity``; ``remarks``: sentences about the rest of the file.
    """

    content: dict[str, Any] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    @property
    def left_open(self) -> list[str]:
        """Return the keys that are to be filled in."""
        return open_places(self.content)

    def sentences(self) -> list[str]:
        """Return what every column was taken for, and why."""
        told = []
        for key, why in self.reasons.items():
            entry: Any = self.content
            for part in key.split('.', 2):
                entry = entry[part]
            if isinstance(entry, dict):
                said = f' is {entry["variable"]} [{entry.get("unit", FILL_IN)}]'
            else:
                said = '' if entry == FILL_IN else f' is {entry:g} Hz'
            told.append(f'{key.removeprefix("joints.")}{said}: {why}')
        return told

    def to_yaml(self, title: str) -> str:
        """Return the text of the mapping file, each reason beside its line."""
        lines = [f'# {line}' for line in (title, *self.remarks)]
        for key, value in self.content.items():
            if key != 'joints':
                lines += [*self._why(key), f'{key}: {_flow(value)}']
        lines.append('joints:')
        for joint, quantities in self.content['joints'].items():
            lines.append(f'  {_word(joint)}:')
            for quantity, value in quantities.items():
                key = f'joints.{joint}.{quantity}'
                lines += [f'    {why}' for why in self._why(key)]
                lines.append(f'    {quantity}: {_flow(value)}')
        return '\n'.join(lines) + '\n'

    def _why(self, key: str) -> list[str]:
        return [f'# {self.reasons[key]}'] if key in self.reasons else []


def _word(text: str) -> str:
    plain = text.replace('_', '').replace('.', '')
    is_plain = plain.isalnum() and not plain[0].isdecimal()
    return (
        text
        if is_plain and text.lower() not in _YAML_WORDS
        else json.dumps(text, ensure_ascii=False)
    )


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return '{' + ', '.join(f'{key}: {_flow(x)}' for key, x in value.items()) + '}'
    return _word(value) if isinstance(value, str) else json.dumps(value)
