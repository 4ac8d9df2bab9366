# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Halve and double each number of the diagnosis, and count the answers that change.

    python -m validation.sensitivity --seed 1 --out OUT

The recordings are those of :mod:`validation.axis_campaign`. A number is a constant of a module of
``diagnosis`` or ``regression`` that says "Chosen, no measurement" or what this command says of it,
or a default of ``DiagnosisSettings``; of a tuple all entries are changed together. An answer is
its verdict, and the effect, joint and rivals of each cause. One file per number and factor in OUT:
a run that was stopped goes on. Numbers inside compiled functions are not reached: none is chosen.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

from sosml_friction.regression.settings import DiagnosisSettings
from validation.axis_campaign import asked, hidden
from validation.constants import Number, constants

FACTORS = (0.5, 2.0)
#: Settings that are a way of looking at data, and no threshold.
_NO_NUMBER = ('trust',)
#: The answers: kind, effect and number of a trial.
PLAN = (
    ('single', 'stribeck', 0),
    ('single', 'position_dependent_friction', 0),
    ('single', 'effort_delay', 0),
    ('single', 'backlash', 0),
    ('single', 'spring', 0),
    ('null', '', 0),
    ('guess', 'stribeck', 1),
    ('outside', 'friction_step', 0),
    ('outside', 'root_friction', 0),
)
#: The outcomes that are as they should be, by kind.
GOOD = {
    'single': ('right', 'set'),
    'null': ('nothing',),
    'guess': ('right', 'size'),
    'outside': ('unknown',),
}


def chosen_numbers() -> list[Number]:
    """Return the constants that were chosen, with what hangs on them or without, and settings."""
    found = [number for number in constants() if number.is_chosen or number.is_changed]
    settings = DiagnosisSettings()
    found += [
        Number(DiagnosisSettings.__module__, each.name, value)
        for each in fields(settings)
        if each.name not in _NO_NUMBER
        and isinstance(value := getattr(settings, each.name), int | float)
        and not isinstance(value, bool)
    ]
    return [number for number in found if scaled(number.value, 2.0) is not None]


def scaled(value: Any, factor: float) -> Any:
    """Return a number, or each of a tuple, times a factor; None for what is neither."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int):
        return max(1, round(factor * value))
    if isinstance(value, float):
        return factor * value
    if isinstance(value, tuple):
        parts = tuple(scaled(part, factor) for part in value)
        return None if not parts or None in parts else parts
    return None


@contextmanager
def changed(number: Number, factor: float) -> Iterator[DiagnosisSettings]:
    """
    Change a number as long as the context lasts, and give the settings to be used there.

    A constant is changed wherever it was imported to.
    """
    new = scaled(number.value, factor)
    if number.module == DiagnosisSettings.__module__:
        yield replace(DiagnosisSettings(), **{number.name: new})
        return
    holders = [sys.modules[number.module]]
    if not number.name.startswith('_'):
        # Others import it under its name.
        own = [m for name, m in sys.modules.items() if name.startswith('sosml_friction')]
        holders = [m for m in own if vars(m).get(number.name) is number.value]
    for module in holders:
        setattr(module, number.name, new)
    try:
        yield DiagnosisSettings()
    finally:
        for module in holders:
            setattr(module, number.name, number.value)


# Drawn and simulated once, and asked again and again.
recorded_trial = cache(hidden)


def answers(seed: int, settings: DiagnosisSettings | None = None) -> list[list[Any]]:
    """Return outcome, verdict and causes of each recording of the plan."""
    found = []
    for each in PLAN:
        row = asked(recorded_trial(seed, *each), settings)
        found.append([row['outcome'], row.get('verdict'), row.get('causes')])
    return found


def row_of(label: str, base: Sequence[Any], by_factor: Sequence[Sequence[Any]]) -> str:
    """Return a line of the table: answers that change, and those that are good, by factor."""
    cells = [label]
    for own in by_factor:
        differ = sum(a != b for a, b in zip(base, own, strict=True))
        good = sum(a[0] in GOOD[kind] for a, (kind, _, _) in zip(own, PLAN, strict=True))
        cells.append(f'{differ} ({good} good)')
    return '| ' + ' | '.join(cells) + ' |'


def main() -> int:
    """Try what is not there yet, and print the table."""
    parser = argparse.ArgumentParser(prog='python -m validation.sensitivity', description=__doc__)
    parser.add_argument('--out', type=Path, default=Path('sensitivity'))
    parser.add_argument('--seed', type=int, required=True, help='of all that is drawn')
    parser.add_argument('--only', default='', help='numbers whose name holds this text')
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)

    def kept(name: str, settings: DiagnosisSettings | None = None) -> list[Any]:
        file = given.out / f'{name}.json'
        if not file.is_file():
            file.write_text(json.dumps(answers(given.seed, settings)))
        loaded: list[Any] = json.loads(file.read_text())
        return loaded

    base = kept('as it is')
    print(row_of('as it is', base, [base]), flush=True)
    for number in chosen_numbers():
        if given.only not in number.label:
            continue
        found = []
        for factor in FACTORS:
            with changed(number, factor) as settings:
                found.append(kept(f'{number.label} x {factor:g}', settings))
        print(row_of(f'{number.label} = {number.value}', base, found), flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
