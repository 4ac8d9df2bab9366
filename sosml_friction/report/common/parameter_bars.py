# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters with their intervals: a bar where there is a number, a range where there is none."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sosml_friction.identification.number_text import NOT_IDENTIFIABLE_TEXT, range_text, value_text
from sosml_friction.identification.parameter_interval import (
    NON_NEGATIVE,
    allowed_range,
    half_width,
)
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.common.drawing import (
    FONT,
    GREY,
    Style,
    key,
    label_axes,
    legend_below,
    new_figure,
)
from sosml_friction.report.common.labels import symbols_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Drawing

_MODEL_ROW = '#f1f6f3'
_ROW_IN = 0.36
#: End of a panel that has only ranges, as a multiple of the smallest upper end. Chosen, no
#: measurement.
_WIDEST = 4.0
#: Half width of a panel in median distances from the median; farther numbers are not in it.
#: Chosen, no measurement.
_FARTHEST = 12.0


class ParameterRow(NamedTuple):
    """
    Hold one row: where numbers come from, the numbers, and how they are drawn.

    ``in_use`` is drawn filled, else hollow; ``is_model`` says that the model has these numbers.
    """

    label: str
    parameters: Mapping[str, Parameter]
    style: Style
    in_use: bool = True
    is_model: bool = False


def draw_parameters(
    rows: Sequence[ParameterRow], truth: Mapping[str, Parameter] | None = None
) -> Drawing:
    """
    Draw each parameter of each row with its 95 % interval, and the truth if known.

    What is not identifiable has no marker: the bare range that the data allow, an arrow where it
    is open, or the words where they allow everything.
    """
    from matplotlib.ticker import FuncFormatter

    figure = new_figure(10.0, _ROW_IN * len(rows) + 1.3)
    symbols = symbols_of(*(row.parameters for row in rows))
    panels: Sequence[Axes] = figure.subplots(1, len(symbols), sharey=True)
    for axes, (name, symbol) in zip(panels, symbols.items(), strict=True):
        known = None if truth is None else truth.get(name)
        own = [row.parameters[name] for row in rows if name in row.parameters]
        label_axes(axes, f'{symbol} [{own[0].unit if own else ""}]', '')
        axes.set_xlim(_limits(name, own, known))
        for place, row in enumerate(rows):
            if row.is_model:
                axes.axhspan(place - 0.5, place + 0.5, color=_MODEL_ROW, zorder=0.1, linewidth=0)
            _draw_parameter(axes, place, name, row)
        if known is not None:
            axes.axvline(known.value, color='black', linestyle='--', linewidth=1.2, zorder=1.8)
        if any(_ends(name, p) for p in own) or known is not None:
            axes.locator_params(axis='x', nbins=3 if len(symbols) <= 5 else 2)
            # The axis is narrow: an offset or power beside it has no room.
            axes.xaxis.set_major_formatter(
                FuncFormatter(lambda value, _: f'{value:.5g}'.replace('-', '−'))
            )
        else:
            # Nothing to read off, but the height of a label, so that names are in line.
            axes.set_xticks([0.5], [' '], fontsize=FONT)
        axes.grid(False, axis='y')
        axes.tick_params(axis='y', length=0, pad=9)
    panels[0].set_yticks(range(len(rows)), [row.label for row in rows], fontsize=FONT)
    panels[0].set_ylim(len(rows) - 0.5, -0.5)
    legend_below(figure, _legend(rows, truth is not None))
    return figure


def _draw_parameter(axes: Axes, place: int, name: str, row: ParameterRow) -> None:
    parameter, colour = row.parameters.get(name), row.style.colour
    if parameter is None:
        _words(axes, place, 'no value')
        return
    left, right = axes.get_xlim()
    if NOT_IDENTIFIABLE in parameter.flags:
        allowed = allowed_range(name, parameter)
        if allowed is None:
            _words(axes, place, NOT_IDENTIFIABLE_TEXT)
        elif allowed[0] > right or allowed[1] < left:
            _beyond(axes, place, allowed[0] > right, range_text(name, parameter), colour)
        else:
            ends = [max(allowed[0], left), min(allowed[1], right)]
            axes.plot(ends, [place, place], color=colour, linewidth=7, alpha=0.3,
                      solid_capstyle='butt', zorder=2.0)  # fmt: skip
            _cut_ends(axes, place, allowed, colour)
    elif not math.isfinite(parameter.value):
        _words(axes, place, 'unknown')
    elif not left <= parameter.value <= right:
        _beyond(axes, place, parameter.value > right, value_text(name, parameter), colour)
    else:
        line: dict[str, Any] = {'color': colour, 'linewidth': 1.8, 'zorder': 2.2}
        if parameter.interval is not None:
            low, high = parameter.interval
            axes.plot([max(low, left), min(high, right)], [place, place], **line)
            for end in (low, high):
                if left <= end <= right:
                    axes.plot([end, end], [place - 0.17, place + 0.17], **line)
            _cut_ends(axes, place, parameter.interval, colour)
        axes.plot([parameter.value], [place], marker=row.style.marker, markersize=8, linestyle='',
                  color=colour, markerfacecolor=colour if row.in_use else 'white',
                  markeredgewidth=1.4, zorder=2.5)  # fmt: skip
        if AT_BOUND in parameter.flags:
            axes.annotate('at bound', (parameter.value, place), xytext=(8, 0), fontsize=FONT,
                          textcoords='offset points', color=GREY, va='center')  # fmt: skip


def _cut_ends(axes: Axes, place: int, ends: tuple[float, float], colour: str) -> None:
    """Let an arrow say that a line which is cut at the edge of the panel goes on."""
    left, right = axes.get_xlim()
    for end, edge, marker in ((ends[0], left, '<'), (ends[1], right, '>')):
        if not left <= end <= right:
            _arrow(axes, edge, place, marker, colour)


def _beyond(axes: Axes, place: int, above: bool, text: str, colour: str) -> None:
    """Write what lies outside of the panel at the edge it is beyond."""
    edge = axes.get_xlim()[1 if above else 0]
    _arrow(axes, edge, place, '>' if above else '<', colour)
    axes.annotate(text, (edge, place), xytext=(-8 if above else 8, 0), fontsize=FONT,
                  textcoords='offset points', color=colour, va='center', zorder=3,
                  ha='right' if above else 'left',
                  bbox={'facecolor': 'white', 'edgecolor': 'none', 'pad': 0.5})  # fmt: skip


def _arrow(axes: Axes, x: float, place: int, marker: str, colour: str) -> None:
    axes.plot([x], [place], marker=marker, markersize=6, color=colour, alpha=0.6, linestyle='',
              markeredgewidth=0, clip_on=False, zorder=2.1, gid='open end')  # fmt: skip


def _words(axes: Axes, place: int, text: str) -> None:
    axes.text(0.5, place, text, transform=axes.get_yaxis_transform(), color=GREY, fontsize=FONT,
              ha='center', va='center')  # fmt: skip


def _ends(name: str, parameter: Parameter) -> list[float]:
    """Return the finite ends of an interval or range, and the value where it is one."""
    if NOT_IDENTIFIABLE in parameter.flags:
        return [x for x in allowed_range(name, parameter) or () if math.isfinite(x)]
    return [x for x in (parameter.value, *(parameter.interval or ())) if math.isfinite(x)]


def _limits(name: str, own: Sequence[Parameter], known: Parameter | None) -> tuple[float, float]:
    """Let ranges that the data hardly bound run out of the panel rather than flatten the rest."""
    sure = [p for p in own if NOT_IDENTIFIABLE not in p.flags]
    numbers = [] if known is None else [known.value]
    numbers += [p.value for p in sure if math.isfinite(p.value)]
    ends = [x for p in own for x in _ends(name, p)]
    if not numbers and not ends:
        return 0.0, 1.0
    low, high = min([*numbers, *ends]), max([*numbers, *ends])
    if numbers:
        halves = [half_width(p) for p in sure if p.interval and np.isfinite(p.interval).all()]
        middle = float(np.median(numbers))
        typical = float(np.median(np.abs(np.array(numbers) - middle)))
        reach = _FARTHEST * max(typical, float(np.median(halves)) if halves else 0.0)
        reach = reach or max(numbers) - min(numbers) or abs(middle) or 1.0
        low, high = max(low, middle - reach), min(high, middle + reach)
    elif name in NON_NEGATIVE:
        high = min(high, _WIDEST * min((x for x in ends if x > 0.0), default=high))
    margin = 0.12 * (high - low) or 0.1 * abs(high) or 1.0
    return low - margin, high + margin


def _legend(rows: Sequence[ParameterRow], with_truth: bool) -> list[Any]:
    from matplotlib.patches import Patch

    handles: list[Any] = [key(color=GREY, linewidth=1.8, label='95 % interval')]
    if any(not row.in_use for row in rows):
        handles.append(
            key(linestyle='', marker='o', color=GREY, markerfacecolor='white',
                   label='the other method')
        )  # fmt: skip
    if any(row.is_model for row in rows):
        handles.append(Patch(color=_MODEL_ROW, linewidth=0, label='the model'))
    flags = {flag for row in rows for p in row.parameters.values() for flag in p.flags}
    if NOT_IDENTIFIABLE in flags:
        handles.append(key(color=GREY, linewidth=7, alpha=0.35, label='not identifiable: range'))
    if with_truth:
        handles.append(key(color='black', linestyle='--', label='truth'))
    return handles
