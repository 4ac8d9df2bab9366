# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The page of a simulated recording."""

from html import escape

from sosml_friction.report.common.figure import pictures
from sosml_friction.report.common.html_page import heading, notes_box, page, result_box
from sosml_friction.report.common.table import html_table
from sosml_friction.report.figures.simulation.simulated_joint import SimulatedJoint
from sosml_friction.report.simulation.rows import COLUMNS, error_rows, simulation_sentences
from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation


def render_simulation(found: RecordedSimulation, title: str) -> str:
    """Return the report as one HTML document, pictures included."""
    parts = [
        result_box(simulation_sentences(found)),
        notes_box(found.remarks),
        heading('Error of the simulation'),
        html_table(COLUMNS, error_rows(found)),
    ]
    for i, name in enumerate(found.names):
        shown = pictures('simulation', SimulatedJoint(found, i))
        parts += [heading(name), shown or f'<p>{escape(name)} moves as recorded.</p>']
    return page(title, parts)
