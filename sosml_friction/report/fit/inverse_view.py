# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The inverse-model fit of an analysis as rows of a table, and as a part of the report."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from sosml_friction.identification.bag_analysis import BagAnalysis
from sosml_friction.identification.inverse_model import InverseFit, InverseFits
from sosml_friction.report.common.html_page import number_cell
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.number_text import (
    error_text,
    format_number,
    interval_text,
    value_text,
)

_METHOD = (
    'Inertia and friction are fitted together to the effort, without an observer: position is '
    'filtered forwards and backwards and differentiated twice, and both sides are decimated '
    'alike. Symmetric: one Coulomb and one viscous term and a bias; asymmetric: one of each by '
    'direction of motion. The model written beside this keeps the inertia it had.'
)


def inverse_table(analysis: BagAnalysis, inverse: InverseFits) -> RenderableType:
    """
    Return the fits for the terminal: a parameter a row, what is left of the effort below.

    Below that also the inertia that the weak form found, where it was asked.
    """
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ('joint', 'inverse model', 'parameter', 'unit'):
        table.add_column(heading, no_wrap=True)
    for heading in ('value', 'standard error', '95 % interval'):
        table.add_column(heading, justify='right')
    for fit in _fits(inverse):
        for k, cells in enumerate(_rows(fit)):
            head = ('', '') if k else (fit.joint, fit.form)
            table.add_row(*head, *cells, end_section=k == len(fit.parameters) - 1)
    remarks = [f'{fit.joint}, {fit.form}: {_rest(fit)}' for fit in _fits(inverse)]
    remarks += [f'{joint}: no inverse model: {why}' for joint, why in inverse.unavailable.items()]
    return Group(table, Text('\n'.join([*remarks, *_by_weak_form(analysis)])))


def inverse_section(analysis: BagAnalysis, inverse: InverseFits) -> str:
    """Return the part of the report that shows the fits, HTML."""
    parts = ['<h2>Inertia and friction by the inverse model</h2>', f'<p>{escape(_METHOD)}</p>']
    for fit in _fits(inverse):
        rows = ''.join(
            f'<tr><td class="w">{escape(name)}</td><td class="w">{escape(unit)}</td>'
            + ''.join(number_cell(text) for text in numbers)
            + f'<td class="l">{escape(", ".join(_flags(fit, name)))}</td></tr>'
            for name, unit, *numbers in _rows(fit)
        )
        parts.append(
            f'<div class="wide"><table><caption>{escape(fit.joint)}, {fit.form}: '
            f'{escape(_rest(fit))}</caption><thead><tr><th>parameter</th><th>unit</th>'
            '<th class="n">value</th><th class="n">standard error</th>'
            '<th class="n">95 % interval</th><th class="l">flags</th></tr></thead>'
            f'<tbody>{rows}</tbody></table></div>'
        )
    parts += [
        f'<p>Joint {escape(joint)} has none: {escape(why)}.</p>'
        for joint, why in inverse.unavailable.items()
    ]
    parts += [f'<p>{escape(text)}.</p>' for text in _by_weak_form(analysis)]
    return ''.join(parts)


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


def _fits(inverse: InverseFits) -> Iterator[InverseFit]:
    for fits in inverse.joints.values():
        yield from fits.values()


def _rows(fit: InverseFit) -> Iterator[tuple[str, str, str, str, str]]:
    """Yield name, unit, value, standard error and interval of each parameter."""
    for name, parameter in fit.parameters.items():
        yield (
            name,
            parameter.unit,
            value_text(name, parameter),
            error_text(parameter),
            interval_text(parameter),
        )


def _flags(fit: InverseFit, name: str) -> list[str]:
    return [flag.replace('_', ' ') for flag in fit.parameters[name].flags]


def _rest(fit: InverseFit) -> str:
    std = format_number(fit.residual_std, 0.1 * fit.residual_std)
    return (
        f'leaves {std} {fit.unit} ({fit.relative_error:.2f} % of the effort) in {fit.samples} '
        f'samples, {fit.clusters} independent pieces'
    )
