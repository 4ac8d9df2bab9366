# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated recording as files: ``simulation.json`` and the report."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sosml_friction.identification.number_text import UNKNOWN, format_number
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.figure import pictures
from sosml_friction.report.common.html_page import box, facts, heading, page, paragraph, verdict
from sosml_friction.report.common.output import OutputKind, write_result, written_together
from sosml_friction.report.common.table import html_table, terminal_table
from sosml_friction.simulation.recorded.recorded_simulation import CLOSED_LOOP, RecordedSimulation

COLUMNS = {'joint': 'w', 'error of': 'w', 'root mean square': 'n', 'largest': 'n', 'unit': 'w',
           'relative': 'n'}  # fmt: skip
_SMALL = {'rad': 'mrad', 'm': 'mm', 'rad/s': 'mrad/s', 'm/s': 'mm/s'}


class SimulatedJoint(NamedTuple):
    """Hold a simulation, and the number of the joint that is drawn."""

    found: RecordedSimulation
    i: int

    @property
    def name(self) -> str:
        """Return the name of the joint."""
        return self.found.names[self.i]


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


def simulation_blocks(found: RecordedSimulation) -> list[Any]:
    """Return what the terminal shows: sentences, the table of errors, remarks."""
    remarks = [f'{remark}.' for remark in found.remarks]
    return [*simulation_sentences(found), terminal_table(COLUMNS, error_rows(found)), *remarks]


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
                'friction_displacement': found.displacement[i],
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
        'remarks': found.remarks,
        'provenance': provenance,
    }
    return to_plain(document)


def figure_views(found: RecordedSimulation) -> dict[str, object]:
    """Return what the figures draw, by the names that their files begin with."""
    return {name: SimulatedJoint(found, i) for i, name in enumerate(found.names)}


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
        told = {'Recording': str(provenance['bag']), 'Model': str(provenance['model'])}
        write_result(workshop, KIND, document, render_simulation(found, title, told))


def render_simulation(
    found: RecordedSimulation, title: str, told: Mapping[str, str] | None = None
) -> str:
    """Return the report as one HTML document, pictures included."""
    length = f'{float(found.time[-1] - found.time[0]):.1f} s, {len(found.time)} samples'
    label = 'Simulated in closed loop'
    if found.mode != CLOSED_LOOP:
        label = f'Simulated in windows of {found.horizon_s:g} s'
    steps = ['Ask what the model lacks: sosml diagnose RECORDING --model FOLDER.']
    parts = [
        facts({**(told or {}), 'Joints': ', '.join(found.names), 'Length': length}),
        verdict('found', label, simulation_sentences(found)),
        heading('Error of the simulation', 3),
        html_table(COLUMNS, error_rows(found)),
        box('Before you use the numbers', found.remarks),
        box('What to do next', steps, 'next'),
    ]
    for i, name in enumerate(found.names):
        shown = pictures('simulation', SimulatedJoint(found, i))
        parts += [heading(name), shown or paragraph(f'{name} moves as recorded.')]
    return page(title, parts)
