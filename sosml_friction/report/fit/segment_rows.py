# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The windows of steady motion as rows: of a table, of a file, of a figure's marks."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sosml_friction.identification.law_residual import level_spreads
from sosml_friction.identification.number_text import format_number
from sosml_friction.identification.output_error.fits import OUTPUT_ERROR
from sosml_friction.report.common.html_page import folded
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.output import csv_text
from sosml_friction.report.common.table import Column, html_table
from sosml_friction.report.fit.joint_view import JointView

#: What a window is not used for where its observer, not its motion, is the reason.
NOT_STARTED = 'the observer had not started'
#: A longer table is folded.
_OPEN_ROWS = 60


@dataclass(frozen=True)
class SegmentRow:
    """
    Hold what is known of one window of one joint.

    ``number`` counts the windows of the joint from 1 in the order of time, as the marks of the
    figures do. ``levels`` and ``spreads`` [Nm or N] are by observer: the level that the fit takes,
    and the standard deviation of the estimate within the window; NaN where there is none.
    ``reason`` is empty for a window that is used.
    """

    number: int
    start_s: float
    end_s: float
    velocity: float
    levels: Mapping[str, float]
    spreads: Mapping[str, float]
    reason: str


def segment_rows(view: JointView) -> list[SegmentRow]:
    """Return the windows of a joint, used or not, in the order of time."""
    spreads = {o: level_spreads(view.segments, view.estimates[o]) for o in _with_levels(view)}
    rows = []
    for k, segment in enumerate(view.segments):
        levels = {observer: float(view.fits[observer].levels[k]) for observer in spreads}
        reason = segment.rejected
        if not reason and not any(map(math.isfinite, levels.values())):
            reason = NOT_STARTED
        spread = {observer: float(values[k]) for observer, values in spreads.items()}
        times = (segment.start_s, segment.end_s)
        rows.append(SegmentRow(k + 1, *times, segment.velocity, levels, spread, reason))
    return rows


def _with_levels(view: JointView) -> list[str]:
    """Return the fits that levels say something of: forward simulation has none."""
    return [o for o, fit in view.fits.items() if fit.method != OUTPUT_ERROR]


def rejected_groups(rows: Sequence[SegmentRow]) -> dict[str, list[SegmentRow]]:
    """Return the windows not used by reason, reasons that differ in numbers only as one."""
    groups: dict[str, list[SegmentRow]] = {}
    for row in rows:
        if row.reason:
            groups.setdefault(re.sub(r'\d+(\.\d+)?', '#', row.reason), []).append(row)
    named = {}
    for pattern, members in groups.items():
        numbers = [re.findall(r'\d+(?:\.\d+)?', member.reason) for member in members]
        reason = pattern
        for column in zip(*numbers, strict=True):
            low, high = min(column, key=float), max(column, key=float)
            reason = reason.replace('#', low if low == high else f'{low} to {high}', 1)
        named[reason] = members
    return named


def segment_table(view: JointView) -> str:
    """Return every window as a row of an HTML table, a long one folded; the numbers are marks."""
    rows = segment_rows(view)
    columns = [Column(head, 'n') for head in ('window', 'start [s]', 'end [s]')]
    columns.append(Column(f'velocity [{view.velocity_unit}]', 'n'))
    for observer in _with_levels(view):
        head = f'level {observer_label(observer)} [{view.effort_unit}]'
        columns += [Column(head, 'n l'), Column('spread', 'n')]
    columns.append(Column('used, or why not', 'l'))
    cells = []
    for row in rows:
        texts = [str(row.number), f'{row.start_s:.2f}', f'{row.end_s:.2f}']
        texts.append(format_number(row.velocity))
        for observer, level in row.levels.items():
            digits = 0.1 * row.spreads[observer]
            texts += [format_number(level, digits), format_number(row.spreads[observer], digits)]
        cells.append([*texts, row.reason or 'used'])
    table = html_table(columns, cells, dim=[k for k, row in enumerate(rows) if row.reason])
    used = sum(not row.reason for row in rows)
    text = f'{used} of {len(rows)} windows of steady motion are used.'
    return folded(text, table) if len(rows) > _OPEN_ROWS else f'<p>{text}</p>{table}'


def segments_csv(views: Mapping[str, Sequence[JointView]]) -> str:
    """
    Return the windows of all joints and recordings as CSV with a heading, UTF-8, for spreadsheets.

    One row per window. Level and spread of an observer that did not run for a joint are empty, as
    is all that is not known.
    """
    joints = [(bag, view) for bag, some in views.items() for view in some]
    observers = list(dict.fromkeys(o for _, view in joints for o in _with_levels(view)))
    head = [
        *('recording', 'joint', 'window', 'start_s', 'end_s', 'velocity', 'velocity_unit'),
        *(f'{what}_{observer}' for observer in observers for what in ('level', 'spread')),
        *('effort_unit', 'used', 'reason'),
    ]
    rows = []
    for bag, view in joints:
        for row in segment_rows(view):
            numbers = [
                values.get(observer)
                for observer in observers
                for values in (row.levels, row.spreads)
            ]
            rows.append(
                [
                    *(bag, view.name, row.number, row.start_s, row.end_s, row.velocity),
                    *(view.velocity_unit, *numbers, view.effort_unit),
                    *('no' if row.reason else 'yes', row.reason),
                ]
            )
    return csv_text(head, rows)
