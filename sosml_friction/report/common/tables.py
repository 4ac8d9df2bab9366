# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tables for the terminal."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from sosml_friction.identification.bag_analysis import BagAnalysis
from sosml_friction.identification.output_error.fits import OUTPUT_ERROR
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.common.labels import SYMBOLS, in_order, observer_label, symbols_of
from sosml_friction.report.common.number_text import UNKNOWN, error_text, format_number, value_text
from sosml_friction.report.fit.findings import sampling_text
from sosml_friction.report.fit.joint_view import JointView, joint_views

#: Width of a table that is not printed to a terminal.
_PLAIN_WIDTH = 100
#: More observers than this are rows instead of columns.
_MOST_COLUMNS = 3


def print_table(table: RenderableType) -> None:
    """Print a table on stdout, at a fixed width where stdout is no terminal."""
    console = Console(width=None if sys.stdout.isatty() else _PLAIN_WIDTH, highlight=False)
    console.print(table)


def parameter_table(
    analysis: BagAnalysis, truth: RobotModelFile | None = None, truth_heading: str = 'truth'
) -> RenderableType:
    """
    Return the friction parameters of every joint beside the truth, where that is known.

    A parameter that is not identifiable is a range or a dash, never a number. The standard error
    is that of the observer whose fit becomes the model, the last column but one.

    :param truth: a model whose friction is known to be that of the robot.
    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    views = joint_views(analysis, truth)
    observers = in_order(o for view in views for o in view.fits)
    if len(observers) > _MOST_COLUMNS:
        return Group(
            _table_by_observer(views, truth_heading),
            Text(f'{_caption(views)}\n{sampling_text(analysis.log)}'),
        )
    preferred = {view.preferred for view in views if view.preferred}
    whose = observer_label(preferred.pop()) if len(preferred) == 1 else 'of the model'
    table = Table(
        box=box.SIMPLE,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    table.add_column('joint', no_wrap=True)
    table.add_column('parameter', no_wrap=True)
    table.add_column('unit', no_wrap=True)
    if truth is not None:
        table.add_column(truth_heading, justify='right')
    for observer in observers:
        table.add_column(observer_label(observer), justify='right', overflow='fold')
    table.add_column(f'std error\n({whose})', justify='right', overflow='fold')
    for view in views:
        _add_joint(table, view, observers, truth is not None)
    # Not the table's caption, which would wrap at the width of the table.
    return Group(table, Text(f'{_caption(views)}\n{sampling_text(analysis.log)}'))


def _table_by_observer(views: Sequence[JointView], truth_heading: str) -> Table:
    """Return a row for each joint and observer: more observers than columns fit side by side."""
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column('joint', no_wrap=True)
    table.add_column('observer', no_wrap=True)
    for symbol in SYMBOLS.values():
        table.add_column(symbol, justify='right', no_wrap=True)
    for view in views:
        if view.preferred is None:
            table.add_row(view.name, 'unavailable', end_section=True)
            continue
        rows = []
        if view.truth is not None:
            known = view.truth.parameters
            rows.append(
                (
                    truth_heading,
                    [f'{known[n].value:.4g}' if n in known else UNKNOWN for n in SYMBOLS],
                )
            )
        for observer, fit in view.fits.items():
            cells = [value_text(name, fit.fit.parameters[name]) for name in SYMBOLS]
            mark = ' (the model)' if observer == view.preferred else ''
            rows.append((observer_label(observer) + mark, cells))
        for k, (label, cells) in enumerate(rows):
            name = view.name if k == 0 else ''
            table.add_row(name, label, *cells, end_section=k == len(rows) - 1)
    return table


def _add_joint(table: Table, view: JointView, observers: Sequence[str], with_truth: bool) -> None:
    if view.preferred is None:
        table.add_row(view.name, 'unavailable', end_section=True)
        return
    chosen = view.fits[view.preferred].fit.parameters
    names = list(symbols_of(*(fit.fit.parameters for fit in view.fits.values())))
    for name in names:
        parameter = chosen.get(name)
        unit = next(p.unit for fit in view.fits.values() if (p := fit.fit.parameters.get(name)))
        cells = [view.name if name == names[0] else '', name, unit]
        if with_truth:
            known = view.truth.parameters.get(name) if view.truth else None
            cells.append(UNKNOWN if known is None else f'{known.value:.4g}')
        for observer in observers:
            fit = view.fits.get(observer)
            told = None if fit is None else fit.fit.parameters.get(name)
            cells.append(UNKNOWN if told is None else value_text(name, told))
        cells.append(UNKNOWN if parameter is None else error_text(parameter))
        table.add_row(*cells, end_section=name == names[-1])


def _caption(views: Sequence[JointView]) -> str:
    lines = []
    for view in views:
        if view.preferred is None:
            lines.append(f'{view.name}: {view.unavailable}')
            continue
        fit = view.fits[view.preferred]
        lines.append(
            f'{view.name}: fitted to {method_text(view)}; the law leaves '
            f'{format_number(fit.fit.residual_std, 0.1 * fit.fit.residual_std)} {fit.unit} '
            f'({fit.fit.relative_error:.1f} %)'
        )
    return '\n'.join(lines)


def method_text(view: JointView) -> str:
    """Return what the fits of a joint were made to, in words with counts."""
    fit = view.fits[view.preferred or next(iter(view.fits))]
    if fit.method == 'segments':
        return f'the levels of {fit.fit.pairs} steady windows'
    if fit.method == 'weak':
        return f'{fit.fit.pairs} means of position and effort, without an observer'
    if fit.method == OUTPUT_ERROR:
        return f'{fit.fit.pairs} samples of a forward simulation'
    return f'{fit.fit.pairs} samples in motion'


def information_table(information: Mapping[str, Any]) -> Table:
    """Return the topics of a bag: name, type, messages."""
    table = Table(box=box.SIMPLE, pad_edge=False)
    table.add_column('topic', overflow='fold')
    table.add_column('type', overflow='fold')
    table.add_column('messages', justify='right')
    for name, topic in information['topics'].items():
        table.add_row(name, topic['type'] or 'unknown', str(topic['messages']))
    return table
