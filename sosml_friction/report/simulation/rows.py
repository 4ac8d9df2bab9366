# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The errors of a simulated recording as text: rows of a table, and sentences."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from rich import box
from rich.table import Table

from sosml_friction.report.common.number_text import UNKNOWN, format_number
from sosml_friction.simulation.recorded.recorded_simulation import CLOSED_LOOP, RecordedSimulation


class ErrorRow(NamedTuple):
    """Hold one row of the table, as text."""

    joint: str
    quantity: str
    rms: str
    largest: str
    unit: str
    relative: str


_SMALL = {'rad': 'mrad', 'm': 'mm', 'rad/s': 'mrad/s', 'm/s': 'mm/s'}


def error_rows(found: RecordedSimulation) -> list[ErrorRow]:
    """Return a row for each joint and quantity; lengths are in thousandths."""
    rows = []
    for name in found.names:
        for what, error in found.errors[name].items():
            factor = 1e3 if error.unit in _SMALL else 1.0
            share = percent_text(error.relative)
            rows.append(
                ErrorRow(
                    name,
                    what,
                    format_number(factor * error.rms),
                    format_number(factor * error.largest),
                    _SMALL.get(error.unit, error.unit),
                    share,
                )
            )
    return rows


def percent_text(share: float) -> str:
    """Return a share [%] to three digits, and without a power of ten."""
    if not np.isfinite(share):
        return UNKNOWN
    digits = 2 if share <= 0.0 else max(0, 2 - int(np.floor(np.log10(share))))
    return f'{share:.{min(digits, 6)}f} %'


def error_table(found: RecordedSimulation) -> Table:
    """Return the table of the terminal."""
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ('joint', 'error of'):
        table.add_column(heading, no_wrap=True)
    for heading in ('root mean square', 'largest'):
        table.add_column(heading, justify='right')
    table.add_column('unit', no_wrap=True)
    table.add_column('relative', justify='right')
    last = ''
    for row in error_rows(found):
        table.add_row(row.joint if row.joint != last else '', *row[1:])
        last = row.joint
    return table


def simulation_sentences(found: RecordedSimulation) -> list[str]:
    """Return what was simulated, how well it follows, and how to read the numbers."""
    told = []
    for name in found.names:
        errors = found.errors[name]
        if not np.isfinite(errors['position'].rms):
            continue
        unit = _SMALL[errors['position'].unit]
        told.append(
            f'{name}: position {format_number(1e3 * errors["position"].rms)} {unit} '
            f'({percent_text(errors["position"].relative)}), effort '
            f'{format_number(errors["effort"].rms)} {errors["effort"].unit} '
            f'({percent_text(errors["effort"].relative)})'
        )
    numbers = '; '.join(told) + '.'
    if found.mode == CLOSED_LOOP:
        return [
            f'Simulated in closed loop, with the recorded controller and wanted position, from '
            f'the first sample to the last. Error of {numbers}'
        ]
    why = '' if found.why_not == 'windows were asked for' else f', because {found.why_not}'
    return [
        f'Simulated in windows of {found.horizon_s:g} s, each from the measured state and driven '
        f'by the measured effort{why}. Error of {numbers}',
        'A relative error of position is a share of the way since the window began; the error of '
        'effort is that of what the model needs for the measured motion, both low-passed.',
    ]
