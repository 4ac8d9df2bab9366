# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The inverse-model fit of an analysis as rows of a table, and as a part of the report."""

from collections.abc import Iterator

from rich.console import Group, RenderableType
from rich.text import Text

from sosml_friction.identification.inverse_model import InverseFit, InverseFits
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.number_text import (
    error_text,
    format_number,
    interval_text,
    value_text,
    words,
)
from sosml_friction.report.common.html_page import heading, paragraph
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.table import html_table, terminal_table

_COLUMNS = {
    'parameter': 'w', 'unit': 'w', 'value': 'n', 'standard error': 'n', '95 % interval': 'n',
}  # fmt: skip
_METHOD = (
    'Inertia and friction are fitted together to the effort, without an observer: position is '
    'filtered forwards and backwards and differentiated twice, and both sides are decimated '
    'alike. Symmetric: one Coulomb and one viscous term and a bias; asymmetric: one of each by '
    'direction of motion. The model written beside this keeps the inertia it had.'
)


def inverse_table(analysis: BagAnalysis, inverse: InverseFits) -> RenderableType:
    """Return the fits for the terminal: a parameter a row, what is left of the effort below."""
    fits = _fits(inverse)
    rows = [
        (*(('', '') if k else (fit.joint, fit.form)), *cells)
        for fit in fits
        for k, cells in enumerate(_rows(fit))
    ]
    columns = {'joint': 'w', 'inverse model': 'w', **_COLUMNS}
    remarks = [f'{fit.joint}, {fit.form}: {_rest(fit)}' for fit in fits]
    remarks += [f'{joint}: no inverse model: {why}' for joint, why in inverse.unavailable.items()]
    text = Text('\n'.join([*remarks, *_by_weak_form(analysis)]))
    return Group(terminal_table(columns, rows, sections=True), text)


def inverse_section(analysis: BagAnalysis, inverse: InverseFits) -> str:
    """Return the part of the report that shows the fits, HTML."""
    parts = [heading('Inertia and friction by the inverse model'), paragraph(_METHOD)]
    for fit in _fits(inverse):
        flags = [', '.join(map(words, p.flags)) for p in fit.parameters.values()]
        rows = [(*cells, text) for cells, text in zip(_rows(fit), flags, strict=True)]
        told = f'{fit.joint}, {fit.form}: {_rest(fit)}'
        parts.append(html_table({**_COLUMNS, 'flags': 'l'}, rows, told))
    lines = [f'Joint {joint} has none: {why}.' for joint, why in inverse.unavailable.items()]
    lines += [f'{text}.' for text in _by_weak_form(analysis)]
    return ''.join([*parts, *map(paragraph, lines)])


def _by_weak_form(analysis: BagAnalysis) -> Iterator[str]:
    for joint, fits in analysis.fit.joints.items():
        for fit in fits.values():
            if fit.inertia is not None:
                what = 'factor on its inertia' if fit.inertia.unit == '1' else 'inertia'
                unit = '' if fit.inertia.unit == '1' else f' {fit.inertia.unit}'
                yield (
                    f'{joint}, {observer_label(fit.observer).lower()}: {what} '
                    f'{value_text("inertia", fit.inertia)}{unit}, standard error '
                    f'{error_text(fit.inertia)}{unit}'
                )


def _fits(inverse: InverseFits) -> list[InverseFit]:
    return [fit for fits in inverse.joints.values() for fit in fits.values()]


def _rows(fit: InverseFit) -> list[tuple[str, ...]]:
    """Return name, unit, value, standard error and interval of each parameter."""
    return [
        (name, p.unit, value_text(name, p), error_text(p), interval_text(p))
        for name, p in fit.parameters.items()
    ]


def _rest(fit: InverseFit) -> str:
    std = format_number(fit.residual_std, 0.1 * fit.residual_std)
    return (
        f'leaves {std} {fit.unit} ({fit.relative_error:.2f} % of the effort) in {fit.samples} '
        f'samples, {fit.clusters} independent pieces'
    )
