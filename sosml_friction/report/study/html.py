# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The report of the study: one HTML file that needs nothing else."""

from collections.abc import Mapping

from sosml_friction.report.common.figure import figures_of
from sosml_friction.report.common.html_page import heading, items, page, picture, result_box
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.table import Column, Markup, html_table
from sosml_friction.report.study.tables import rmse_text, settle_text, short
from sosml_friction.report.study.view import case_text, findings
from sosml_friction.study.condition import encoder_noise
from sosml_friction.study.motion import MOTIONS
from sosml_friction.study.run import Study
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case

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


def render_study(study: Study, drawn: Mapping[str, bytes]) -> str:
    """
    Return the HTML document.

    :param drawn: PNG by identifier of the figure.
    """
    settings = study.settings
    parts = [
        f'<p>{settings.bits} bit encoders (noise {encoder_noise(settings.bits):.3g} rad), '
        f'{settings.evaluations} evaluations in each tuning, '
        f'{settings.seeds} scoring seeds, {settings.tuning_seeds} tuning seeds.</p>',
        result_box(findings(study)),
        *(
            picture(drawn[figure.identifier], figure.caption_of(study), figure.title)
            for figure in figures_of('study', study)
            if figure.identifier in drawn
        ),
        *(_case_section(study, case) for case in study.observations),
        items(_METHOD, heading('How it was done')),
        heading('Observers'),
        _observer_table(study),
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
    return heading(_sentence(case_text(case))) + text + html_table(columns, rows)


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
