# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of the campaign, in Markdown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from statistics import median
from typing import Any

from validation.bars import Bar, cut_of, level, said_cut
from validation.sizes import sizes_table

Row = dict[str, Any]
LEVELS = {'high': 'SNR >= 0.6', 'middle': '0.35 to 0.6', 'low': '< 0.35'}


def group(row: Row) -> str:
    """Return right, set, none, unknown structure, wrong joint or wrong name: for the tables."""
    outcome = row['outcome']
    return {
        'nothing': 'none', 'unknown': 'unknown structure', 'bad_data': 'none', 'failed': 'none',
        'false alarm': 'wrong name', 'single name': 'wrong name',
    }.get(outcome, outcome)  # fmt: skip


def tables(rows: Iterable[Row], bars: Iterable[Bar], seed: int, trials: int) -> str:
    """Return campaign.md."""
    rows = list(rows)
    cost = sum(row.get('cpu_s', 0.0) for row in rows)
    made = sum(row.get('generator_cpu_s', 0.0) for row in rows)
    parts = [
        f'# Blind campaign, seed {seed}\n',
        f'{len(rows)} trials, {cost / 60.0:.0f} min of processor time for the diagnoses, start '
        f'of the process included, and {made / 60.0:.0f} min for the plant.\n',
        'SNR is the root mean square of what the effect adds to the residual of the exact '
        'nominal over that of the noise, in the band that the diagnosis used, in the joint of '
        'the effect (of the whole robot: the larger), its mean included. Every nominal parameter '
        'is 1 to 3 % off besides. Right: the first name and its joint, without rivals; backlash '
        'and elasticity are one class. Set: the truth among several. None: nothing above the '
        'floor. Intervals are of 95 % (Clopper and Pearson).\n',
        '## Bars\n',
        _bars(bars),
    ]
    singles = [row for row in rows if row['kind'] == 'single' and row['truths']]
    if singles:
        parts += ['\n## Single effects by SNR\n', _by(singles, _level_name, 'SNR')]
        for name, title in LEVELS.items():
            part = [row for row in singles if level(row) == name]
            if part:
                parts += [f'\n## Single effects, {title}\n', _by(part, _effect, 'effect')]
        parts += ['\n## Size and what became of it\n', _sizes(singles)]
        parts += ['\n## Sizes of right names\n', sizes_table(singles)]
    for kind, title, key in (
        ('null', 'Nothing hidden', _null),
        ('outside', 'Outside the library', _effect),
        ('twin', 'Twins', _effect),
        ('double', 'Two effects: how many of them were found', lambda row: 'pairs'),
        ('thermal', 'Thermal drift', _effect),
        ('fault', 'Faults of the data', _effect),
    ):
        part = [row for row in rows if row['kind'] == kind]
        if part:
            parts += [f'\n## {title}\n', _by(part, key, kind)]
    moved = [
        row for row in rows
        if row['kind'] == 'excitation' or (row['kind'] == 'single' and level(row) == 'high')
    ]  # fmt: skip
    if any(row['kind'] == 'excitation' for row in rows):
        parts += [
            '\n## By excitation, sizes that are SNR >= 0.6 in the rich one\n',
            _by(moved, lambda row: row['spec']['motion'], 'motion'),
        ]
    gains = [row for row in rows if row.get('held_out')]
    if gains:
        parts += ['\n## Gain on another recording, right names\n', _gains(gains)]
    mutants = [row for row in rows if row['kind'] == 'mutant']
    if mutants:
        parts += ['\n## Without one effect, the trial that was right\n', _list(mutants)]
    poor = [row for row in rows if row['kind'] != 'mutant' and row['score'] <= 0]
    if poor:
        parts += ['\n## Every trial that was not right\n', _list(poor)]
    return '\n'.join(parts) + '\n'


def _bars(bars: Iterable[Bar]) -> str:
    lines = ['| bar | met | n | value | counts |', '|---|---|---|---|---|']
    for bar in bars:
        met = 'yes' if bar.met else ('no trials' if bar.n == 0 else '**no**')
        lines.append(f'| {bar.demand} | {met} | {bar.n} | {bar.value:.3g} | {bar.text} |')
    return '\n'.join(lines)


def _by(rows: list[Row], key: Callable[[Row], str], name: str) -> str:
    """Return counts of each outcome by a key, and of spurious further names."""
    outcomes = [o for o, _ in Counter(group(row) for row in rows).most_common()]
    lines = [
        f'| {name} | n | {" | ".join(outcomes)} | spurious names a run |',
        '|---' * (len(outcomes) + 3) + '|',
    ]
    keys = sorted({key(row) for row in rows})
    for k in [*keys, *(['all'] if len(keys) > 1 else [])]:
        part = [row for row in rows if k == 'all' or key(row) == k]
        count = Counter(group(row) for row in part)
        more = sum(_further(row) for row in part) / len(part)
        cells = ' | '.join(str(count[o]) for o in outcomes)
        lines.append(f'| {k} | {len(part)} | {cells} | {more:.2f} |')
    return '\n'.join(lines)


def _further(row: Row) -> int:
    """Return the names that are no truth, but for a first one, which is counted as wrong."""
    first = row['kind'] != 'double' and row['score'] < 0
    return max(row.get('spurious', 0) - int(first), 0)


def _sizes(rows: list[Row]) -> str:
    lines = [
        '| effect | joint | sizes right | sizes set or none | sizes wrong |',
        '|---|---|---|---|---|',
    ]
    keys = sorted(
        {(r['truths'][0]['effect'], r['truths'][0]['joint']) for r in rows if r['truths']}
    )
    for effect, joint in keys:
        part = [
            row for row in rows
            if row['truths'] and (row['truths'][0]['effect'], row['truths'][0]['joint'])
            == (effect, joint)
        ]  # fmt: skip
        cells = [
            ', '.join(
                f'{r["truths"][0]["size"]:.3g}'
                for r in sorted(part, key=lambda r: r['truths'][0]['size'])
                if r['score'] == score
            )
            for score in (1, 0, -1)
        ]
        lines.append(f'| {effect} | {joint} | {" | ".join(cells)} |')
    return '\n'.join(lines)


def _gains(rows: list[Row]) -> str:
    lines = [
        '| trial | effect | SNR | joint | error before, after, of the true model [Nm] | cut of '
        'the excess | gain, of the true model | forward after / before |',
        '|---|---|---|---|---|---|---|---|',
    ]
    for row in sorted(rows, key=_effect):
        g = row['held_out']
        cut = said_cut(cut_of(g))
        lines.append(
            f'| {row["spec"]["name"]} | {_effect(row)} | {row["snr"]:.2f} | {g["joint"]} | '
            f'{g["before"]:.4f}, {g["after"]:.4f}, {g["true"]:.4f} | {cut} | {g["gain"]:.2f}, '
            f'{g["true_gain"]:.2f} | {g["forward"]:.2f} |'
        )
    cuts = [cut_of(row['held_out']) for row in rows]
    lines.append(f'\nMedian cut {said_cut(median(cuts))}, of {len(cuts)} trials.')
    return '\n'.join(lines)


def _list(rows: list[Row]) -> str:
    lines = ['| trial | seed | hidden | SNR | verdict | answer | outcome |', '|---' * 7 + '|']
    for row in rows:
        hidden = ' + '.join(f'{t["effect"]} {t["joint"]} {t["size"]:.3g}' for t in row['truths'])
        answer = ', '.join(
            f'{c["effect"]} {c["joint"]}' + (f' or {"/".join(c["rivals"])}' if c['rivals'] else '')
            for c in row['causes']
        )
        snr = '' if row.get('snr') is None else f'{row["snr"]:.2f}'
        if not hidden:
            hidden = 'nothing' if row['kind'] == 'null' else '-'
        lines.append(
            f'| {row["spec"]["name"]} | {row["spec"]["seed"]} | {hidden} | {snr} | '
            f'{row["verdict"]} | {answer or "-"} | {row["outcome"]} |'
        )
    return '\n'.join(lines)


def _effect(row: Row) -> str:
    return row['truths'][0]['effect'] if row['truths'] else 'nothing'


def _level_name(row: Row) -> str:
    found = level(row)
    return 'none' if found is None else LEVELS[found]


def _null(row: Row) -> str:
    spec = row['spec']
    kind = 'shuffled blocks' if spec['shuffled'] else f'{spec["noise"]} noise'
    if spec['nuisance'][0] == spec['nuisance'][1]:
        kind = 'all 3 % off'
    return f'{spec["motion"]}, {kind}'
