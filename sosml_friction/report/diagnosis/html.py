# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The page of a diagnosis: verdict first, then what it rests on."""

from __future__ import annotations

from html import escape

import numpy as np

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.html_page import page, picture, table
from sosml_friction.report.common.number_text import format_number
from sosml_friction.report.diagnosis.confusability import confusability_map
from sosml_friction.report.diagnosis.correlation import correlation
from sosml_friction.report.diagnosis.figures import (
    binned_residual,
    ranking_bars,
    residual_over_time,
    rows_of,
)
from sosml_friction.report.diagnosis.periodogram import position_periodogram
from sosml_friction.report.diagnosis.tables import controls, experiments, parameters
from sosml_friction.report.diagnosis.variance import variance_waterfall

_METHOD = (
    'Unexplained is measured effort minus that of the nominal model, whose parameters were '
    'refitted within 3.5 % of their values; both sides were low-passed alike. A cause is named '
    'if, on stretches of data left out of its fit, it removes more than it does of recordings '
    'simulated without it, if its size is physically possible, and if the forward simulation '
    'of data left out gets better. Percentages of the ranking are shares of the energy of the '
    'whitened residual.'
)
_FORWARD = (
    'The position error is that of a simulation of data left out of the fit, driven by the '
    'measured effort and restarted from the measured state every 0.3 s.'
)


def render_diagnosis(diagnosis: Diagnosis) -> str:
    """Return the report as one HTML document, pictures included."""
    title = f'Diagnosis: {diagnosis.verdict.replace("_", " ")}'
    parts = [f'<h1>{escape(title)}</h1>', _result(diagnosis), _notes(diagnosis)]
    parts.append(_causes(diagnosis))
    if diagnosis.laboratory is not None:
        parts.append(_gain(diagnosis))
        parts.append(experiments(diagnosis))
        parts.append(_pictures(diagnosis))
        parts.append(parameters(diagnosis))
        parts.append(controls(diagnosis))
        parts.append(f'<p>{escape(_METHOD)} {escape(_FORWARD)}</p>')
    checks = ''.join(f'<li>{escape(check.sentence)}</li>' for check in diagnosis.checks)
    parts.append(f'<h2>Data</h2><ul>{checks}</ul>')
    if diagnosis.laboratory is None:
        parts.append(f'<p>Library <code>{diagnosis.library_hash}</code></p>')
    return page(title, parts)


def _result(diagnosis: Diagnosis) -> str:
    text = f'<p>{escape(diagnosis.sentence)}</p>'
    if diagnosis.recommendation is not None:
        text += f'<p>Next: {escape(diagnosis.recommendation.sentence)}</p>'
    return f'<div class="result">{text}</div>'


def _notes(diagnosis: Diagnosis) -> str:
    notes = [check.sentence for check in diagnosis.checks if check.severity != 'note']
    if diagnosis.rejected is not None:
        rejected = diagnosis.rejected
        notes.append(
            f'Not named: {rejected["effect"].replace("_", " ")} ({rejected["joint"]}), because '
            + '; '.join(rejected['failed'])
        )
    if not notes:
        return ''
    return f'<div class="note"><ul>{"".join(f"<li>{escape(n)}</li>" for n in notes)}</ul></div>'


def _causes(diagnosis: Diagnosis) -> str:
    if not diagnosis.terms:
        return ''
    rows = []
    for cause in diagnosis.terms:
        for k, (name, p) in enumerate(cause.parameters.items()):
            what = f'{cause.effect.replace("_", " ")}, {cause.joint}' if k == 0 else ''
            if k == 0 and cause.tolerated:
                what += ' (within the tolerance)'
            rivals = ', '.join(r.replace('_', ' ') for r in cause.rivals) if k == 0 else ''
            error = format_number(p.std_error, p.std_error) if np.isfinite(p.std_error) else ''
            value = format_number(p.value, p.std_error)
            where = ('yes' if cause.in_model else 'no') if k == 0 else ''
            rows.append((what, name.replace('_', ' '), value, error, p.unit, rivals, where))
    columns = {
        'cause': '', 'parameter': '', 'value': 'n', 'standard error': 'n', 'unit': '',
        'or as well': '', 'in the model': '',
    }  # fmt: skip
    return '<h2>Causes</h2>' + table(columns, rows)


def _gain(diagnosis: Diagnosis) -> str:
    gain = diagnosis.gain
    if gain is None:
        return ''
    rows = []
    for i, name in enumerate(diagnosis.names):
        unit = diagnosis.units[i]
        length = 'mrad' if unit == 'Nm' else 'mm'
        before, after = 1e3 * gain.forward_before[i], 1e3 * gain.forward_after[i]
        rows.append(
            (
                name,
                f'{gain.inverse_before[i]:.4g} → {gain.inverse_after[i]:.4g} {unit}',
                f'{gain.relative_before[i]:.2f} → {gain.relative_after[i]:.2f} %',
                f'{before:.3g} → {after:.3g} {length}',
                f'{gain.forward_ratio[i]:.3f}',
                f'{gain.forward_error[i]:.3f}',
            )
        )
    position = f'position after {gain.horizon_s:g} s'
    columns = {
        'joint': '', 'effort error': 'n', 'relative': 'n', position: 'n', 'after / before': 'n',
        'standard error': 'n',
    }  # fmt: skip
    return f'<h2>Gain, on {escape(gain.on)}</h2>' + table(columns, rows)


def _pictures(diagnosis: Diagnosis) -> str:
    parts = []
    before, after = diagnosis.residual_before, diagnosis.residual_after
    rows = rows_of(diagnosis)
    if before is not None and after is not None:
        for i, name in enumerate(diagnosis.names):
            parts.append(f'<h2>{escape(name)}</h2>')
            figure = residual_over_time(diagnosis, i, before, after, rows)
            parts.append(picture(to_png(figure), 'Effort, and what is unexplained of it'))
            figure = binned_residual(diagnosis, i, before, after, rows)
            parts.append(
                picture(to_png(figure), 'Mean of what is unexplained along six axes, by direction')
            )
            lines = position_periodogram(diagnosis, i, before, after, rows)
            if lines is not None:
                parts.append(
                    picture(
                        to_png(lines),
                        'What repeats with position: a torque of position has the same lines in '
                        'both directions, and what drifts with time has none',
                    )
                )
            parts.append(
                picture(
                    to_png(correlation(diagnosis, i, before, after, rows)),
                    'Left: is the rest noise? Right: error if effort were measured earlier or '
                    'later; dots: where it is least',
                )
            )
    if diagnosis.ranking:
        parts.append('<h2>What was considered</h2>')
        if diagnosis.stages:
            parts.append(
                picture(
                    to_png(variance_waterfall(diagnosis)),
                    'Unexplained variance on folds left out: what each cause takes of it, what '
                    'stays unexplained, and what is noise by the estimate',
                )
            )
        parts.append(
            picture(
                to_png(ranking_bars(diagnosis)),
                'First round: what each candidate removes on data left out, with standard errors; '
                'dark: named; dotted: floor of the first',
            )
        )
    if diagnosis.confusability is not None and len(diagnosis.confusability.effects) > 1:
        parts.append('<h2>What this motion can tell apart</h2>')
        parts.append(
            picture(
                to_png(confusability_map(diagnosis)),
                'Share of each cause (row), as large as the noise and after the refit, that each '
                'other one (column) explains. Bold: named; boxes: left open by these data',
            )
        )
    return ''.join(parts)
