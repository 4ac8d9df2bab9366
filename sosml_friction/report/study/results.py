# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of the study as files: ``study.json``, ``study.html`` and the figures."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.identification.fitted_model import versions
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.figure import figures, figures_of
from sosml_friction.report.common.output import (
    OutputKind,
    check_output_folder,
    to_plain,
    write_result,
    written_together,
)
from sosml_friction.report.study.html import render_study
from sosml_friction.report.study.view import shown_observers
from sosml_friction.study.condition import GRAVITY_OFFSET, INERTIA_SCALES, encoder_noise
from sosml_friction.study.metrics import Score
from sosml_friction.study.outcome import FITTED, fitted_laws
from sosml_friction.study.plant import SMOOTHING_VELOCITY, TRUTH
from sosml_friction.study.run import SWEPT, Study, StudyRow, rmse_mean

FORMAT = 'sosml_friction/study/1'


def study_document(study: Study) -> dict[str, Any]:
    """Return what the study found; its schema is ``docs/schema/study.schema.json``."""
    settings = study.settings
    document = {
        'format': FORMAT,
        'settings': {
            'motions': list(settings.motions),
            'conditions': list(settings.conditions),
            'observers': list(settings.observers),
            'scoring_seeds': list(settings.scoring),
            'tuning_seeds': list(settings.tuning),
            'evaluations': settings.evaluations,
            'bits': settings.bits,
            'position_noise': encoder_noise(settings.bits),
            'plant_step_s': settings.plant_step,
            'inertia_scales': list(INERTIA_SCALES),
            'gravity_offset': list(GRAVITY_OFFSET),
        },
        'truth': [
            {'joint': joint, **parameters, 'smoothing_velocity': SMOOTHING_VELOCITY}
            for joint, parameters in zip(study.joints, TRUTH, strict=True)
        ],
        'rows': [
            _row(study, row, joint, score)
            for row in study.rows
            for joint, score in enumerate(row.scores)
        ],
        'floors': [
            {'motion': case[0], 'condition': case[1], 'joint': joint, 'rmse': value, 'unit': 'Nm'}
            for case, floor in study.floors.items()
            for joint, value in zip(study.joints, floor, strict=True)
        ],
        'fits': [
            {
                'motion': case[0],
                'condition': case[1],
                'observer': name,
                'joint': study.joints[0],
                'parameters': dict(law.parameters),
            }
            for case in FITTED
            if case in study.observations
            for name, law in fitted_laws(study, case, shown_observers(study, case)).items()
        ],
        'pareto': [
            {
                'observer': name,
                'motion': SWEPT[0],
                'condition': SWEPT[1],
                'joint': study.joints[0],
                'bandwidth_factor': point.factor,
                'noise_std': point.noise_std,
                'settle_s': point.settle_s,
                'unit': 'Nm',
            }
            for name, points in study.sweeps.items()
            for point in points
        ],
        'versions': versions(),
    }
    return to_plain(document)


def _row(study: Study, row: StudyRow, joint: int, score: Score) -> dict[str, Any]:
    noisy = row.condition == 'noise'
    several = noisy and len(score.rmse) > 1
    return {
        'motion': row.motion,
        'condition': row.condition,
        'observer': row.observer,
        'joint': study.joints[joint],
        'tuning': row.tuning,
        'rmse': {
            'mean': rmse_mean(row.condition, score),
            'std': float(np.std(score.rmse, ddof=1)) if several else None,
            'n': len(score.rmse) if noisy else 1,
        },
        'noise_std': score.noise_std,
        'settle_s': score.settle_s,
        'loop_width': score.loop_width,
        'unit': 'Nm',
        'gains': {name: values[joint] for name, values in row.gains.items()},
    }


def _kind() -> OutputKind:
    """Return what a study writes: its document, its report, a file for each figure."""
    drawn = (f'{figure.identifier}.png' for figure in figures('study'))
    files = ('study.json', 'study.html', *drawn)
    return OutputKind('study', 'study.json', FORMAT, files, 'study.html')


def check_study_destination(folder: str | Path) -> Path:
    """
    Return ``folder`` if a study may be written there: it is absent, empty, or holds a study.

    :raises ConfigurationError: if it is a file or holds something else.
    """
    return check_output_folder(folder, _kind())


def write_study(
    folder: str | Path,
    study: Study,
    document: Mapping[str, Any],
    progress: Callable[[str], None] = lambda name: None,
) -> Path:
    """
    Write the document, the report and the figures of the cases that were run; return the folder.

    They appear together; an earlier study is replaced, other files beside it are kept.

    :param document: of :func:`~sosml_friction.report.study.results.study_document`.
    :param progress: called with the name of each figure before it is drawn.
    :raises ConfigurationError: if the folder holds something else or cannot be written.
    """
    folder = check_study_destination(folder)
    with written_together(folder, _kind()) as workshop:
        drawn = {}
        for figure in figures_of('study', study):
            name = figure.identifier
            progress(name)
            drawn[name] = to_png(figure.draw(study))
            (workshop / f'{name}.png').write_bytes(drawn[name])
        write_result(workshop, _kind(), document, render_study(study, drawn))
    return folder
