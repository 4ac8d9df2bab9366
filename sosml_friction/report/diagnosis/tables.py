# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The tables of a diagnosis, as HTML; empty where there is nothing to say."""

import math

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.diagnosis.residual.refitted_parameters import refitted_parameters
from sosml_friction.diagnosis.wording import SIZE_UNKNOWN
from sosml_friction.identification.number_text import (
    format_number,
    joint_text,
    number_text,
    percent,
    plus_minus,
    rounded,
    words,
)
from sosml_friction.model.parameter import Z_95
from sosml_friction.report.common.html_page import heading
from sosml_friction.report.common.table import html_table


def causes(diagnosis: Diagnosis) -> str:
    """Return what was named, its parameters, and what would explain the data as well."""
    rows = []
    for cause in diagnosis.terms:
        if cause.is_fault:
            continue
        what = f'{joint_text(cause.joint)}: {words(cause.effect)}'
        what += ' as stated is off' if cause.stated else ''
        what += ' (within the tolerance)' if cause.tolerated else ''
        rivals = ', '.join(map(words, cause.rivals))
        held = 'yes' if cause.in_model else 'no'
        if not cause.size_known:
            rows.append((what, SIZE_UNKNOWN, '', '', rivals, held))
            continue
        for k, (name, p) in enumerate(cause.parameters.items()):
            label = words(name)
            label += f' (stated: {cause.stated[name]:.4g})' if name in cause.stated else ''
            row = (label, number_text(name, p), '' if p.unit == '1' else p.unit)
            rows.append(('', *row, '', '') if k else (what, *row, rivals, held))
    columns = {'cause': '', 'parameter': '', 'value ± 95 %': 'n', 'unit': 'w', 'or as well': '',
               'in the extended model': ''}  # fmt: skip
    return heading('What was named', 3) + html_table(columns, rows) if rows else ''


def gain(diagnosis: Diagnosis) -> str:
    """Return the errors of effort and position without and with what was named."""
    found = diagnosis.gain
    if found is None:
        return ''
    rows = []
    for i, (name, unit) in enumerate(zip(diagnosis.names, diagnosis.units, strict=True)):
        if not math.isfinite(found.relative_before[i]):
            continue
        length = 'mrad' if unit == 'Nm' else 'mm'
        before, after = 1e3 * found.forward_before[i], 1e3 * found.forward_after[i]
        rows.append(
            (
                name,
                f'{found.inverse_before[i]:.4g} → {found.inverse_after[i]:.4g} {unit}',
                f'{found.relative_before[i]:.2f} → {found.relative_after[i]:.2f} %',
                f'{before:.3g} → {after:.3g} {length}',
                format_number(found.forward_ratio[i], found.forward_error[i]),
                rounded(found.forward_error[i]),
            )
        )
    columns = {
        'joint': '', 'effort error': 'n', 'relative': 'n',
        f'position after {found.horizon_s:g} s': 'n', 'after / before': 'n',
        'standard error': 'n',
    }  # fmt: skip
    return heading(f'Errors before and after, on {found.on}', 3) + html_table(columns, rows)


def by_cause(diagnosis: Diagnosis) -> str:
    """Return what each cause removes by itself, on the same data."""
    rows = []
    for cause in diagnosis.terms:
        own = cause.gain
        for i, joint in enumerate(() if own is None else own.joints):
            assert own is not None
            removed, recurs = own.removed[i], own.recurs
            rows.append(
                (
                    f'{joint_text(cause.joint)}: {words(cause.effect)}',
                    joint,
                    f'{own.without[i]:.4g} → {own.with_it[i]:.4g} {own.units[i]}',
                    format_number(removed.value, removed.std_error),
                    rounded(removed.std_error),
                    plus_minus(recurs.value, Z_95 * recurs.std_error),
                    'yes' if own.carries_over else 'no',
                )
            )
    columns = {
        'cause by itself': '', 'joint': '', 'effort error without → with': 'n', 'removed': 'n',
        'standard error': 'n', 'recurs': 'n', 'carries over': '',
    }  # fmt: skip
    caption = (
        'Each beside the others: the model with all of them against the one without it, both '
        'fitted to the recordings and nothing to these data. Recurs: the share of what a cause '
        'predicts that is there, 1 where it carries over; it makes the error larger below 0.5.'
    )
    return html_table(columns, rows, caption) if rows else ''


def experiments(diagnosis: Diagnosis) -> str:
    """Return what was weighed to separate the causes that are left open."""
    recommendation = diagnosis.recommendation
    if recommendation is None or not recommendation.options:
        return ''
    one, other = (words(name) for name in recommendation.pair)
    these = ('these data', '', recommendation.overlap, recommendation.margin, '')
    others = [
        (words(x.name), f'{x.duration_s:.0f} s', x.overlap, x.margin, x.instruction)
        for x in recommendation.options
    ]
    rows = [
        (name, duration, f'{100.0 * overlap:.1f} %', f'{margin:.3g}', instruction)
        for name, duration, overlap, margin, instruction in (these, *others)
    ]
    columns = {'besides': '', 'duration': 'n', 'the same': 'n', 'margin': 'n', 'what to do': ''}
    caption = (
        'With these data and the other recording together, predicted; a margin (log-likelihood) '
        f'of {recommendation.needed:g} is needed.'
    )
    told = heading(f'What would separate {one} and {other}')
    return told + html_table(columns, rows, caption)


def parameters(diagnosis: Diagnosis) -> str:
    """Return the nominal parameters, old and new, with standard error and limit."""
    rows = []
    for p in refitted_parameters(diagnosis):
        known, bounded = math.isfinite(p.old), math.isfinite(p.bound)
        note = '' if bounded else 'not in the model: fitted freely'
        rows.append(
            (
                p.name,
                format_number(p.old, p.std_error) if known else '',
                format_number(p.old + p.change, p.std_error) if known else '',
                format_number(p.change, p.std_error),
                rounded(p.std_error),
                f'at most {p.bound:.3g}' if bounded else '',
                'at its limit' if p.at_bound else note,
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
    return html_table(columns, rows, caption) if rows else ''


def floors(diagnosis: Diagnosis) -> str:
    """Return what each candidate and curve had to exceed, and what was looked for."""
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
        removed, floor = percent(finding.score.cv_gain), percent(finding.floor)
        rows.append((f'{joint_text(joint)}: {words(effect)}', removed, floor, verdict))
    known = laboratory.known
    for i, name in enumerate(diagnosis.names):
        if (most := selection.remainder.largest(i)) is not None:
            share, floor = percent(most.energy / known[i]), percent(most.floor / known[i])
            rows.append((f'{most.axis}, {name}', share, floor, most.form))
    columns = {'candidate': '', 'removed on data left out': 'n', 'floor': 'n', '': ''}
    return (
        f'<p>A candidate has to remove at least {100.0 * settings.floor:g} % of data left out, '
        'times 1 + ln g where it may choose among g values; more where something that is '
        'impossible removes as much. Of free curves without a name the floor is the largest '
        'share of noise that one explains by itself, and what the tolerances make of it.</p>'
        + html_table(columns, rows)
        + f'<p>What was looked for was fixed before: library '
        f'<code>{diagnosis.library_hash}</code>.</p>'
    )
