# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The study's tables for the terminal."""

import math
from collections.abc import Sequence

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from sosml_friction.identification.number_text import UNKNOWN
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.table import Column, terminal_table
from sosml_friction.report.study.view import case_text, findings
from sosml_friction.study.metrics import Score
from sosml_friction.study.run import Study, rmse_mean
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case


def study_tables(study: Study) -> RenderableType:
    """Return what is read first: RMSE of both joints, then noise, settling and loop width."""
    cases = list(study.observations)
    noisy = [case for case in cases if case[1] == 'noise']
    parts: list[RenderableType] = []
    for joint, name in enumerate(study.joints):
        parts += [
            Text(f'RMSE [mNm] of the {name}, each observer tuned for each case {_spread(study)}'),
            _rmse_table(study, joint, cases, 'case'),
        ]
    if len(noisy) > 1:
        parts += [
            Text(f'RMSE [mNm] of the {study.joints[0]}, one gain set per observer, tuned for both '
                 'noisy motions at once'),
            _rmse_table(study, 0, cases, 'shared'),
        ]  # fmt: skip
    if noisy:
        parts += [
            Text(f'With noise, {study.joints[0]}, tuned for each case: std of the noise [mNm], '
                 'time until settled to 10 % after a reversal [ms], loop width at zero velocity '
                 '[mNm]'),
            _dynamics_table(study, noisy),
        ]  # fmt: skip
    parts.append(Text('\n'.join([*findings(study), _legend(study)])))
    return Group(*parts)


def _legend(study: Study) -> str:
    """Return what the names and dashes of the tables mean, of those that are there."""
    words = [
        f'{variant.label}: {variant.space.remark}.'
        for name, variant in study_variants().items()
        if name in study.settings.observers and variant.space.remark
    ]
    if any(case[1] == 'mismatch' for case in study.observations):
        words.append('Offset floor: what an ideal observer has with that wrong model.')
    words.append('-: not known, or not settled before the next reversal.')
    return ' '.join(words)


def rmse_text(condition: str, score: Score) -> str:
    """Return the mean RMSE [mNm], with the standard deviation over seeds where there are some."""
    mean = 1e3 * rmse_mean(condition, score)
    if not mean < 1e6:
        return UNKNOWN
    text = short(mean)
    if condition == 'noise' and len(score.rmse) > 1:
        text += f' ({1e3 * float(np.std(score.rmse, ddof=1)):.1f})'
    return text


def short(value: float) -> str:
    """Return a number of a table, three digits or one decimal; a dash for what is not known."""
    if not math.isfinite(value):
        return UNKNOWN
    return f'{value:.2f}' if abs(value) < 10.0 else f'{value:.1f}'


def settle_text(score: Score) -> str:
    """Return the settle time in ms."""
    return f'{1e3 * score.settle_s:.0f}' if math.isfinite(score.settle_s) else UNKNOWN


def _spread(study: Study) -> str:
    n = study.settings.seeds
    return f'(with noise: mean, in brackets std, over {n} seeds)' if n > 1 else '(one noise seed)'


def _rmse_table(study: Study, joint: int, cases: Sequence[Case], tuning: str) -> Table:
    heads = ['observer', *(case_text(case).replace(', ', '\n') for case in cases)]
    rows = []
    for name in study.settings.observers:
        cells = [rmse_text(case[1], study.row(case, name, tuning).scores[joint]) for case in cases]
        rows.append([observer_label(name), *cells])
    if any(case[1] == 'mismatch' for case in cases):
        floors = [
            short(1e3 * float(study.floors[case][joint])) if case[1] == 'mismatch' else ''
            for case in cases
        ]
        rows.append(['offset floor', *floors])
    return _table(heads, rows)


def _dynamics_table(study: Study, cases: Sequence[Case]) -> Table:
    heads = [f'{case[0]}\n{what}' for case in cases for what in ('noise', 'settle', 'width')]
    rows = []
    for name in study.settings.observers:
        row = [observer_label(name)]
        for score in (study.row(case, name).scores[0] for case in cases):
            row += [short(1e3 * score.noise_std), settle_text(score)]
            row.append(short(1e3 * score.loop_width))
        rows.append(row)
    return _table(['observer', *heads], rows)


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    columns = [Column(head, 'n w' if k else 'w') for k, head in enumerate(heads)]
    return terminal_table(columns, rows)
