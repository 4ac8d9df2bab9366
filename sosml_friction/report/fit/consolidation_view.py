# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What several recordings say together, as sentences, rows and tables."""

import math
from collections.abc import Mapping
from html import escape
from typing import NamedTuple

from rich.console import Group, RenderableType
from rich.text import Text

from sosml_friction.identification.friction_fit import FrictionFit
from sosml_friction.identification.number_text import (
    UNKNOWN,
    error_text,
    interval_text,
    truth_text,
    value_text,
    words,
)
from sosml_friction.identification.parameter_interval import missed_truths
from sosml_friction.identification.several.bags_analysis import BagsAnalysis
from sosml_friction.identification.several.consolidation import (
    BY_RULE,
    JOINT,
    MEAN,
    Consolidated,
    Consolidation,
)
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.report.common.drawing import Style, bag_style
from sosml_friction.report.common.labels import SYMBOLS, observer_label
from sosml_friction.report.common.parameter_bars import ParameterRow
from sosml_friction.report.common.table import Markup, html_table, terminal_table
from sosml_friction.report.fit.findings import law_remarks, law_sentence
from sosml_friction.report.fit.joint_section import name_text

#: How the two ways are called and drawn.
WAYS = {JOINT: 'joint fit', BY_RULE: "paper's rule", MEAN: 'mean of bags'}
_STYLES = {
    JOINT: Style('#000000', 'D', '-', 1.8),
    BY_RULE: Style('#666666', 's', '-', 1.8),
    MEAN: Style('#000000', 'o', '-', 1.8),
}


class BagsJoint(NamedTuple):
    """Hold what several recordings say of one joint, and the fits of each by its label."""

    consolidation: Consolidation
    entry: Consolidated
    fits: Mapping[str, FrictionFit]
    truth: FrictionParameters | None = None

    @property
    def observer(self) -> str:
        """Return the short name of the observer of the model."""
        return observer_label(self.entry.observer)

    @property
    def known(self) -> Mapping[str, Parameter]:
        """Return the parameters of the truth, empty where it is not known."""
        return {} if self.truth is None else self.truth.parameters


def bags_joints(
    analysis: BagsAnalysis, truth: RobotModelFile | None = None
) -> dict[str, BagsJoint]:
    """Return the joints of which there is a result, in the order of the model."""
    told = analysis.consolidation
    fits = {bag: one.fit for bag, one in analysis.bags.items()}
    known = {} if truth is None else {n: joint.friction for n, joint in truth.joints.items()}
    return {
        joint: BagsJoint(told, told.joints[joint][observer], fits, known.get(joint))
        for joint in analysis.model.joint_names
        if (observer := told.model.get(joint)) is not None
    }


def bag_name(consolidation: Consolidation, bag: str) -> str:
    """Return a recording's label with its role, where it has one."""
    role = consolidation.roles[bag].role
    return f'{bag} ({role})' if role else bag


def consolidated_remarks(view: BagsJoint) -> list[str]:
    """Return what a reader should know before using the numbers, sentences with full stops."""
    entry = view.entry
    remarks = [entry.reason] if entry.reason else []
    if entry.preferred == JOINT and entry.joint_fit is not None:
        remarks += law_remarks(entry.joint_fit)
    missed = missed_truths(entry.parameters, view.known)
    if missed:
        remarks.append(f'The truth is outside the 95 % interval of {", ".join(missed)}.')
    reasons = {'': entry.rule.reason} | {f'{bag}: ': x for bag, x in entry.unavailable.items()}
    remarks += [f'{whose}{why.rstrip(".")}.' for whose, why in reasons.items() if why]
    return [f'{entry.joint}: {remark}' for remark in remarks]


def consolidated_rows(view: BagsJoint) -> list[ParameterRow]:
    """Return the rows of a joint: each recording alone, then the ways to join them."""
    consolidation, entry = view.consolidation, view.entry
    rows = [
        ParameterRow(bag_name(consolidation, bag), entry.fits[bag].fit.parameters, bag_style(k))
        for k, bag in enumerate(consolidation.bags)
        if bag in entry.fits
    ]
    ways: dict[str, Mapping[str, Parameter]] = {BY_RULE: entry.rule.parameters}
    if entry.joint_fit is not None:
        ways[JOINT] = entry.joint_fit.parameters
    if entry.preferred == MEAN:
        ways[MEAN] = entry.parameters
    for way, parameters in ways.items():
        chosen = way == entry.preferred
        shown = entry.parameters if chosen else parameters
        if parameters:
            rows.append(ParameterRow(WAYS[way], shown, _STYLES[way], is_model=chosen))
    return rows


def consolidated_table(view: BagsJoint) -> str:
    """Return a row per recording and way, a column per parameter with standard error, HTML."""
    columns = {'from': 'w'} | {f'{s} [{_unit(view, name)}]': 'n' for name, s in SYMBOLS.items()}
    rows = []
    for row in consolidated_rows(view):
        label = Markup(f'<strong>{escape(row.label)}</strong>') if row.is_model else row.label
        cells: list[str] = [label]
        for name in SYMBOLS:
            p = row.parameters.get(name)
            text = UNKNOWN if p is None else value_text(name, p)
            error = UNKNOWN if p is None else error_text(p)
            cells.append(text if error == UNKNOWN else f'{text} ({error})')
        rows.append(cells)
    return html_table(columns, rows + _truth_row(view), 'In brackets: standard errors.')


def model_table(view: BagsJoint) -> str:
    """Return the parameters of the model with intervals, sources, flags and reasons, HTML."""
    entry, known = view.entry, view.truth is not None
    columns = {'parameter': 'w', 'unit': 'w', 'value': 'n l', 'standard error': 'n',
               '95 % interval': 'n'}  # fmt: skip
    columns |= ({'truth': 'n'} if known else {}) | {'from': 'l', 'flags': ''}
    rows = []
    for name, symbol in SYMBOLS.items():
        p = entry.parameters.get(name)
        if p is None:
            continue
        sources = 'all'
        if entry.preferred == BY_RULE:
            sources = ', '.join(entry.rule.sources.get(name, ()))
        why = [', '.join(map(words, p.flags)), p.reason, p.experiment]
        row = [name_text(name, symbol), p.unit, value_text(name, p), error_text(p)]
        row += [interval_text(p), *([truth_text(view.known, name)] if known else [])]
        rows.append([*row, sources, '; '.join(filter(None, why))])
    return html_table(columns, rows)


def _truth_row(view: BagsJoint) -> list[list[str]]:
    if view.truth is None:
        return []
    return [['truth', *(truth_text(view.known, name) for name in SYMBOLS)]]


def _unit(view: BagsJoint, name: str) -> str:
    entry = view.entry
    laws = [fit.fit for fit in entry.fits.values()]
    return next((x.parameters[name].unit for x in (*laws, entry.joint_fit) if x is not None), '')


def _cell(name: str, parameter: Parameter | None) -> str:
    """Return the value, and on a line below it the 95 % interval, where it has one."""
    if parameter is None:
        return UNKNOWN
    interval = interval_text(parameter)
    value = value_text(name, parameter)
    # One line of a narrow column, or it wraps.
    return value if interval == UNKNOWN else f'{value}\n{interval.replace(" to ", "..")}'


def _why_not(analysis: BagsAnalysis, joint: str) -> str:
    told = analysis.consolidation.unavailable
    return told.get(joint, 'no bag has an estimate of its friction')


def bags_answers(analysis: BagsAnalysis) -> list[str]:
    """Return what was found, a sentence per joint: what a reader came for."""
    views = bags_joints(analysis)
    sentences = []
    for joint in analysis.model.joint_names:
        if joint not in views:
            why = _why_not(analysis, joint)
            sentences.append(f'{joint}: its friction is not available, because {why}.')
            continue
        entry = views[joint].entry
        slowest = math.nan if entry.joint_fit is None else entry.joint_fit.slowest
        sentences.append(
            f'{law_sentence(joint, entry.parameters, entry.law, slowest)} '
            f'({views[joint].observer}, {WAYS[entry.preferred]}, ± is half of the 95 % interval).'
        )
    return sentences


def bags_table(analysis: BagsAnalysis, truth: RobotModelFile | None = None) -> RenderableType:
    """
    Return the terminal's table of several recordings: each alone, then the ways to join them.

    Below each value is its 95 % interval; a parameter that is not identifiable is a range or the
    words, never a number. A star marks what became the model.
    """
    views = bags_joints(analysis, truth)
    parts: list[RenderableType] = []
    remarks = []
    for joint in analysis.model.joint_names:
        if joint not in views:
            remarks.append(f'{joint}: unavailable, {_why_not(analysis, joint)}')
            continue
        view = views[joint]
        columns = {f'{joint}\n({view.observer})': ''}
        columns |= {f'{s}\n[{_unit(view, name)}]': 'n' for name, s in SYMBOLS.items()}
        rows = [
            [
                ('* ' if row.is_model else '') + row.label,
                *(_cell(name, row.parameters.get(name)) for name in SYMBOLS),
            ]
            for row in consolidated_rows(view)
        ]
        parts.append(terminal_table(columns, rows + _truth_row(view)))
        remarks += consolidated_remarks(view)
    legend = ['*: the model; below each value its 95 % interval, low..high'] if parts else []
    return Group(*parts, Text('\n'.join([*legend, *remarks])))
