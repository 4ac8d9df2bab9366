# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Trials that are kept, one file each, and how often each answer was given."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

#: Kind, effect ('' for none) and number of a trial.
Plan = Iterable[tuple[str, str, int]]


def parser_of(name: str, text: str | None) -> argparse.ArgumentParser:
    """Return the options of a campaign: where its trials are kept, and how many of each."""
    parser = argparse.ArgumentParser(prog=f'python -m validation.{name}', description=text)
    parser.add_argument('--out', type=Path, default=Path(name))
    parser.add_argument('--seed', type=int, required=True, help='of all that is drawn')
    parser.add_argument('--singles', type=int, default=2, help='trials of each effect')
    parser.add_argument('--nulls', type=int, default=10, help='trials without an effect')
    parser.add_argument('--outside', type=int, default=2, help='trials of each effect outside')
    return parser


def kept_trials(plan: Plan, trial: Callable[[str, str, int], dict[str, Any]], out: Path
                ) -> list[dict[str, Any]]:  # fmt: skip
    """Run the trials whose file is not there yet, and return all that are in ``out``."""
    out.mkdir(parents=True, exist_ok=True)
    for kind, effect, k in plan:
        file = out / f'{kind}-{effect}-{k}.json'
        if not file.is_file():
            row = trial(kind, effect, k)
            file.write_text(json.dumps(row, indent=1))
            print(kind, effect, k, row['outcome'], row.get('causes'), flush=True)
    return [json.loads(path.read_text()) for path in sorted(out.glob('*.json'))]


def outcomes(rows: list[dict[str, Any]]) -> list[str]:
    """Return counts of outcomes by kind and effect, lines of a table."""
    lines = ['| kind | effect | n | outcomes | spurious |', '|---|---|---|---|---|']
    keys = dict.fromkeys((row['kind'], row['effect']) for row in rows)
    for kind in dict.fromkeys(kind for kind, _ in keys):
        effects = [effect for own, effect in keys if own == kind and effect]
        for effect in [*effects, None]:
            own = [r for r in rows if r['kind'] == kind and effect in (None, r['effect'])]
            counts = Counter(row['outcome'] for row in own)
            shown = ', '.join(f'{n} {name}' for name, n in sorted(counts.items()))
            spurious = sum(row.get('spurious') or 0 for row in own)
            lines.append(f'| {kind} | {effect or "all"} | {len(own)} | {shown} | {spurious} |')
    return lines
