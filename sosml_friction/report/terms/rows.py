# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fitted terms as rows of a table, for the terminal and the page."""

import math

from sosml_friction.identification.free_armature import armature_sentence
from sosml_friction.identification.number_text import (
    error_text,
    format_number,
    interval_text,
    value_text,
    words,
)
from sosml_friction.identification.term_fit import TermFit

COLUMNS = {
    'joint': 'w', 'term': '', 'parameter': '', 'value': 'n', 'standard error': 'n',
    '95 % interval': 'n', 'unit': '', 'remark': '',
}  # fmt: skip
EFFORT_COLUMNS = {'joint': 'w', 'effort': 'n', 'without': 'n', 'with': 'n', 'unit': ''}


def term_rows(fit: TermFit) -> list[tuple[str, ...]]:
    """Return a row for each parameter."""
    return [
        (
            'all joints' if term.joint == '*' else term.joint,
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
