# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The report of the study: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from sosml_friction.report.common.html_page import number_cell, page, picture
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.study.figures import FIGURES
from sosml_friction.report.study.tables import rmse_text, settle_text, short
from sosml_friction.report.study.view import case_text, findings
from sosml_friction.study.condition import encoder_noise
from sosml_friction.study.motion import MOTIONS
from sosml_friction.study.run import Study
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case

_CAPTIONS = {
    'figure2_slow_nominal': 'Slow motion, nominal (the paper’s Figure 2). Left: estimates, the '
    'law fitted to them, the true law. Right: estimate minus truth. FO capped has a cutoff of at '
    'most 300 1/s.',
    'figure3_noise': 'Estimate minus truth with encoder noise (the paper’s Figure 3), first '
    'scoring seed; the RMSE is the mean over all seeds. Long traces are drawn as their envelope.',
    'figure4_mismatch': 'Reversal with a wrong model (the paper’s Figure 4). Above: estimates, '
    'fitted laws, truth. Below: the parameters of the fitted laws; dashed: truth. The bias is the '
    'error of the gravity model, which cannot be told from friction that does not change sign.',
    'pareto': 'Noise against settle time, reversal with noise: the bandwidth of each causal '
    'observer from a fifth to five times the tuned one (large marker), other ratios of its gains '
    'kept. Left and down is better. Times below one sample are drawn at 1 ms; points at which '
    'noise hides the mean error, or which do not settle, are left out.',
}
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


def render_study(study: Study, pictures: Mapping[str, bytes]) -> str:
    """
    Return the HTML document.

    :param pictures: PNG by name of the figure.
    """
    settings = study.settings
    sentences = ''.join(f'<p>{escape(sentence)}</p>' for sentence in findings(study))
    title = 'Momentum observers for friction: the simulation study'
    parts = [
        f'<h1>{title}</h1>',
        f'<p>{settings.bits} bit encoders (noise {encoder_noise(settings.bits):.3g} rad), '
        f'{settings.evaluations} evaluations in each tuning, '
        f'{settings.seeds} scoring seeds, {settings.tuning_seeds} tuning seeds.</p>',
        f'<div class="result">{sentences}</div>' if sentences else '',
    ]
    for name in FIGURES:
        if name in pictures:
            parts.append(picture(pictures[name], _CAPTIONS[name]))
    for case in study.observations:
        parts.append(_case_section(study, case))
    parts += [
        '<h2>How it was done</h2>',
        '<ul>' + ''.join(f'<li>{escape(sentence)}</li>' for sentence in _METHOD) + '</ul>',
        '<h2>Observers</h2>',
        _observer_table(study),
    ]
    return page(title, parts)


def _case_section(study: Study, case: Case) -> str:
    rows = [row for row in study.rows if (row.motion, row.condition) == case]
    head = ''.join(f'<th class="g l" colspan="4">{escape(joint)}</th>' for joint in study.joints)
    columns = (
        '<th class="n l">RMSE [mNm]</th><th class="n">noise [mNm]</th>'
        '<th class="n">settle [ms]</th><th class="n">width [mNm]</th>'
    ) * len(study.joints)
    body = []
    for row in rows:
        cells = f'<td class="w">{escape(observer_label(row.observer))}</td><td>{row.tuning}</td>'
        for score in row.scores:
            cells += (
                number_cell(rmse_text(row.condition, score), 'n l')
                + number_cell(short(1e3 * score.noise_std))
                + number_cell(settle_text(score))
                + number_cell(short(1e3 * score.loop_width))
            )
        gains = '; '.join(
            f'{name} ' + ', '.join(f'{value:.3g}' for value in values)
            for name, values in row.gains.items()
        )
        body.append(f'<tr>{cells}<td class="l">{escape(gains)}</td></tr>')
    floor = ''
    if case[1] == 'mismatch':
        values = ', '.join(
            f'{joint} {1e3 * float(value):.1f} mNm'
            for joint, value in zip(study.joints, study.floors[case], strict=True)
        )
        floor = f'<p>Offset floor: {escape(values)}.</p>'
    return (
        f'<h2>{escape(_sentence(case_text(case)))}</h2>'
        f'<p>{escape(_sentence(MOTIONS[case[0]].description))}.</p>{floor}'
        '<div class="wide"><table><thead><tr><th rowspan="2">observer</th>'
        f'<th rowspan="2">tuned for</th>{head}<th rowspan="2" class="l">gains '
        f'({escape(", ".join(study.joints))})</th></tr><tr>{columns}</tr></thead>'
        f'<tbody>{"".join(body)}</tbody></table></div>'
    )


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
        rows.append(
            f'<tr><td class="w">{escape(observer_label(name))}</td>'
            f'<td><code>{escape(name)}</code></td>'
            f'<td>{"on line" if observer.causal else "off line"}</td>'
            f'<td>{escape(searched)}</td><td>{escape(fixed)}</td></tr>'
        )
    return (
        '<div class="wide"><table><thead><tr><th>observer</th><th>name</th><th>runs</th>'
        '<th>gains searched</th><th>gains fixed</th></tr></thead>'
        f'<tbody>{"".join(rows)}</tbody></table></div>'
    )


def _sentence(text: str) -> str:
    """Return the text with a capital first letter; the others stay, as in Hz."""
    return text[:1].upper() + text[1:]
