# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The windows of steady motion as rows: of a table, of a file, of a figure's marks."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from io import StringIO

import numpy as np
from numpy.typing import NDArray

from sosml_friction.identification.output_error.fits import OUTPUT_ERROR
from sosml_friction.report.common.html_page import number_cell
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.number_text import format_number
from sosml_friction.report.fit.joint_view import JointView

FloatArray = NDArray[np.float64]

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
    spreads = {observer: level_spreads(view, observer) for observer in _with_levels(view)}
    rows = []
    for k, segment in enumerate(view.segments):
        levels = {observer: float(view.fits[observer].levels[k]) for observer in spreads}
        reason = segment.rejected
        if not reason and not any(np.isfinite(list(levels.values()))):
            reason = NOT_STARTED
        rows.append(
            SegmentRow(
                k + 1,
                segment.start_s,
                segment.end_s,
                segment.velocity,
                levels,
                {observer: float(values[k]) for observer, values in spreads.items()},
                reason,
            )
        )
    return rows


def _with_levels(view: JointView) -> list[str]:
    """Return the fits that levels say something of: forward simulation has none."""
    return [o for o, fit in view.fits.items() if fit.method != OUTPUT_ERROR]


def level_spreads(view: JointView, observer: str) -> FloatArray:
    """Return the standard deviation of an estimate within each window, (K,) [Nm or N]."""
    spreads = np.full(len(view.segments), np.nan)
    tau_f = view.estimates[observer]
    for k, segment in enumerate(view.segments):
        inside = tau_f[segment.first : segment.last + 1]
        known = inside[np.isfinite(inside)]
        if len(known) > 1:
            spreads[k] = np.std(known)
    return spreads


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
    head = ''.join(
        f'<th class="n l">level {escape(observer_label(observer))} [{view.effort_unit}]</th>'
        '<th class="n">spread</th>'
        for observer in _with_levels(view)
    )
    body = []
    for row in rows:
        cells = (
            number_cell(str(row.number))
            + number_cell(f'{row.start_s:.2f}')
            + number_cell(f'{row.end_s:.2f}')
            + number_cell(format_number(row.velocity))
        )
        for observer, level in row.levels.items():
            spread = row.spreads[observer]
            cells += number_cell(format_number(level, 0.1 * spread), 'n l')
            cells += number_cell(format_number(spread, 0.1 * spread))
        style = ' class="no"' if row.reason else ''
        body.append(f'<tr{style}>{cells}<td class="l">{escape(row.reason) or "used"}</td></tr>')
    table = (
        '<div class="wide"><table><thead><tr><th class="n">window</th><th class="n">start [s]</th>'
        f'<th class="n">end [s]</th><th class="n">velocity [{view.velocity_unit}]</th>{head}'
        '<th class="l">used, or why not</th></tr></thead>'
        f'<tbody>{"".join(body)}</tbody></table></div>'
    )
    used = sum(not row.reason for row in rows)
    text = f'{used} of {len(rows)} windows of steady motion are used.'
    if len(rows) > _OPEN_ROWS:
        return f'<details><summary>{text}</summary>{table}</details>'
    return f'<p>{text}</p>{table}'


def segments_csv(views: Mapping[str, Sequence[JointView]]) -> str:
    """
    Return the windows of all joints and recordings as CSV with a heading, UTF-8, for spreadsheets.

    One row per window. Level and spread of an observer that did not run for a joint are empty, as
    is all that is not known.

    :param views: the joints of each recording, by its name.
    """
    joints = [(bag, view) for bag, some in views.items() for view in some]
    observers = list(dict.fromkeys(o for _, view in joints for o in _with_levels(view)))
    stream = StringIO()
    writer = csv.writer(stream, lineterminator='\n')
    writer.writerow(
        ['recording', 'joint', 'window', 'start_s', 'end_s', 'velocity', 'velocity_unit']
        + [f'{what}_{observer}' for observer in observers for what in ('level', 'spread')]
        + ['effort_unit', 'used', 'reason']
    )
    for bag, view in joints:
        for row in segment_rows(view):
            numbers = [
                _plain(values.get(observer, np.nan))
                for observer in observers
                for values in (row.levels, row.spreads)
            ]
            writer.writerow(
                (
                    bag,
                    view.name,
                    row.number,
                    f'{row.start_s:.4f}',
                    f'{row.end_s:.4f}',
                    _plain(row.velocity),
                    view.velocity_unit,
                    *numbers,
                    view.effort_unit,
                    'no' if row.reason else 'yes',
                    row.reason,
                )
            )
    return stream.getvalue()


def _plain(value: float) -> str:
    return f'{value:.7g}' if np.isfinite(value) else ''
