# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated recording as files: ``simulation.json`` and the report."""

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.common.figure import pictures
from sosml_friction.report.common.html_page import heading, notes_box, page, result_box
from sosml_friction.report.common.output import (
    OutputKind,
    to_plain,
    write_result,
    written_together,
)
from sosml_friction.report.common.table import html_table
from sosml_friction.report.figures.simulation.simulated_joint import SimulatedJoint
from sosml_friction.report.simulation.rows import COLUMNS, error_rows, simulation_sentences
from sosml_friction.simulation.recorded.recorded_simulation import RecordedSimulation

FORMAT = 'sosml_friction/simulation/1'
KIND = OutputKind('simulation', 'simulation.json', FORMAT, ('report.html', 'simulation.json'))


def simulation_document(
    found: RecordedSimulation, model: RobotModelFile, provenance: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the object of ``sosml simulate --json``: docs/schema/simulation.schema.json."""
    document: dict[str, Any] = {
        'format': FORMAT,
        'sentence': simulation_sentences(found)[0],
        'mode': found.mode,
        'why_not_closed_loop': found.why_not,
        'horizon_s': found.horizon_s,
        'samples': len(found.time),
        'steps_per_sample': found.steps,
        'joints': {
            name: {
                'friction_displacement': float(found.displacement[i]),
                'driven': name not in found.followed,
                'errors': {
                    what: {
                        'rms': error.rms,
                        'largest': error.largest,
                        'relative_percent': error.relative,
                        'unit': error.unit,
                    }
                    for what, error in found.errors[name].items()
                },
            }
            for i, name in enumerate(found.names)
        },
        'effects': [{'effect': term.effect, 'joint': term.joint} for term in model.effects],
        'remarks': list(found.remarks),
        'provenance': dict(provenance),
    }
    return to_plain(document)


def write_simulation(
    folder: Path, found: RecordedSimulation, model: RobotModelFile, provenance: Mapping[str, Any]
) -> None:
    """
    Write simulation.json and report.html.

    :raises ConfigurationError: if the folder cannot be written.
    """
    title = f'Simulation of {provenance["bag"]} with {provenance["model"]}'
    with written_together(folder, KIND) as workshop:
        document = simulation_document(found, model, provenance)
        write_result(workshop, KIND, document, render_simulation(found, title))


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
