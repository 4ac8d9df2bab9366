# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the terminal shows of a fit."""

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.number_text import (
    NOT_IDENTIFIABLE_TEXT,
    UNKNOWN,
    error_text,
    format_number,
    truth_text,
    value_text,
)
from sosml_friction.identification.several.bags_analysis import BagsAnalysis
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.report.common import labels
from sosml_friction.report.common.table import terminal_table
from sosml_friction.report.fit import findings
from sosml_friction.report.fit.consolidation_view import bags_answers, bags_table
from sosml_friction.report.fit.joint_view import JointView, joint_views

#: More observers than this are rows instead of columns.
_MOST_COLUMNS = 3


def summary_blocks(
    analysis: BagAnalysis | BagsAnalysis, truth: RobotModelFile | None = None
) -> list[str | RenderableType]:
    """Return what was found: a sentence per joint, the bodies, the table, and what is open."""
    if isinstance(analysis, BagsAnalysis):
        bodies = findings.body_sentences(next(iter(analysis.bags.values())).body)
        return [*bags_answers(analysis), *bodies, bags_table(analysis, truth)]
    views = joint_views(analysis, truth)
    found = [*map(findings.joint_sentence, views), *findings.body_sentences(analysis.body)]
    return [*found, parameter_table(analysis, truth), *findings.caveats(views)]


def parameter_table(
    analysis: BagAnalysis, truth: RobotModelFile | None = None, truth_heading: str = 'truth'
) -> RenderableType:
    """
    Return the friction parameters of every joint beside the truth, where that is known.

    A parameter that is not identifiable is a range or a dash, never a number. The standard error
    is that of the observer whose fit becomes the model, the last column but one.

    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    views = joint_views(analysis, truth)
    observers = labels.in_order(o for view in views for o in view.fits)
    heading = truth_heading if truth is not None else ''
    if len(observers) > _MOST_COLUMNS:
        table = _by_observer(views, heading)
    else:
        table = _by_parameter(views, observers, heading)
    # Not the table's caption, which would wrap at the width of the table.
    lines = [*map(_fitted_to, views), findings.sampling_text(analysis.log)]
    return Group(table, Text('\n'.join(lines)))


def _by_observer(views: Sequence[JointView], truth_heading: str) -> Table:
    """Return a row for each joint and observer: more observers than columns fit side by side."""
    rows: list[Sequence[str]] = []
    for view in views:
        if view.preferred is None:
            rows.append((view.name, 'unavailable', *[''] * len(labels.SYMBOLS)))
            continue
        mine = []
        if view.truth is not None:
            mine.append((truth_heading, *(truth_text(view.known, n) for n in labels.SYMBOLS)))
        for observer, fit in view.fits.items():
            mark = ' (model)' if observer == view.preferred else ''
            cells = [_cell(name, fit.fit.parameters[name]) for name in labels.SYMBOLS]
            mine.append((labels.observer_label(observer) + mark, *cells))
        rows += [(view.name if k == 0 else '', *row) for k, row in enumerate(mine)]
    columns = {'joint': 'w', 'observer': 'w', **dict.fromkeys(labels.SYMBOLS.values(), 'n w')}
    return terminal_table(columns, rows, sections=True)


def _by_parameter(
    views: Sequence[JointView], observers: Sequence[str], truth_heading: str
) -> Table:
    """Return a row for each joint and parameter, a column for each observer."""
    preferred = {view.preferred for view in views if view.preferred}
    whose = labels.observer_label(preferred.pop()) if len(preferred) == 1 else 'of the model'
    columns = {'joint': 'w', 'parameter': 'w', 'unit': ''}
    columns |= {truth_heading: 'n'} if truth_heading else {}
    columns |= {labels.observer_label(observer): 'n' for observer in observers}
    columns[f'std error\n({whose})'] = 'n'
    rows = []
    for view in views:
        if view.model is None:
            rows.append([view.name, 'unavailable', *[''] * (len(columns) - 2)])
            continue
        fits = {observer: fit.fit.parameters for observer, fit in view.fits.items()}
        for k, name in enumerate(labels.symbols_of(*fits.values())):
            known = {observer: p[name] for observer, p in fits.items() if name in p}
            unit = next(p.unit for p in known.values())
            row = [view.name if k == 0 else '', name, unit]
            row += [truth_text(view.known, name)] if truth_heading else []
            row += [_cell(name, known[o]) if o in known else UNKNOWN for o in observers]
            own = view.model.fit.parameters
            rows.append([*row, error_text(own[name]) if name in own else UNKNOWN])
    return terminal_table(columns, rows, sections=True)


def _cell(name: str, parameter: Parameter) -> str:
    """Return a value or a range, a dash where there is neither: words do not fit a column."""
    text = value_text(name, parameter)
    return UNKNOWN if text == NOT_IDENTIFIABLE_TEXT else text


def _fitted_to(view: JointView) -> str:
    """Return what the model of a joint was fitted to, and what its law leaves."""
    if view.model is None:
        return f'{view.name}: {view.unavailable}'
    fit = view.model
    to = labels.pairs_text(fit.method, fit.fit.pairs)
    std = format_number(fit.fit.residual_std, 0.1 * fit.fit.residual_std)
    return (
        f'{view.name}: fitted to {to}; the law leaves {std} {fit.unit} '
        f'({fit.fit.relative_error:.1f} %)'
    )
