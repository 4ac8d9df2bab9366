# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The part of the report that is about one joint."""

from collections.abc import Mapping

from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.identification.number_text import (
    error_text,
    interval_text,
    rounded,
    truth_text,
    value_text,
    words,
)
from sosml_friction.report.common.drawing import is_crowded
from sosml_friction.report.common.figure import METHOD, pictures
from sosml_friction.report.common.html_page import folded, heading, items, paragraph
from sosml_friction.report.common.labels import fit_label, observer_label, pairs_text, symbols_of
from sosml_friction.report.common.table import html_table
from sosml_friction.report.fit import findings
from sosml_friction.report.fit.joint_view import JointView
from sosml_friction.report.fit.segment_rows import segment_table

#: In the place of figures of a page that would be too large with them.
_ELSEWHERE = 'The figures of observers side by side are written by sosml fit --figures png.'


def joint_section(view: JointView) -> str:
    """Return what there is to show of a joint, HTML."""
    title = heading(f'Joint {view.name}')
    if view.model is None:
        why = paragraph(f'Not available: {view.unavailable}.')
        return title + why + pictures('fit', view)
    law = view.model.fit
    checks = [
        *(check.sentence for check in law.checks),
        *(findings.derived_sentence(law, name) for name in law.derived),
    ]
    beside = (
        items(findings.notes([view], beside=True))
        + parameter_table(view.fits, view)
        + open_section(view)
        + (paragraph(_ELSEWHERE) if is_crowded() else pictures('fit', view, METHOD))
        + heading('The other method', 3)
        + _alternatives(view)
    )
    return (
        title
        + items(checks, heading('Is it friction?', 3))
        + pictures('fit', view)
        + folded('Observers and methods side by side', beside)
        + folded('Windows of steady motion', segment_table(view))
    )


def parameter_table(fits: Mapping[str, JointFit], view: JointView) -> str:
    """
    Return the parameters of some fits of a joint, below one another, with the truth if known.

    The fit that became the model is the first.
    """
    order = sorted(fits, key=lambda observer: observer != view.preferred)
    columns = {'from': 'w', 'parameter': 'w', 'value': 'n', 'standard error': 'n',
               '95 % interval': 'n', 'unit': 'w'}  # fmt: skip
    columns |= ({} if view.truth is None else {'truth': 'n'}) | {'flags': ''}
    rows: list[list[str]] = []
    for observer in order:
        mark = ' (the model)' if fits is view.fits and observer == view.preferred else ''
        label = fit_label(observer, fits[observer].method) + mark
        for name, symbol in symbols_of(fits[observer].fit.parameters).items():
            p = fits[observer].fit.parameters.get(name)
            if p is None:
                continue
            row = [label, name_text(name, symbol), value_text(name, p), error_text(p)]
            row += [interval_text(p), p.unit]
            row += [] if view.truth is None else [truth_text(view.known, name)]
            rows.append([*row, ', '.join(map(words, p.flags))])
            label = ''
    quality = '; '.join(
        f'{observer_label(observer)}: residual {rounded(fit.fit.residual_std)} {fit.unit} '
        f'({rounded(fit.fit.relative_error)} %) over {pairs_text(fit.method, fit.fit.pairs)}, in '
        f'{fit.fit.clusters} independent pieces'
        for observer, fit in fits.items()
    )
    return html_table(columns, rows) + paragraph(f'{quality}.')


def name_text(name: str, symbol: str) -> str:
    """Return the name of a parameter with its symbol."""
    return name if name == symbol else f'{name} ({symbol})'


def open_section(view: JointView) -> str:
    """Return why parameters are flagged, and what to record, as a list."""
    return items(findings.open_questions(view), heading('What this recording leaves open', 3))


def _alternatives(view: JointView) -> str:
    if not view.alternatives:
        return '<p>It could not be used on this recording.</p>'
    verdict = (
        'The two methods differ by more than their 95 % intervals: see the note above.'
        if findings.methods_disagree(view)
        else 'The two methods agree within their 95 % intervals.'
    )
    table = parameter_table(view.alternatives, view)
    return f'<p>{verdict}</p>{folded("Its parameters", table)}'
