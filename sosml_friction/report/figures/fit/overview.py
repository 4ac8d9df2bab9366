# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The recording over time: the counterpart of the paper's Figure 5."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.patches import Patch

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law_residual import law_in_motion
from sosml_friction.report.common import drawing
from sosml_friction.report.common.drawing import FONT
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.fit.joint_view import JointView, shown_estimates
from sosml_friction.report.fit.segment_rows import SegmentRow, rejected_groups, segment_rows

_LAW, _REPORTED = 'black', '#b8b8b8'
_WIDTH_IN = 10.0
#: Height of a panel that has nothing to show, as a share of another's.
_UNKNOWN = 0.6
#: Share of the figure's width that the axes have, near enough to place marks.
_AXES_SHARE = 0.92


class Overview(Figure[JointView]):
    """Draw position, velocity, effort and friction over time, with the law's prediction."""

    identifier = 'overview'
    title = 'The recording over time'
    report = 'fit'
    order = 20
    caption = (
        'Overview of joint {view.name}: shaded windows are used, hatched ones are not; their '
        'numbers are those of the table of windows. The dashed line is the fitted law at the '
        'measured velocity, without the observers’ lag.'
    )

    def caption_of(self, view: JointView) -> str:
        """Say also which estimates are shown, where they are not all."""
        if view.preferred is None:
            return f'What was recorded of joint {view.name}.'
        text, shown = super().caption_of(view), shown_estimates(view)
        if len(shown) < len(view.estimates):
            labels = ', '.join(map(observer_label, shown))
            text += f' Shown of {len(view.estimates)} estimates: {labels}.'
        return text

    def draw(self, view: JointView) -> Drawing:
        effort = bool(np.isfinite(view.tau).any())
        friction = any(np.isfinite(x).any() for x in view.estimates.values())
        heights = [1.0, 1.0, 1.0 if effort else _UNKNOWN, 1.7 if friction else _UNKNOWN]
        figure = drawing.new_figure(_WIDTH_IN, 1.2 + 1.6 * sum(heights))
        axes: Sequence[Axes] = figure.subplots(4, 1, sharex=True, height_ratios=heights)
        time = view.time
        drawing.draw_line(axes[0], time, view.q, color='black', linewidth=1.0)
        reported = np.isfinite(view.v).any()
        if reported:
            drawing.draw_line(axes[1], time, view.v, color=_REPORTED, linewidth=0.8)
        drawing.draw_line(axes[1], time, view.speed, color='black', linewidth=1.0)
        drawing.draw_line(axes[2], time, view.tau, color='black', linewidth=0.8)
        handles, known = _draw_friction(axes[3], view)
        if reported:
            handles += [
                drawing.key(color=_REPORTED, linewidth=2.0, label='velocity, reported'),
                drawing.key(color='black', linewidth=1.0, label='velocity, position difference'),
            ]
        rows = segment_rows(view)
        handles += shade_segments(axes, rows)
        _robust_height(axes[3], known)
        names = ('position', 'velocity', 'effort', 'friction τ_f')
        units = (view.position_unit, view.velocity_unit, view.effort_unit, view.effort_unit)
        for axis, name, unit in zip(axes, names, units, strict=True):
            drawing.label_axes(axis, '', f'{name} [{unit}]')
            axis.margins(x=0.01)
        number_rejected(axes[0], rows, 72.0 * _WIDTH_IN * _AXES_SHARE)
        for axis, there in ((axes[2], effort), (axes[3], len(known) > 0)):
            if not there:
                axis.set_yticks([])
                axis.set_ylabel(axis.get_ylabel().replace(' [', '\n['), fontsize=drawing.FONT)
                axis.text(0.5, 0.5, 'unknown', transform=axis.transAxes, ha='center', va='center',
                          fontsize=drawing.FONT, color=drawing.GREY)  # fmt: skip
        if len(known):
            axes[3].axhline(0.0, color=drawing.GREY, linewidth=0.6)
        axes[3].set_xlabel('time [s]', fontsize=drawing.FONT)
        figure.align_ylabels(axes)
        if handles:
            drawing.legend_below(figure, handles)
        return figure


def _draw_friction(axes: Axes, view: JointView) -> tuple[list[Any], FloatArray]:
    """Draw the estimates and the law; return legend entries and all that is finite of them."""
    handles: list[Any] = []
    known = [np.zeros(0)]
    for place, observer in enumerate(shown_estimates(view)):
        tau_f = view.estimates[observer]
        if not np.isfinite(tau_f).any():
            continue
        known.append(tau_f[np.isfinite(tau_f)])
        colour = view.style(observer).colour
        drawing.draw_line(
            axes, view.time, tau_f, color=colour, linewidth=1.8 if place == 0 else 1.0
        )
        handles.append(drawing.key(color=colour, linewidth=2.0, label=observer_label(observer)))
    if view.model is not None and view.preferred is not None:
        predicted = law_in_motion(view.model.fit, view.q, view.speed, view.zero_band)
        if predicted is not None:
            known.append(predicted[np.isfinite(predicted)])
            drawing.draw_line(
                axes, view.time, predicted, color=_LAW, linewidth=1.0, linestyle='--'
            )
            text = f'law fitted to {observer_label(view.preferred)}'
            handles.append(drawing.key(color=_LAW, linewidth=1.0, linestyle='--', label=text))
    return handles, np.concatenate(known)


def _robust_height(axes: Axes, values: FloatArray) -> None:
    """Cut the height at a start-up spike that would flatten all the rest."""
    if not len(values):
        return
    low, high = (float(x) for x in np.quantile(values, (0.001, 0.999)))
    reach = max(high - low, 1e-12)
    low, high = max(low - reach, float(values.min())), min(high + reach, float(values.max()))
    axes.set_ylim(low - 0.06 * reach, high + 0.06 * reach)


#: Hatched as well as coloured: pale green and pale red are one colour to some.
USED: dict[str, Any] = {'facecolor': '#d3ebe0', 'edgecolor': 'none'}
REJECTED: dict[str, Any] = {
    'facecolor': '#faf0ec', 'edgecolor': '#d9a48f', 'hatch': '////', 'linewidth': 0.0,
}  # fmt: skip
_MARK = '#9a3412'
#: Width of a digit as a share of the type's size, and the room between two marks.
_DIGIT, _ROOM = 0.62, 0.5
#: Rows of marks above the axes.
_LEVELS = 2
#: Numbers of windows that one entry of a legend lists.
_LISTED = 6
#: Reasons that a legend explains; the table has all.
_REASONS = 6


def shade_segments(axes: Sequence[Axes], rows: Sequence[SegmentRow]) -> list[Any]:
    """Shade the windows in each of the axes and return the legend entries that explain them."""
    used = [row for row in rows if not row.reason]
    rejected = [row for row in rows if row.reason]
    for axis in axes:
        for some, style in ((used, USED), (rejected, REJECTED)):
            axis.broken_barh(
                [(row.start_s, row.end_s - row.start_s) for row in some],
                (0.0, 1.0),
                transform=axis.get_xaxis_transform(),
                zorder=0.5,
                **style,
            )
    handles: list[Any] = []
    if used:
        handles.append(Patch(**USED, label=f'steady window used ({len(used)})'))
    groups = sorted(rejected_groups(rows).items(), key=lambda entry: -len(entry[1]))
    for reason, members in groups[:_REASONS]:
        label = f'not used: {reason} ({_listed(members)})'
        handles.append(Patch(**REJECTED, label=label))
    if len(groups) > _REASONS:
        rest = sum(len(members) for _, members in groups[_REASONS:])
        handles.append(Patch(**REJECTED, label=f'not used: other reasons, see table ({rest})'))
    return handles


def _listed(members: Sequence[SegmentRow]) -> str:
    numbers = [str(row.number) for row in members]
    if len(numbers) > _LISTED:
        return f'{", ".join(numbers[: _LISTED - 1])}, … {len(numbers)} in all'
    return ', '.join(numbers)


def number_rejected(axes: Axes, rows: Sequence[SegmentRow], width: float) -> list[int]:
    """
    Write the numbers of the windows not used above the axes; return those that found room.

    The longest first, in as many rows as needed, none over another.

    :param width: of the axes on paper, in points.
    """
    first, last = axes.get_xlim()
    scale = width / (last - first)
    taken: list[list[tuple[float, float]]] = [[] for _ in range(_LEVELS)]
    placed = []
    for row in sorted((r for r in rows if r.reason), key=lambda r: r.start_s - r.end_s):
        middle = 0.5 * (row.start_s + row.end_s)
        half = 0.5 * FONT * (_DIGIT * len(str(row.number)) + _ROOM)
        place = scale * (middle - first)
        for level, spans in enumerate(taken):
            if all(place + half <= a or place - half >= b for a, b in spans):
                spans.append((place - half, place + half))
                axes.annotate(
                    str(row.number), (middle, 1.0), xycoords=axes.get_xaxis_transform(),
                    xytext=(0.0, 2.0 + 1.15 * FONT * level), textcoords='offset points',
                    ha='center', va='bottom', fontsize=FONT, color=_MARK,
                )  # fmt: skip
                placed.append(row.number)
                break
    return sorted(placed)
