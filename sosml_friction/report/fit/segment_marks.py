# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Windows of steady motion in a figure over time: shaded, and numbered where not used."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Patch

from sosml_friction.report.common.drawing import FONT
from sosml_friction.report.fit.segment_rows import SegmentRow, rejected_groups

#: Hatched as well as coloured: pale green and pale red are one colour to some.
USED: dict[str, Any] = {'facecolor': '#d3ebe0', 'edgecolor': 'none'}
REJECTED: dict[str, Any] = {
    'facecolor': '#faf0ec',
    'edgecolor': '#d9a48f',
    'hatch': '////',
    'linewidth': 0.0,
}
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

    :param axes: its limits of time are final.
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
