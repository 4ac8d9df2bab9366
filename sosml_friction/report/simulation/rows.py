# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The errors of a simulated recording as text: rows of a table, and sentences."""

import numpy as np
from rich.table import Table

from sosml_friction.report.common.number_text import UNKNOWN, format_number
from sosml_friction.report.common.table import terminal_table
from sosml_friction.simulation.recorded.recorded_simulation import CLOSED_LOOP, RecordedSimulation

COLUMNS = {'joint': 'w', 'error of': 'w', 'root mean square': 'n', 'largest': 'n', 'unit': 'w',
           'relative': 'n'}  # fmt: skip
_SMALL = {'rad': 'mrad', 'm': 'mm', 'rad/s': 'mrad/s', 'm/s': 'mm/s'}


def error_rows(found: RecordedSimulation) -> list[tuple[str, ...]]:
    """Return a row of texts for each joint and quantity; lengths are in thousandths."""
    rows: list[tuple[str, ...]] = []
    for name in found.names:
        for k, (what, error) in enumerate(found.errors[name].items()):
            factor = 1e3 if error.unit in _SMALL else 1.0
            numbers = (format_number(factor * error.rms), format_number(factor * error.largest))
            unit = _SMALL.get(error.unit, error.unit)
            rows.append(('' if k else name, what, *numbers, unit, percent_text(error.relative)))
    return rows


def percent_text(share: float) -> str:
    """Return a share [%] to three digits, and without a power of ten."""
    if not np.isfinite(share):
        return UNKNOWN
    digits = 2 if share <= 0.0 else max(0, 2 - int(np.floor(np.log10(share))))
    return f'{share:.{min(digits, 6)}f} %'


def error_table(found: RecordedSimulation) -> Table:
    """Return the table of the terminal."""
    return terminal_table(COLUMNS, error_rows(found))


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
