# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Write ``docs/constants.md``: every number of the diagnosis, with what its source says of it.

``python -m validation.constants > docs/constants.md``
"""

from __future__ import annotations

import ast
import importlib
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sosml_friction.diagnosis
import sosml_friction.regression
from sosml_friction.regression.settings import DiagnosisSettings

#: What a comment says of a number without an origin, and of one that was halved and doubled.
CHOSEN, CHANGED = 'chosen, no measurement', 'validation.sensitivity'
_HEAD = """\
# The numbers of the diagnosis

Written by `python -m validation.constants > docs/constants.md`; a test compares the two. Each row
is a constant of `sosml_friction/diagnosis/` or `sosml_friction/regression/`, with the comment
above it: what it is, its unit, and where it comes from. {count} of {all} say "Chosen, no
measurement": they have no origin. {changed} trade one thing for another, and say what hangs on
them: `python -m validation.sensitivity --seed 1` halves and doubles each number of both kinds.
"""


@dataclass(frozen=True)
class Number:
    """Hold where a number stands, ``module`` and ``name``, its value, and the comment above it."""

    module: str
    name: str
    value: Any
    comment: str = ''

    @property
    def label(self) -> str:
        """Return module and name, within the package."""
        return f'{self.module.removeprefix("sosml_friction.")}.{self.name}'

    @property
    def is_chosen(self) -> bool:
        """Tell whether its comment says that it has no origin."""
        return CHOSEN in self.comment.lower()

    @property
    def is_changed(self) -> bool:
        """Tell whether its comment says which answers change with it."""
        return CHANGED in self.comment


def constants() -> list[Number]:
    """Return the constants of diagnosis and regression that are numbers."""
    found = []
    for package in (sosml_friction.diagnosis, sosml_friction.regression):
        for entry in pkgutil.walk_packages(package.__path__, package.__name__ + '.'):
            module = importlib.import_module(entry.name)
            source = Path(str(module.__file__)).read_text()
            found += [
                Number(entry.name, name, getattr(module, name), comment)
                for name, comment in _assigned(source)
                if _is_number(getattr(module, name))
            ]
    return found


def _assigned(source: str) -> Iterator[tuple[str, str]]:
    """Yield the names of constants of a module, and the comments above them."""
    lines = source.splitlines()
    for statement in ast.parse(source).body:
        if not isinstance(statement, ast.Assign):
            continue
        first = statement.lineno - 1
        above = first
        while above and lines[above - 1].startswith('#'):
            above -= 1
        comment = ' '.join(line.removeprefix('#:').strip() for line in lines[above:first])
        for target in statement.targets:
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            yield from ((name.id, comment) for name in names if isinstance(name, ast.Name))


def _is_number(value: Any) -> bool:
    if isinstance(value, tuple):
        return bool(value) and all(_is_number(part) for part in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def constants_document() -> str:
    """Return the page."""
    found = constants()
    head = _HEAD.format(
        count=sum(number.is_chosen for number in found),
        all=len(found),
        changed=sum(number.is_changed for number in found),
    )
    settings = [
        f'`{name} = {value:g}`'
        for name, value in vars(DiagnosisSettings()).items()
        if _is_number(value)
    ]
    text = [head, f'What a caller may state, `DiagnosisSettings`: {", ".join(settings)}.']
    for module in dict.fromkeys(number.module for number in found):
        path = module.removeprefix('sosml_friction.').replace('.', '/')
        text += ['', f'## {path}.py', '', '| number | value | what it is, and its origin |']
        text.append('|---|---|---|')
        for number in (each for each in found if each.module == module):
            comment = number.comment.replace('|', '\\|')
            text.append(f'| `{number.name}` | {_shown(number.value)} | {comment} |')
    return '\n'.join(text) + '\n'


def _shown(value: Any) -> str:
    return ', '.join(map(_shown, value)) if isinstance(value, tuple) else f'{value:.4g}'


if __name__ == '__main__':
    print(constants_document(), end='')
