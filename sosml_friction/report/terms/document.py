# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fitted terms as files: the model folder, ``fit.json`` and the report."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from sosml_friction.identification.term_fit import TermFit
from sosml_friction.identification.term_residual import along_axis
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.figure import pictures
from sosml_friction.report.common.html_page import cards, facts, heading, page, verdict
from sosml_friction.report.common.output import (
    OutputKind,
    check_output_folder,
    write_result,
    written_together,
)
from sosml_friction.report.common.table import html_table
from sosml_friction.report.terms.rows import (
    COLUMNS,
    EFFORT_COLUMNS,
    effort_rows,
    sentences,
    term_rows,
)

FORMAT = 'sosml_friction/term_fit/1'
FILES = ('robot.urdf', 'model.yaml', 'report.html', 'fit.json')
KIND = OutputKind('fit of terms', 'fit.json', FORMAT, FILES)


def term_fit_document(fit: TermFit, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the object of ``sosml fit --terms --json``: docs/schema/term_fit.schema.json."""
    return to_plain({'format': FORMAT, **fit.to_dict(), 'provenance': provenance})


def render_terms(fit: TermFit, title: str, told: Mapping[str, str] | None = None) -> str:
    """
    Return the report as one HTML document, pictures included.

    :param told: more of what it is about, such as the recordings.
    """
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
    folder = check_output_folder(folder, KIND)
    with written_together(folder, KIND) as workshop:
        fit.model.write(workshop)
        step('drawing the report')
        bags = ', '.join(entry['bag'] for entry in provenance.get('bags', ()))
        title = f'Terms of {fit.model.name}' + (f' in {bags}' if bags else '')
        document = term_fit_document(fit, provenance)
        told = {
            'Recording': bags,
            'Fitted': str(provenance.get('fitted', ''))[:16].replace('T', ' '),
        }
        write_result(workshop, KIND, document, render_terms(fit, title, told))
    return folder
