# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The page of a simulated recording."""

from __future__ import annotations

from html import escape

from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.html_page import page, picture, table
from sosml_friction.report.simulation.figure import simulation_figure
from sosml_friction.report.simulation.rows import error_rows, simulation_sentences
from sosml_friction.simulation.recorded.recorded_simulation import CLOSED_LOOP, RecordedSimulation


def render_simulation(found: RecordedSimulation, title: str) -> str:
    """Return the report as one HTML document, pictures included."""
    sentences = simulation_sentences(found)
    result = ''.join(f'<p>{escape(text)}</p>' for text in sentences)
    notes = ''.join(f'<li>{escape(text)}</li>' for text in found.remarks)
    parts = [
        f'<h1>{escape(title)}</h1>',
        f'<div class="result">{result}</div>',
        f'<div class="note"><ul>{notes}</ul></div>' if notes else '',
        _table(found),
    ]
    for i, name in enumerate(found.names):
        caption = f'{name}: measured, and simulated; to the right their difference'
        if found.mode != CLOSED_LOOP:
            caption += '; each window begins anew where the error of position is 0'
        parts.append(f'<h2>{escape(name)}</h2>')
        if name in found.followed and found.mode == CLOSED_LOOP:
            parts.append(f'<p>{escape(name)} moves as recorded.</p>')
            continue
        parts.append(picture(to_png(simulation_figure(found, i)), caption))
    return page(title, parts)


def _table(found: RecordedSimulation) -> str:
    columns = {
        'joint': '', 'quantity': '', 'root mean square': 'n', 'largest': 'n', 'unit': '',
        'relative': 'n',
    }  # fmt: skip
    return '<h2>Error of the simulation</h2>' + table(columns, error_rows(found))
