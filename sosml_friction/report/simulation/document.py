# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated recording as files: ``simulation.json`` and the report."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.common.output import (
    OutputKind,
    to_plain,
    write_result,
    written_together,
)
from sosml_friction.report.simulation.html import render_simulation
from sosml_friction.report.simulation.rows import simulation_sentences
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
