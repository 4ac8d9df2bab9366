# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The pictures of the campaign: what was taken for what, accuracy by SNR and by excitation."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt
import numpy as np

from validation.bars import interval, level
from validation.judge import named

Row = dict[str, Any]
GROUPS = {
    'right': ('right', '#2b7a4b'), 'set': ('a set with it', '#8fc79a'),
    'none': ('nothing named', '#c9c9c9'), 'wrong': ('wrong name or joint', '#b5382c'),
}  # fmt: skip
EDGES = (0.0, 0.2, 0.35, 0.6, 1.0, 2.0, 4.0, np.inf)


def draw(rows: Iterable[Row], out: Path) -> None:
    """Write confusion.png, accuracy_snr.png and accuracy_excitation.png, where there is data."""
    rows = list(rows)
    singles = [row for row in rows if row['kind'] == 'single' and row['outcome'] != 'failed']
    if singles:
        confusion(rows, out / 'confusion.png')
        by_snr(singles, out / 'accuracy_snr.png')
    if any(row['kind'] == 'excitation' for row in rows):
        by_excitation(rows, out / 'accuracy_excitation.png')


def _group(row: Row) -> str:
    if row['score'] > 0:
        return 'right'
    if row['score'] < 0:
        return 'wrong'
    return 'set' if row['outcome'] == 'set' else 'none'


def _answered(row: Row) -> str:
    causes = named(row)
    if not causes:
        return 'unknown structure' if row['verdict'] == 'unknown_structure' else 'nothing'
    first = causes[0]['effect']
    return 'right name, wrong joint' if row['outcome'] == 'wrong joint' else first


def confusion(rows: list[Row], path: Path) -> None:
    """Draw hidden against answered: singles of SNR >= 0.35, nulls, what is in no catalogue."""
    part = [
        row for row in rows
        if (row['kind'] == 'single' and level(row) in ('high', 'middle'))
        or row['kind'] in ('null', 'outside', 'thermal', 'fault')
    ]  # fmt: skip
    part = [row for row in part if row['outcome'] != 'failed']

    def hidden(row: Row) -> str:
        if row['kind'] == 'null':
            return 'nothing hidden'
        effect = row['truths'][0]['effect']
        return f'outside: {effect}' if row['kind'] == 'outside' else effect

    effects = sorted(
        {hidden(row) for row in part if row['kind'] in ('single', 'thermal', 'fault')}
    )
    outside = sorted({hidden(row) for row in part if row['kind'] == 'outside'})
    lines = [*effects, *outside, *(['nothing hidden'] if any(
        row['kind'] == 'null' for row in part) else [])]  # fmt: skip
    answers = {_answered(row) for row in part}
    last = ('right name, wrong joint', 'unknown structure', 'nothing')
    columns = [*effects, *sorted(answers - set(effects) - set(last)), *last]
    table = np.zeros((len(lines), len(columns)))
    for row in part:
        table[lines.index(hidden(row)), columns.index(_answered(row))] += 1
    shares = table / np.maximum(table.sum(axis=1, keepdims=True), 1.0)
    figure, axes = plt.subplots(figsize=(0.36 * len(columns) + 4.2, 0.3 * len(lines) + 3.4))
    axes.imshow(shares, cmap='Blues', vmin=0.0, vmax=1.0, aspect='auto')
    for i, j in np.argwhere(table > 0):
        axes.text(
            j, i, f'{table[i, j]:.0f}', ha='center', va='center', fontsize=8,
            color='white' if shares[i, j] > 0.6 else 'black',
        )  # fmt: skip
    axes.set_xticks(range(len(columns)), [c.replace('_', ' ') for c in columns], rotation=60,
                    ha='right', fontsize=8)  # fmt: skip
    axes.set_yticks(
        range(len(lines)),
        [f'{name.replace("_", " ")} ({int(table[k].sum())})' for k, name in enumerate(lines)],
        fontsize=8,
    )
    axes.set_xlabel('first name of the answer')
    axes.set_ylabel('hidden (number of trials)')
    axes.set_title('What was taken for what, SNR of 0.35 and more', fontsize=10)
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _bars(groups: list[list[Row]], labels: list[str], title: str, xlabel: str, path: Path) -> None:
    """Draw shares of the outcomes, one stack for each group, with the interval of right."""
    figure, axes = plt.subplots(figsize=(1.1 * len(groups) + 2.8, 4.2))
    place = np.arange(len(groups))
    base = np.zeros(len(groups))
    for key, (text, colour) in GROUPS.items():
        height = np.array([sum(_group(r) == key for r in g) / max(len(g), 1) for g in groups])
        axes.bar(place, height, 0.7, bottom=base, color=colour, label=text)
        base += height
    for x, g in zip(place, groups, strict=True):
        k = sum(_group(r) == 'right' for r in g)
        low, high = interval(k, len(g))
        axes.plot([x, x], [low, high], color='black', linewidth=1.2)
        axes.plot([x - 0.06, x + 0.06, np.nan, x - 0.06, x + 0.06], [low, low, np.nan, high, high],
                  color='black', linewidth=1.2)  # fmt: skip
    axes.set_xticks(place, [f'{t}\nn = {len(g)}' for t, g in zip(labels, groups, strict=True)])
    axes.set_ylim(0.0, 1.0)
    axes.set_ylabel('share of trials (line: 95 % interval of right)')
    axes.set_xlabel(xlabel)
    axes.set_title(title, fontsize=10)
    figure.legend(loc='outside lower center', ncols=4, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 1.0))
    figure.savefig(path, dpi=130)
    plt.close(figure)


def by_snr(rows: list[Row], path: Path) -> None:
    """Draw the outcomes of single effects by SNR."""
    groups, labels = [], []
    for low, high in pairwise(EDGES):
        part = [r for r in rows if r.get('snr') is not None and low <= r['snr'] < high]
        if part:
            groups.append(part)
            labels.append(f'{low:g} to {high:g}' if np.isfinite(high) else f'{low:g} and more')
    _bars(groups, labels, 'Single hidden effects, rich trajectory', 'SNR', path)


def by_excitation(rows: list[Row], path: Path) -> None:
    """Draw the outcomes by motion, for sizes of SNR >= 0.6 in the rich one."""
    part = [
        row for row in rows
        if row['kind'] == 'excitation' or (row['kind'] == 'single' and level(row) == 'high')
    ]  # fmt: skip
    motions = [m for m in ('rich', 'multisine', 'slow') if any(
        row['spec']['motion'] == m for row in part)]  # fmt: skip
    names = {'slow': 'slow ladder'}
    _bars(
        [[r for r in part if r['spec']['motion'] == m] for m in motions],
        [names.get(m, m) for m in motions],
        'Single hidden effects of SNR >= 0.6 in the rich trajectory', 'trajectory', path,
    )  # fmt: skip
