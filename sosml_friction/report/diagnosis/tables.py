# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a diagnosis: next experiments, parameters old and new, negative controls."""

from __future__ import annotations

from html import escape

import numpy as np

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.report.common.html_page import table
from sosml_friction.report.common.number_text import format_number

#: A deviation this close to its bound, as a share, is at it.
_AT = 0.999


def experiments(diagnosis: Diagnosis) -> str:
    """Return what was weighed to separate the causes that are left open."""
    recommendation = diagnosis.recommendation
    if recommendation is None or not recommendation.options:
        return ''
    one, other = (name.replace('_', ' ') for name in recommendation.pair)
    rows = [
        (
            'these data',
            '',
            f'{100.0 * recommendation.overlap:.1f} %',
            f'{recommendation.margin:.3g}',
            '',
        )
    ]
    rows += [
        (
            option.name.replace('_', ' '),
            f'{option.duration_s:.0f} s',
            f'{100.0 * option.overlap:.1f} %',
            f'{option.margin:.3g}',
            option.instruction,
        )
        for option in recommendation.options
    ]
    columns = {'besides': '', 'duration': 'n', 'the same': 'n', 'margin': 'n', 'what to do': ''}
    caption = (
        'With these data and the other recording together, predicted; a margin (log-likelihood) '
        f'of {recommendation.needed:g} is needed.'
    )
    heading = f'<h2>What would separate {escape(one)} and {escape(other)}</h2>'
    return heading + table(columns, rows, caption)


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
            (
                name,
                format_number(old, error) if known else '',
                format_number(old + change, error) if known else '',
                format_number(change, error),
                format_number(error, error),
                f'± {bound:.3g}' if np.isfinite(bound) else '',
                note,
            )
        )
    columns = {
        'parameter': '', 'old': 'n', 'new': 'n', 'change': 'n', 'standard error': 'n',
        'limit of the change': 'n', '': '',
    }  # fmt: skip
    caption = (
        'SI units of each joint. Numbers of bodies are deviations of combinations of masses, '
        'first moments and inertias that act together; at a limit the standard error does not '
        'hold.'
    )
    return '<h2>Parameters of the nominal model</h2>' + table(columns, rows, caption)


def controls(diagnosis: Diagnosis) -> str:
    """Return what recordings without a cause gave, and what was looked for."""
    selection, laboratory = diagnosis.selection, diagnosis.laboratory
    if selection is None or laboratory is None:
        return ''
    settings = laboratory.settings
    tolerated = {cause.key for cause in diagnosis.tolerated}
    tried = [(finding, 'named') for finding in selection.accepted]
    if selection.rejected is not None:
        tried.append((selection.rejected, 'not named'))
    rows = []
    for finding, verdict in tried:
        effect, joint = finding.reported(diagnosis.names)
        if verdict == 'named' and (effect, joint) in tolerated:
            verdict = 'off within the tolerance'
        rows.append(
            (
                f'{effect.replace("_", " ")}, {joint}',
                f'{100.0 * finding.score.cv_gain:.2f} %',
                _percent(finding.floor),
                verdict,
            )
        )
    rows += [
        (f'free curves, {name}', f'{100.0 * float(gain):.2f} %', _percent(float(floor)), '')
        for name, gain, floor in zip(
            diagnosis.names, selection.structure_gain, selection.structure_floor, strict=True
        )
    ]
    columns = {'candidate': '', 'removed on data left out': 'n', 'floor': 'n', '': ''}
    return (
        f'<h2>Negative controls</h2><p>{settings.nulls} recordings along the same motion were '
        'simulated for each row without what it says: nominal parameters off by up to their '
        'tolerance, friction that turns around in other ways, noise as measured. The floor is '
        f'{settings.floor_margin:g} times the largest share that it removed of any of them, at '
        f'least {100.0 * settings.floor:g} %.</p>'
        + table(columns, rows)
        + f'<p>What was looked for was fixed before: library '
        f'<code>{diagnosis.library_hash}</code>, seed {settings.seed}.</p>'
    )


def _percent(share: float) -> str:
    return f'{100.0 * share:.2f} %' if np.isfinite(share) else ''
