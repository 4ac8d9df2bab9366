# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a diagnosis: next experiments, parameters old and new, negative controls."""

from __future__ import annotations

from html import escape

import numpy as np

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.report.html_page import number_cell
from sosml_friction.report.number_text import format_number

#: A deviation this close to its bound, as a share, is at it.
_AT = 0.999


def experiments(diagnosis: Diagnosis) -> str:
    """Return what was weighed to separate the causes that are left open."""
    recommendation = diagnosis.recommendation
    if recommendation is None or not recommendation.options:
        return ''
    one, other = (name.replace('_', ' ') for name in recommendation.pair)
    rows = [
        '<tr><td>these data</td>'
        + number_cell('')
        + number_cell(f'{100.0 * recommendation.overlap:.1f} %')
        + number_cell(f'{recommendation.margin:.3g}')
        + '<td></td></tr>'
    ]
    rows += [
        f'<tr><td>{escape(option.name.replace("_", " "))}</td>'
        + number_cell(f'{option.duration_s:.0f} s')
        + number_cell(f'{100.0 * option.overlap:.1f} %')
        + number_cell(f'{option.margin:.3g}')
        + f'<td>{escape(option.instruction)}</td></tr>'
        for option in recommendation.options
    ]
    return (
        f'<h2>What would separate {escape(one)} and {escape(other)}</h2>'
        '<table><caption>With these data and the other recording together, predicted; a margin '
        f'(log-likelihood) of {recommendation.needed:g} is needed.</caption>'
        '<thead><tr><th>besides</th><th class="n">duration</th><th class="n">the same</th>'
        '<th class="n">margin</th><th>what to do</th></tr></thead><tbody>'
        + ''.join(rows)
        + '</tbody></table>'
    )


def parameters(diagnosis: Diagnosis) -> str:
    """Return the nominal parameters, old and new, with standard error and limit."""
    laboratory = diagnosis.laboratory
    if laboratory is None or not diagnosis.refit:
        return ''
    scales, names = laboratory.signals[0].scales, diagnosis.names
    rows = []
    for k, name in enumerate(laboratory.nominal.names):
        change, bound = diagnosis.refit[name], float(laboratory.nominal.bound[k])
        error = diagnosis.refit_errors.get(name, np.nan)
        joint, _, what = name.rpartition(' ')
        old = np.nan
        if joint in names and hasattr(scales, what):
            old = float(getattr(scales, what)[names.index(joint)])
        if joint in names and what == 'armature':
            old = float(laboratory.robot.armature[names.index(joint)])
        note = ''
        if np.isfinite(bound) and abs(change) >= _AT * bound:
            note = 'at its limit'
        elif not np.isfinite(bound):
            note = 'not in the model: fitted freely'
        known = np.isfinite(old)
        rows.append(
            f'<tr><td>{escape(name)}</td>'
            + number_cell(format_number(old, error) if known else '')
            + number_cell(format_number(old + change, error) if known else '')
            + number_cell(format_number(change, error))
            + number_cell(format_number(error, error))
            + number_cell(f'± {bound:.3g}' if np.isfinite(bound) else '')
            + f'<td>{note}</td></tr>'
        )
    return (
        '<h2>Parameters of the nominal model</h2><table><caption>SI units of each joint. Numbers '
        'of bodies are deviations of combinations of masses, first moments and inertias that act '
        'together; at a limit the standard error does not hold.</caption><thead><tr>'
        '<th>parameter</th><th class="n">old</th><th class="n">new</th><th class="n">change</th>'
        '<th class="n">standard error</th><th class="n">limit of the change</th><th></th></tr>'
        '</thead><tbody>' + ''.join(rows) + '</tbody></table>'
    )


def controls(diagnosis: Diagnosis) -> str:
    """Return what recordings without a cause gave, and what was looked for."""
    selection, laboratory = diagnosis.selection, diagnosis.laboratory
    if selection is None or laboratory is None:
        return ''
    settings = laboratory.settings
    tried = [(finding, 'named') for finding in selection.accepted]
    if selection.rejected is not None:
        tried.append((selection.rejected, 'not named'))
    rows = []
    for finding, verdict in tried:
        where = '*' if finding.effect.of_robot else diagnosis.names[finding.joint]
        rows.append(
            f'<tr><td>{escape(finding.effect.identifier.replace("_", " "))}, {escape(where)}</td>'
            + number_cell(f'{100.0 * finding.score.cv_gain:.2f} %')
            + number_cell(_percent(finding.floor))
            + f'<td>{verdict}</td></tr>'
        )
    for i, name in enumerate(diagnosis.names):
        if i < len(selection.structure_gain):
            rows.append(
                f'<tr><td>free curves, {escape(name)}</td>'
                + number_cell(f'{100.0 * float(selection.structure_gain[i]):.2f} %')
                + number_cell(_percent(float(selection.structure_floor[i])))
                + '<td></td></tr>'
            )
    return (
        f'<h2>Negative controls</h2><p>{settings.nulls} recordings along the same motion were '
        'simulated for each row without what it says: nominal parameters off by up to their '
        'tolerance, friction that turns around in other ways, noise as measured. The floor is '
        f'{settings.floor_margin:g} times the largest share that it removed of any of them, at '
        f'least {100.0 * settings.floor:g} %.</p>'
        '<table><thead><tr><th>candidate</th><th class="n">removed on data left out</th>'
        '<th class="n">floor</th><th></th></tr></thead><tbody>'
        + ''.join(rows)
        + f'</tbody></table><p>What was looked for was fixed before: library '
        f'<code>{diagnosis.library_hash}</code>, seed {settings.seed}.</p>'
    )


def _percent(share: float) -> str:
    return f'{100.0 * share:.2f} %' if np.isfinite(share) else ''
