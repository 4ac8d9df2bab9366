# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as files: ``diagnosis.json``, the extended model, the report."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.diagnosis.residual.joint_residual import joint_residuals
from sosml_friction.diagnosis.wording import gain_line
from sosml_friction.identification.number_text import words
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.output import OutputKind, write_result, written_together
from sosml_friction.report.diagnosis.html import rejection, render_diagnosis

FORMAT = 'sosml_friction/diagnosis/1'
_FILES = ('robot.urdf', 'robot.xml', 'model.yaml', 'report.html', 'diagnosis.json')
KIND = OutputKind('diagnosis', 'diagnosis.json', FORMAT, _FILES)


def diagnosis_document(diagnosis: Diagnosis, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the object of ``sosml diagnose --json``: docs/schema/diagnosis.schema.json."""
    gain = diagnosis.gain
    document: dict[str, Any] = {
        'format': FORMAT,
        'verdict': diagnosis.verdict,
        'sentence': diagnosis.sentence,
        'causes': diagnosis.causes,
        'gain': None if gain is None else gain.to_dict(diagnosis.names, diagnosis.units),
        'stages': diagnosis.stages,
        'recommended_experiment': diagnosis.recommendation,
        'data_checks': diagnosis.checks,
        'ranking': diagnosis.ranking,
        'rejected': diagnosis.rejected,
        'structure': diagnosis.structure,
        'refit': diagnosis.refit,
        'tolerated': diagnosis.tolerated,
        'confusability': diagnosis.confusability,
        'band_hz': diagnosis.band_hz,
        'library_hash': diagnosis.library_hash,
        'provenance': provenance,
    }
    if diagnosis.simulator is not None:
        document['simulator'] = diagnosis.simulator
    return to_plain(document)


def write_diagnosis(
    folder: Path,
    diagnosis: Diagnosis,
    model: RobotModelFile,
    provenance: Mapping[str, Any],
    step: Callable[[str], None] = lambda text: None,
) -> None:
    """
    Write diagnosis.json, report.html, and the extended model where a term is in it.

    Of a simulator's model always, in its own form as well.

    :raises ConfigurationError: if the folder cannot be written.
    """
    with written_together(folder, KIND) as workshop:
        simulator = diagnosis.simulator
        if simulator is not None:
            (workshop / simulator.file).write_text(simulator.document, encoding='utf-8')
        if simulator is not None or any(term.in_model for term in diagnosis.terms):
            extended_model(model, diagnosis, provenance).write(workshop)
        step('drawing the report')
        page = render_diagnosis(diagnosis, provenance)
        write_result(workshop, KIND, diagnosis_document(diagnosis, provenance), page)


def figure_views(diagnosis: Diagnosis) -> dict[str, object]:
    """Return what the figures draw, by the names that their files begin with."""
    if diagnosis.laboratory is None:
        return {}
    return {'': diagnosis} | {joint.name: joint for joint in joint_residuals(diagnosis)}


def diagnosis_lines(diagnosis: Diagnosis) -> Sequence[str]:
    """Return what the terminal shows: the sentence first."""
    lines = [diagnosis.sentence]
    for before, after in itertools.pairwise(diagnosis.stages):
        changes = ', '.join(
            f'{name} {error:.2f} -> {after["relative_error_percent"][name]:.2f} %'
            for name, error in before['relative_error_percent'].items()
            if math.isfinite(error)
        )
        lines.append(
            f'  with {words(after["effect"])} ({after["joint"]}): relative effort '
            f'error on folds left out {changes}'
        )
    told = [line for line in map(gain_line, diagnosis.terms) if line]
    if told and diagnosis.gain is not None:
        lines.append(f'Each cause by itself, beside the others, on {diagnosis.gain.on}:')
        lines += [f'  {line}' for line in told]
    if (why_not := rejection(diagnosis)) and diagnosis.verdict != 'bad_data':
        lines.append(f'  not named: {why_not}')
    if diagnosis.recommendation is not None:
        lines.append(f'Next: {diagnosis.recommendation.sentence}')
    elif any(cause.in_model for cause in diagnosis.terms):
        lines.append(
            'Next: sosml simulate another recording with --model and the folder of the extended '
            'model, to see whether it carries over'
        )
    lines.extend(
        f'Data: {check.sentence}' for check in diagnosis.checks if check.severity != 'note'
    )
    if any('±' in line for line in lines):
        lines.append('± is half of the 95 % interval.')
    return lines
