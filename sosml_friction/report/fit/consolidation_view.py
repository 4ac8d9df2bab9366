# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What several recordings say together, as sentences, rows and tables."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from sosml_friction.identification.several.bags_analysis import BagsAnalysis
from sosml_friction.identification.several.consolidation import (
    BY_RULE,
    JOINT,
    Consolidated,
    Consolidation,
)
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.report.common.drawing import Style, bag_style
from sosml_friction.report.common.html_page import number_cell
from sosml_friction.report.common.labels import SYMBOLS, observer_label
from sosml_friction.report.common.number_text import UNKNOWN, error_text, interval_text, value_text
from sosml_friction.report.fit.findings import law_remarks, law_sentence, missed_truths
from sosml_friction.report.fit.joint_section import name_cell
from sosml_friction.report.fit.parameter_figure import ParameterRow

#: How the two ways are called and drawn.
WAYS = {JOINT: 'joint fit', BY_RULE: "paper's rule"}
_STYLES = {
    JOINT: Style('#000000', 'D', '-', 1.8),
    BY_RULE: Style('#666666', 's', '-', 1.8),
}


def model_entry(consolidation: Consolidation, joint: str) -> Consolidated | None:
    """Return what became the model of a joint, None where there is nothing."""
    observer = consolidation.model.get(joint)
    return None if observer is None else consolidation.joints[joint][observer]


def bag_name(consolidation: Consolidation, bag: str) -> str:
    """Return a recording's label with its role, where it has one."""
    role = consolidation.roles.get(bag)
    return f'{bag} ({role.role})' if role is not None and role.role else bag


def consolidated_sentence(entry: Consolidated) -> str:
    """Return the result of one joint in a sentence with its numbers."""
    text = law_sentence(entry.joint, entry.parameters, entry.law)
    return (
        f'{text} ({observer_label(entry.observer)}, {WAYS[entry.preferred]}, ± is half of the '
        '95 % interval).'
    )


def consolidated_remarks(
    entry: Consolidated, truth: FrictionParameters | None = None
) -> list[str]:
    """Return what a reader should know before using the numbers, sentences with full stops."""
    remarks = [entry.reason] if entry.reason else []
    if entry.preferred == JOINT and entry.joint_fit is not None:
        remarks += law_remarks(entry.joint_fit)
    missed = missed_truths(entry.parameters, {} if truth is None else truth.parameters)
    if missed:
        remarks.append(f'The truth is outside the 95 % interval of {", ".join(missed)}.')
    if entry.rule.reason:
        remarks.append(f'{entry.rule.reason.rstrip(".")}.')
    remarks += [f'{bag}: {why.rstrip(".")}.' for bag, why in entry.unavailable.items() if why]
    return [f'{entry.joint}: {remark}' for remark in remarks]


def consolidated_rows(consolidation: Consolidation, entry: Consolidated) -> list[ParameterRow]:
    """Return the rows of a joint: each recording alone, the paper's rule, the joint fit."""
    rows = [
        ParameterRow(
            bag_name(consolidation, bag),
            entry.fits[bag].fit.parameters,
            bag_style(k),
        )
        for k, bag in enumerate(consolidation.bags)
        if bag in entry.fits
    ]
    ways: dict[str, Mapping[str, Parameter]] = {BY_RULE: entry.rule.parameters}
    if entry.joint_fit is not None:
        ways[JOINT] = entry.joint_fit.parameters
    for way, parameters in ways.items():
        chosen = way == entry.preferred
        if parameters:
            rows.append(
                ParameterRow(
                    WAYS[way],
                    entry.parameters if chosen else parameters,
                    _STYLES[way],
                    is_model=chosen,
                )
            )
    return rows


def consolidated_table(
    consolidation: Consolidation, entry: Consolidated, truth: FrictionParameters | None
) -> str:
    """Return a row per recording and way, a column per parameter, HTML."""
    head = ''.join(
        f'<th class="g l" colspan="2">{escape(symbol)} [{escape(_unit(entry, name))}]</th>'
        for name, symbol in SYMBOLS.items()
    )
    columns = '<th class="n l">value</th><th class="n">standard error</th>' * len(SYMBOLS)
    body = []
    for row in consolidated_rows(consolidation, entry):
        cells = ''.join(
            number_cell(UNKNOWN if p is None else value_text(name, p), 'n l')
            + number_cell(UNKNOWN if p is None else error_text(p))
            for name in SYMBOLS
            for p in [row.parameters.get(name)]
        )
        label = f'<strong>{escape(row.label)}</strong>' if row.is_model else escape(row.label)
        body.append(f'<tr><td class="w">{label}</td>{cells}</tr>')
    if truth is not None:
        known = truth.parameters
        cells = ''.join(
            number_cell(f'{known[name].value:.4g}' if name in known else UNKNOWN, 'n l')
            + number_cell('')
            for name in SYMBOLS
        )
        body.append(f'<tr><td class="w">truth</td>{cells}</tr>')
    return (
        f'<div class="wide"><table><thead><tr><th rowspan="2">from</th>{head}</tr>'
        f'<tr>{columns}</tr></thead><tbody>{"".join(body)}</tbody></table></div>'
    )


def model_table(entry: Consolidated, truth: FrictionParameters | None) -> str:
    """Return the parameters of the model with intervals, sources, flags and reasons, HTML."""
    rows = []
    for name, symbol in SYMBOLS.items():
        parameter = entry.parameters.get(name)
        if parameter is None:
            continue
        sources = (
            ', '.join(entry.rule.sources.get(name, ())) if entry.preferred == BY_RULE else 'all'
        )
        why = '; '.join(
            part
            for part in (
                ', '.join(flag.replace('_', ' ') for flag in parameter.flags),
                parameter.reason,
                parameter.experiment,
            )
            if part
        )
        known = None if truth is None else truth.parameters.get(name)
        rows.append(
            f'<tr>{name_cell(name, symbol)}<td class="w">{escape(parameter.unit)}</td>'
            + number_cell(value_text(name, parameter), 'n l')
            + number_cell(error_text(parameter))
            + number_cell(interval_text(parameter))
            + ('' if truth is None else number_cell(f'{known.value:.4g}' if known else UNKNOWN))
            + f'<td class="l">{escape(sources)}</td><td>{escape(why)}</td></tr>'
        )
    truth_head = '' if truth is None else '<th class="n">truth</th>'
    return (
        '<div class="wide"><table><thead><tr><th>parameter</th><th>unit</th>'
        '<th class="n l">value</th><th class="n">standard error</th>'
        f'<th class="n">95 % interval</th>{truth_head}<th class="l">from</th><th>flags</th></tr>'
        f'</thead><tbody>{"".join(rows)}</tbody></table></div>'
    )


def _unit(entry: Consolidated, name: str) -> str:
    known = [fit.fit.parameters[name].unit for fit in entry.fits.values()]
    if entry.joint_fit is not None:
        known.append(entry.joint_fit.parameters[name].unit)
    return next(iter(known), '')


def _cell(name: str, parameter: Parameter | None) -> str:
    """Return the value, and on a line below it the 95 % interval, where it has one."""
    if parameter is None:
        return UNKNOWN
    interval = interval_text(parameter)
    value = value_text(name, parameter)
    # One line of a narrow column, or it wraps.
    return value if interval == UNKNOWN else f'{value}\n{interval.replace(" to ", "..")}'


def bags_answers(analysis: BagsAnalysis) -> list[str]:
    """Return what was found, a sentence per joint: what a reader came for."""
    consolidation = analysis.consolidation
    sentences = []
    for joint in analysis.model.joint_names:
        entry = model_entry(consolidation, joint)
        if entry is not None:
            sentences.append(consolidated_sentence(entry))
            continue
        why = consolidation.unavailable.get(joint, 'no bag has an estimate of its friction')
        sentences.append(f'{joint}: its friction is not available, because {why}.')
    return sentences


def bags_table(analysis: BagsAnalysis, truth: RobotModelFile | None = None) -> RenderableType:
    """
    Return the terminal's table of several recordings: each alone, then the ways to join them.

    Below each value is its 95 % interval; a parameter that is not identifiable is a range or the
    words, never a number. A star marks what became the model.

    :param truth: a model whose friction is known to be that of the robot.
    """
    consolidation = analysis.consolidation
    parts: list[RenderableType] = []
    remarks = []
    for joint in analysis.model.joint_names:
        entry = model_entry(consolidation, joint)
        if entry is None:
            why = consolidation.unavailable.get(joint, 'no bag has an estimate of its friction')
            remarks.append(f'{joint}: unavailable, {why}')
            continue
        table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
        table.add_column(Text(f'{joint}\n({observer_label(entry.observer)})'))
        for name, symbol in SYMBOLS.items():
            heading = Text(f'{symbol}\n[{_unit(entry, name)}]')
            table.add_column(heading, justify='right', overflow='fold')
        for row in consolidated_rows(consolidation, entry):
            cells = [_cell(name, row.parameters.get(name)) for name in SYMBOLS]
            table.add_row(('* ' if row.is_model else '') + row.label, *cells)
        own = None if truth is None else truth.joints.get(joint)
        known = None if own is None else own.friction
        if known is not None:
            values = known.parameters
            table.add_row(
                'truth', *(f'{values[n].value:.4g}' if n in values else UNKNOWN for n in SYMBOLS)
            )
        parts.append(table)
        remarks += consolidated_remarks(entry, known)
    legend = ['*: the model; below each value its 95 % interval, low..high'] if parts else []
    return Group(*parts, Text('\n'.join([*legend, *remarks])))
