# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fitted terms as files: the model folder, ``fit.json`` and the report."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sosml_friction.identification.free_armature import armature_sentence
from sosml_friction.identification.number_text import (
    error_text,
    format_number,
    interval_text,
    joint_text,
    value_text,
    words,
)
from sosml_friction.identification.term_fit import TermFit
from sosml_friction.identification.term_residual import along_axis
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common import output
from sosml_friction.report.common.figure import pictures
from sosml_friction.report.common.html_page import cards, facts, heading, page, verdict
from sosml_friction.report.common.table import html_table, terminal_table

FORMAT = 'sosml_friction/term_fit/1'
_FILES = ('robot.urdf', 'model.yaml', 'report.html', 'fit.json')
KIND = output.OutputKind('fit of terms', 'fit.json', FORMAT, _FILES)


COLUMNS = {
    'joint': 'w', 'term': '', 'parameter': '', 'value': 'n', 'standard error': 'n',
    '95 % interval': 'n', 'unit': '', 'remark': '',
}  # fmt: skip
EFFORT_COLUMNS = {'joint': 'w', 'effort': 'n', 'without': 'n', 'with': 'n', 'unit': ''}


def term_fit_document(fit: TermFit, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the object of ``sosml fit --terms --json``: docs/schema/term_fit.schema.json."""
    return to_plain({'format': FORMAT, **fit.to_dict(), 'provenance': provenance})


def render_terms(fit: TermFit, title: str, told: Mapping[str, str] | None = None) -> str:
    """Return the report as one HTML document, pictures included."""
    label = 'Some terms could not be fitted' if fit.left else f'{len(fit.terms)} terms fitted'
    parts = [
        facts({'Model': fit.model.name, 'Joints': ', '.join(fit.names), **(told or {})}),
        verdict('open' if fit.left else 'good', label, sentences(fit)),
        heading('Parameters', 3),
        html_table(COLUMNS, term_rows(fit)),
        heading('Effort in the band, root mean square', 3),
        html_table(EFFORT_COLUMNS, effort_rows(fit)),
        heading('Each term over its axis'),
    ]
    drawn = [pictures('terms', view) for term in fit.terms for view in along_axis(fit, term)]
    return page(title, [*parts, cards(drawn)])


def figure_views(fit: TermFit) -> dict[str, object]:
    """Return what the figures draw, by the names that their files begin with."""
    return {
        f'{view.joint}_{term.term}': view for term in fit.terms for view in along_axis(fit, term)
    }


def write_term_fit(
    folder: str | Path,
    fit: TermFit,
    provenance: Mapping[str, Any],
    step: Callable[[str], None] = lambda text: None,
) -> Path:
    """
    Write the model folder with report.html and fit.json, and return it.

    :raises ConfigurationError: if the folder holds something else or cannot be written.
    """
    folder = output.check_output_folder(folder, KIND)
    with output.written_together(folder, KIND) as workshop:
        fit.model.write(workshop)
        step('drawing the report')
        bags = ', '.join(entry['bag'] for entry in provenance.get('bags', ()))
        title = f'Terms of {fit.model.name}' + (f' in {bags}' if bags else '')
        document = term_fit_document(fit, provenance)
        told = {
            'Recording': bags,
            'Fitted': str(provenance.get('fitted', ''))[:16].replace('T', ' '),
        }
        output.write_result(workshop, KIND, document, render_terms(fit, title, told))
    return folder


def term_rows(fit: TermFit) -> list[tuple[str, ...]]:
    """Return a row for each parameter."""
    return [
        (
            joint_text(term.joint),
            words(term.term),
            words(name),
            value_text(name, p),
            error_text(p) if math.isfinite(p.std_error) else '',
            interval_text(p),
            p.unit,
            '; '.join(filter(None, (p.reason, term.objection))),
        )
        for term in fit.terms
        for name, p in term.parameters.items()
    ]


def effort_rows(fit: TermFit) -> list[tuple[str, ...]]:
    """Return by joint the effort, and what is left of it without and with the terms."""
    return [
        (
            name,
            *(format_number(float(x[i])) for x in (fit.measured, fit.before, fit.after)),
            fit.units[i],
        )
        for i, name in enumerate(fit.names)
    ]


def term_blocks(fit: TermFit) -> list[Any]:
    """Return what the terminal shows: sentences and the table of parameters."""
    return [*sentences(fit), terminal_table(COLUMNS, term_rows(fit))]


def sentences(fit: TermFit) -> list[str]:
    """Return what was fitted, and what was left out and why."""
    parts = [
        f'{name} {100.0 * fit.before[i] / fit.measured[i]:.3g} -> '
        f'{100.0 * fit.after[i] / fit.measured[i]:.3g} %'
        for i, name in enumerate(fit.names)
        if fit.measured[i] > 0.0
    ]
    told = [
        f'{len(fit.terms)} terms were fitted together, with one covariance of all that is free. '
        f'Effort that is not explained, without the terms and with them: {", ".join(parts)}.'
    ]
    told += [f'Left out: {why}.' for why in dict.fromkeys(fit.left.values())]
    return told + [f'{armature_sentence(n, p)}.' for n, p in fit.armature.items()]
