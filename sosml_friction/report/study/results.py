# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of the study as files: ``study.json``, ``study.html`` and the figures."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Drawing

from sosml_friction.identification.fitted_model import versions
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.figure import figures, figures_of
from sosml_friction.report.common.html_page import facts, folded, heading, items, page, verdict
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.output import (
    OutputKind,
    check_output_folder,
    write_result,
    written_together,
)
from sosml_friction.report.common.table import Column, Markup, html_table
from sosml_friction.report.study.tables import rmse_text, settle_text, short
from sosml_friction.report.study.view import case_text, findings, shown_observers
from sosml_friction.study.condition import GRAVITY_OFFSET, INERTIA_SCALES, encoder_noise
from sosml_friction.study.metrics import Score
from sosml_friction.study.motion import MOTIONS
from sosml_friction.study.outcome import FITTED, fitted_laws
from sosml_friction.study.plant import SMOOTHING_VELOCITY, TRUTH
from sosml_friction.study.run import SWEPT, Study, StudyRow, rmse_mean
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case

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


def study_kind() -> OutputKind:
    """Return what a study writes: its document, its report, a file for each figure."""
    drawn = (f'{figure.identifier}.png' for figure in figures('study'))
    files = ('study.json', 'study.html', *drawn)
    return OutputKind('study', 'study.json', FORMAT, files, 'study.html')


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
    kind = study_kind()
    folder = check_output_folder(folder, kind)
    with written_together(folder, kind) as workshop:
        drawn = {}
        for figure in figures_of('study', study):
            name = figure.identifier
            progress(name)
            drawn[name] = figure.draw(study)
            (workshop / f'{name}.png').write_bytes(to_png(drawn[name]))
        write_result(workshop, kind, document, render_study(study, drawn))
    return folder


_METHOD = (
    'Plant: two-joint exoskeleton, Stribeck friction on both joints, Runge-Kutta steps; the '
    'controller (computed torque and PD, 60 rad/s, held over 1 ms) acts on the true state, so the '
    'truth is the same in all conditions. Observers get what the product’s estimator makes of the '
    'signals.',
    'Nominal: exact position and velocity. Noise: encoder noise of half a step, quantisation, '
    'velocity by backward difference. Mismatch: exact signals, model with M × 1.1 and × 0.9 (rms '
    'of both) and gravity + (0.10, 0.05) Nm.',
    'Every tuning tries the same number of gain sets: half of them a Sobol sequence in the '
    'logarithm of the gains, then Nelder-Mead. Joints are tuned each on its own error. Noise '
    'seeds of tuning are not scored; without noise there is one signal, on which gains are tuned '
    'and scored.',
    'Observers that ask for the noise of the encoder are told it; without noise, a hundredth of '
    'it.',
    'Efforts are free of noise and the rigid body is exact but in mismatch, which favours what '
    'leans on them: Quasi-static, and the Kalman observers with a law, which expect the very form '
    'of friction that the plant has (the wrong law: a knee three times as wide).',
    'RMSE: of estimate minus truth from 0.5 s on. Noise: standard deviation over seeds where the '
    'truth has been steady for 0.25 s. Settle: time after the velocity changes sign from which '
    'the error, averaged over all reversals and seeds, stays below 10 % of the jump; a dash where '
    'it does not within 0.8 s or noise hides it. Width: estimate while crossing zero velocity '
    'downwards minus that upwards; the true law has none.',
    'Offset floor: RMSE of an ideal observer with the same wrong model, '
    '−(s − 1)(M q″ + C q′) − d. An observer that expects a law of friction can be below it.',
)


def render_study(study: Study, drawn: Mapping[str, Drawing]) -> str:
    """Return the HTML document."""
    settings = study.settings
    told = {
        'Encoders': f'{settings.bits} bit, noise {encoder_noise(settings.bits):.3g} rad',
        'Tuning': f'{settings.evaluations} evaluations each',
        'Noise seeds': f'{settings.seeds} to score, {settings.tuning_seeds} to tune',
        'Observers': str(len(settings.observers)),
    }
    pictures = [
        figure.html(study, drawn[figure.identifier])
        for figure in figures_of('study', study)
        if figure.identifier in drawn
    ]
    parts = [
        facts(told),
        verdict('found', f'{len(study.observations)} cases simulated', findings(study)),
        *pictures,
        heading('All numbers'),
        *(_case_section(study, case) for case in study.observations),
        folded('How it was done', items(_METHOD)),
        folded('Observers and the gains that were searched', _observer_table(study)),
    ]
    return page('Momentum observers for friction: the simulation study', parts)


def _case_section(study: Study, case: Case) -> str:
    columns = [Column('observer', 'w'), Column('tuned for')]
    for joint in study.joints:
        columns.append(Column('RMSE [mNm]', 'n l', joint))
        heads = ('noise [mNm]', 'settle [ms]', 'width [mNm]')
        columns += [Column(head, 'n', joint) for head in heads]
    columns.append(Column(f'gains ({", ".join(study.joints)})', 'l'))
    rows = []
    for row in study.rows:
        if (row.motion, row.condition) != case:
            continue
        cells = [observer_label(row.observer), row.tuning]
        for score in row.scores:
            cells += [rmse_text(row.condition, score), short(1e3 * score.noise_std)]
            cells += [settle_text(score), short(1e3 * score.loop_width)]
        gains = [
            f'{name} ' + ', '.join(f'{value:.3g}' for value in values)
            for name, values in row.gains.items()
        ]
        rows.append([*cells, '; '.join(gains)])
    text = f'<p>{_sentence(MOTIONS[case[0]].description)}.</p>'
    if case[1] == 'mismatch':
        values = ', '.join(
            f'{joint} {1e3 * float(value):.1f} mNm'
            for joint, value in zip(study.joints, study.floors[case], strict=True)
        )
        text += f'<p>Offset floor: {values}.</p>'
    return folded(_sentence(case_text(case)), text + html_table(columns, rows))


def _observer_table(study: Study) -> str:
    rows = []
    for name in study.settings.observers:
        observer, space = study_variants()[name]
        units = observer.gain_units
        searched = '; '.join(
            f'{gain} {span.low:g} to {span.high:g}'
            + (f' times {span.of}^{span.power:g}' if span.of else f' {units[gain]}')
            for gain, span in space.ranges.items()
        )
        fixed = '; '.join(f'{gain} {value:g} {units[gain]}' for gain, value in space.fixed.items())
        runs = 'on line' if observer.causal else 'off line'
        code = Markup(f'<code>{name}</code>')
        rows.append((observer_label(name), code, runs, searched, fixed))
    columns = {'observer': 'w', 'name': '', 'runs': '', 'gains searched': '', 'gains fixed': ''}
    return html_table(columns, rows)


def _sentence(text: str) -> str:
    """Return the text with a capital first letter; the others stay, as in Hz."""
    return text[:1].upper() + text[1:]
