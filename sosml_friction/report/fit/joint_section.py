# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The part of the report that is about one joint."""

from collections.abc import Mapping
from html import escape

from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.report.common.figure import pictures
from sosml_friction.report.common.html_page import folded, heading, items
from sosml_friction.report.common.labels import fit_label, observer_label, symbols_of
from sosml_friction.report.common.number_text import (
    UNKNOWN,
    error_text,
    interval_text,
    rounded,
    truth_text,
    value_text,
    words,
)
from sosml_friction.report.common.table import Column, html_table
from sosml_friction.report.fit.findings import derived_sentence, methods_disagree, open_questions
from sosml_friction.report.fit.joint_view import JointView
from sosml_friction.report.fit.segment_rows import segment_table

#: What a method calls the pairs it fits to.
_PAIRS = {
    'segments': 'levels',
    'samples': 'samples',
    'weak': 'means',
    'regression': 'rows beside the rigid body',
    'output_error': 'simulated samples',
}


def joint_section(view: JointView) -> str:
    """Return what there is to show of a joint, HTML."""
    title = heading(f'Joint {view.name}')
    if view.model is None:
        return f'{title}<p>Not available: {escape(view.unavailable)}.</p>{pictures("fit", view)}'
    return ''.join(
        (
            title,
            parameter_table(view.fits, view),
            open_section(view),
            items(
                [
                    *(check.sentence for check in view.model.fit.checks),
                    *(derived_sentence(view.model.fit, name) for name in view.model.fit.derived),
                ],
                heading('Is it friction?', 3),
            ),
            pictures('fit', view),
            heading('The other method', 3),
            _alternatives(view),
            heading('Windows of steady motion', 3),
            segment_table(view),
        )
    )


def parameter_table(fits: Mapping[str, JointFit], view: JointView) -> str:
    """
    Return the parameters of some fits of a joint, side by side, with the truth if known.

    The fit that became the model is the first, where it is seen on a narrow page too.
    """
    order = sorted(fits, key=lambda observer: observer != view.preferred)
    columns = [Column('parameter', 'w'), Column('unit', 'w')]
    if view.truth is not None:
        columns.append(Column('truth', 'n'))
    for observer in order:
        mark = ' (the model)' if fits is view.fits and observer == view.preferred else ''
        group = fit_label(observer, fits[observer].method) + mark
        columns += [
            Column('value', 'n l', group),
            Column('standard error', 'n', group),
            Column('95 % interval', 'n', group),
        ]
    columns.append(Column('flags', 'l'))
    rows = []
    for name, symbol in symbols_of(*(fit.fit.parameters for fit in fits.values())).items():
        known = {o: p for o in order if (p := fits[o].fit.parameters.get(name)) is not None}
        row = [name_text(name, symbol), next(p.unit for p in known.values())]
        if view.truth is not None:
            row.append(truth_text(view.known, name))
        for observer in order:
            p = known.get(observer)
            row += (
                [UNKNOWN] * 3
                if p is None
                else [value_text(name, p), error_text(p), interval_text(p)]
            )
        flags = {o: ', '.join(map(words, p.flags)) for o, p in known.items()}
        if len(set(flags.values())) == 1:
            row.append(flags[next(iter(flags))])
        else:
            row.append(
                '; '.join(f'{observer_label(o)}: {text}' for o, text in flags.items() if text)
            )
        rows.append(row)
    quality = '; '.join(
        f'{observer_label(observer)}: residual {rounded(fit.fit.residual_std)} {fit.unit} '
        f'({rounded(fit.fit.relative_error)} %) over {fit.fit.pairs} '
        f'{_PAIRS[fit.method]} in {fit.fit.clusters} independent pieces'
        for observer, fit in fits.items()
    )
    return html_table(columns, rows, quality)


def name_text(name: str, symbol: str) -> str:
    """Return the name of a parameter with its symbol."""
    return name if name == symbol else f'{name} ({symbol})'


def open_section(view: JointView) -> str:
    """Return why parameters are flagged, and what to record, as a list."""
    return items(open_questions(view), heading('What this recording leaves open', 3))


def _alternatives(view: JointView) -> str:
    if not view.alternatives:
        return '<p>It could not be used on this recording.</p>'
    verdict = (
        'The two methods differ by more than their 95 % intervals: see the note at the top.'
        if methods_disagree(view)
        else 'The two methods agree within their 95 % intervals.'
    )
    table = parameter_table(view.alternatives, view)
    return f'<p>{verdict}</p>{folded("Its parameters", table)}'
