# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What was found in each recording of a fleet, as rows of one table."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.number_text import format_number, plus_minus
from sosml_friction.identification.several.drift import Drift, drift_of
from sosml_friction.report.common.labels import recorded_at
from sosml_friction.report.common.output import csv_text
from sosml_friction.report.common.table import Column

FORMAT = 'sosml_friction/fleet/1'
COLUMNS = (
    'robot', 'joint', 'recording', 'date', 'quantity', 'value', 'low', 'high', 'std_error',
    'unit', 'told',
)  # fmt: skip


class FleetRow(NamedTuple):
    """
    Hold one number of one recording, or why there is none.

    ``low`` and ``high`` [unit]: its 95 % interval; ``told``: flags, a verdict, or a reason.
    """

    robot: str
    joint: str
    recording: str
    start_ns: int | None
    quantity: str
    value: float | None = None
    low: float | None = None
    high: float | None = None
    std_error: float | None = None
    unit: str = ''
    told: str = ''

    @property
    def date(self) -> str:
        """Return when the recording began, UTC; empty where that is not known."""
        when = recorded_at(self.start_ns)
        return '' if when is None else when.isoformat(timespec='seconds')

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings, with the date in the place of its nanoseconds."""
        row = self._replace(start_ns=None)._asdict()
        return {name: self.date if name == 'date' else row[name] for name in COLUMNS}


def failed_row(recording: str, why: str) -> FleetRow:
    """Return the row of a recording of which nothing was found."""
    return FleetRow('', '', recording, None, 'failed', told=why)


def fit_rows(recording: str, robot: str, document: Mapping[str, Any]) -> list[FleetRow]:
    """Return a row for each parameter of the fit to use, of the object of ``fit.json``."""
    start = document['bags'][0]['start_ns']
    rows = []
    for joint, fits in document['joints'].items():
        parameters = fits[preferred_observer(fits)]['parameters']
        rows += [_row(robot, joint, recording, start, *item) for item in parameters.items()]
    for joint, why in document['unavailable'].items():
        if joint not in document['joints']:
            rows.append(FleetRow(robot, joint, recording, start, 'friction', told=why))
    return rows


def term_rows(recording: str, robot: str, document: Mapping[str, Any]) -> list[FleetRow]:
    """Return a row for each parameter of fitted terms, of the object of ``fit.json``."""
    start = document['provenance']['bags'][0].get('start_ns')
    rows = []
    for term in document['terms']:
        for name, parameter in term['parameters'].items():
            quantity = _quantity(term['term'], name)
            rows.append(_row(robot, term['joint'], recording, start, quantity, parameter))
    for place, why in document['left_out'].items():
        term, _, joint = place.partition('@')
        rows.append(FleetRow(robot, joint, recording, start, term, told=why))
    return rows


def diagnosis_rows(recording: str, robot: str, document: Mapping[str, Any]) -> list[FleetRow]:
    """Return a row for the verdict and each cause, of the object of ``diagnosis.json``."""
    start = document['provenance']['bags'][0]['start_ns']
    told = f'{document["verdict"]}: {document["sentence"]}'
    rows = [FleetRow(robot, '', recording, start, 'verdict', told=told)]
    for cause in document['causes']:
        for name, parameter in cause['parameters'].items():
            quantity = _quantity(cause['effect'], name)
            rows.append(_row(robot, cause['joint'], recording, start, quantity, parameter))
    return rows


def _quantity(effect: str, parameter: str) -> str:
    return parameter if parameter.startswith(effect) else f'{effect} {parameter}'


def _row(
    robot: str, joint: str, recording: str, start: int | None, name: str, p: Mapping[str, Any]
) -> FleetRow:
    low, high = p.get('interval') or (None, None)
    told = ', '.join(p.get('flags', ())).replace('_', ' ')
    return FleetRow(
        robot, joint, recording, start, name, p['value'], low, high, p['std_error'],
        p.get('unit', ''), told,
    )  # fmt: skip


def drifts(rows: Iterable[FleetRow]) -> dict[tuple[str, str, str, str], Drift]:
    """Return the drift of each robot, joint, quantity and unit that three recordings tell."""
    series: dict[tuple[str, str, str, str], list[FleetRow]] = {}
    for row in rows:
        if row.value is not None and row.std_error is not None and row.date:
            series.setdefault((row.robot, row.joint, row.quantity, row.unit), []).append(row)
    found = {}
    for key, own in series.items():
        columns = np.array([(r.start_ns, r.value, r.std_error) for r in own], dtype=np.float64)
        drift = drift_of(*columns.T)
        if drift is not None:
            found[key] = drift
    return found


def rows_csv(rows: Sequence[FleetRow]) -> str:
    """Return the rows as CSV with a header."""
    return csv_text(COLUMNS, (row.to_dict().values() for row in rows))


#: Columns of the terminal's table.
SHOWN = (
    Column('quantity', 'w'),
    Column('date', 'w'),
    Column('recording'),
    Column('value', 'nw'),
    Column('unit', 'w'),
)


def joint_tables(rows: Iterable[FleetRow]) -> dict[tuple[str, str], list[list[str]]]:
    """Return the lines of each robot and joint: of each quantity one a recording, by date."""
    tables: dict[tuple[str, str], list[list[str]]] = {}
    last = ''
    for row in sorted(rows, key=lambda x: (x.robot, x.joint, x.quantity, x.date, x.recording)):
        if row.quantity != 'failed':
            lines = tables.setdefault((row.robot, row.joint), [])
            told = row.quantity.replace('_', ' ')
            new = told != last or not lines
            last = told
            date = row.date[:10] or 'no date'
            cells = [told if new else '', date, row.recording, _short(row), row.unit]
            lines.append(cells)
    return tables


def _short(row: FleetRow) -> str:
    """Return a value and half of its interval, its interval alone, or what is told of it."""
    if row.value is not None and row.low is not None and row.high is not None:
        return plus_minus(row.value, 0.5 * (row.high - row.low))
    if row.value is not None:
        return format_number(row.value)
    if row.low is not None:
        return f'{row.low:.3g} to {"open" if row.high is None else f"{row.high:.3g}"}'
    return row.told.partition(':')[0]
