# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What the figures of all reports share: paper, type, colours.

Matplotlib's object interface on the Agg canvas: no global state, no display. Colours are those of
Okabe and Ito, which people with any colour vision tell apart; markers and dashes say the same.
Matplotlib is imported by what draws: a fit that is not drawn need not wait for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

DPI = 100
FONT = 10
GREY = '#7a7a7a'
#: Colours of what the refitted model leaves, and of what is left with the causes.
BEFORE, AFTER = '#D55E00', '#0072B2'
#: Up to this ratio of its ends an axis of logarithms has numbers between the decades.
_DENSE = 30.0
#: Characters of a number for which margins leave room, and the width of one more [inches].
_USUAL, _DIGIT = 6, 0.09
#: Points of one line that a figure shows.
_LINE_POINTS = 2000
#: Joints whose figures have all their points; of more each has fewer, and a page stays small.
_DENSE_JOINTS = 2
#: Below this share of their points a page leaves out the figures of methods: above 3 joints.
_CROWDED = 0.6
_share: ContextVar[float] = ContextVar('share', default=1.0)


class Style(NamedTuple):
    """Say how an observer is drawn; width in points."""

    colour: str
    marker: str
    dashes: Literal['-', '--', '-.', ':']
    width: float


# The first lie under the others, and look out on both sides.
_STYLES = {
    'quasi_static': Style('#999999', '8', '-', 2.2),
    'first_order_capped': Style('#004B78', 'p', '-', 2.6),
    'first_order': Style('#0072B2', 'o', '-', 3.2),
    'first_order_prefiltered': Style('#56B4E9', 'v', '-', 2.0),
    'linear_second_order': Style('#7B3294', 'x', '--', 1.8),
    'sosml': Style('#D55E00', 's', '-', 1.4),
    'sosml_explicit': Style('#D55E00', 'P', ':', 1.4),
    'kalman': Style('#CC79A7', '^', '-', 1.6),
    'kalman_scheduled': Style('#CC79A7', '>', '--', 1.6),
    'kalman_adaptive': Style('#CC79A7', '<', ':', 1.6),
    'kalman_imm': Style('#555555', 'h', '-', 1.6),
    'kalman_stribeck': Style('#009E73', 'D', '-', 1.6),
    'kalman_stribeck_wrong_knee': Style('#009E73', 'd', ':', 1.6),
    'smoother': Style('#E69F00', '*', '-.', 1.6),
    'weak_form': Style('#117733', 'D', '-', 1.6),
    'regression': Style('#882255', '^', '-', 1.6),
    'output_error': Style('#332288', 'X', '-', 1.6),
}
_OTHERS = (
    Style('#CC79A7', '^', '--', 1.4),
    Style('#009E73', 'D', '-.', 1.4),
    Style('#56B4E9', 'v', ':', 1.8),
    Style('#E69F00', 'P', '--', 1.4),
)

#: Colours and markers of recordings, in their order; triangles are directions.
_BAGS = (
    ('#0072B2', 'o'),
    ('#E69F00', 's'),
    ('#009E73', 'D'),
    ('#CC79A7', 'P'),
    ('#56B4E9', 'p'),
    ('#D55E00', '*'),
    ('#7A5195', 'h'),
)


def bag_style(k: int) -> Style:
    """Return how the recording number ``k`` is drawn."""
    colour, marker = _BAGS[k % len(_BAGS)]
    return Style(colour, marker, '-' if k < len(_BAGS) else '--', 1.6)


def to_png(figure: Figure) -> bytes:
    """Return the figure as a PNG of :data:`DPI` dots per inch."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    stream = BytesIO()
    FigureCanvasAgg(figure).print_png(stream)
    return stream.getvalue()


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=DPI, layout='constrained', facecolor='white')


def style_of(observer: str, k: int) -> Style:
    """Return how an observer is drawn, by its place ``k`` where it has no style of its own."""
    return _STYLES.get(observer, _OTHERS[k % len(_OTHERS)])


def marker_edge(style: Style) -> str:
    """Return the colour of a marker's edge: white, which parts it from others, or its own."""
    return style.colour if style.marker in ('x', '+') else 'white'


def key(**look: Any) -> Line2D:
    """Return an entry of a legend: a line or marker that looks so, with its ``label``."""
    from matplotlib.lines import Line2D

    return Line2D([], [], **look)


def before_and_after() -> list[Any]:
    """Return the legend of what the refitted model leaves, and of what is left with the causes."""
    return [
        key(color=BEFORE, label='refitted model'),
        key(color=AFTER, label='with what was named'),
    ]


def label_axes(axes: Axes, x: str, y: str) -> None:
    """Write both labels, and dress the axes."""
    axes.set_xlabel(x, fontsize=FONT)
    axes.set_ylabel(y, fontsize=FONT)
    axes.tick_params(labelsize=FONT)
    axes.grid(True, color='#e4e4e4', linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ('top', 'right'):
        axes.spines[side].set_visible(False)
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_offset_text().set_fontsize(FONT)


def log_axis(axes: Axes) -> None:
    """Make x logarithmic, with plain numbers: at the decades, of a short span between them too."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axes.set_xscale('log')

    def text(x: float, _: int | None) -> str:
        low, high = axes.get_xlim()
        whole = abs(np.log10(x) - np.rint(np.log10(x))) < 1e-9
        # One number alone is no scale.
        few = np.floor(np.log10(high)) <= np.ceil(np.log10(low))
        return f'{x:g}' if whole or few or high < _DENSE * low else ''

    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(text))
    axes.xaxis.set_minor_locator(NullLocator())


def fix_axes(
    figure: Figure,
    margins: tuple[float, float, float, float],
    gaps: tuple[float, float] = (0.2, 0.2),
    handles: Sequence[Any] = (),
) -> None:
    """
    Place axes whose labels have a known size, and a legend in one row below them.

    To find such places by measuring all text takes as long as drawing it.

    :param margins: left, right, bottom, top [inches]; gaps: between columns and rows [inches].
    """
    width, height = figure.get_size_inches()
    left, right, bottom, top = margins
    left += max(0, _longest(figure) - _USUAL) * _DIGIT
    grid = figure.axes[0].get_subplotspec()
    assert grid is not None
    rows, columns = grid.get_gridspec().nrows, grid.get_gridspec().ncols
    one = (width - left - right - (columns - 1) * gaps[0]) / columns
    high = (height - bottom - top - (rows - 1) * gaps[1]) / rows
    figure.set_layout_engine(None)
    figure.subplots_adjust(
        left / width, bottom / height, 1.0 - right / width, 1.0 - top / height, gaps[0] / one,
        gaps[1] / high,
    )  # fmt: skip
    if handles:
        figure.legend(
            handles=list(handles), loc='lower center', ncols=len(handles), fontsize=FONT,
            frameon=False,
        )  # fmt: skip


def _longest(figure: Figure) -> int:
    """Return how many characters the longest number left of the axes has; names: none."""
    from matplotlib.ticker import ScalarFormatter

    axis = figure.axes[0].yaxis
    form = axis.get_major_formatter()
    if not isinstance(form, ScalarFormatter):
        return 0
    return max(map(len, form.format_ticks(list(axis.get_majorticklocs()))), default=0)


def legend_below(figure: Figure, handles: Sequence[Any]) -> None:
    """Put the legend under the axes, where it covers no data, in as many columns as fit."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    renderer = FigureCanvasAgg(figure).get_renderer()
    for columns in range(min(len(handles), 5), 0, -1):
        legend = figure.legend(
            handles=list(handles), loc='lower center', ncols=columns, fontsize=FONT, frameon=False
        )
        size = legend.get_window_extent(renderer)
        if size.width <= figure.bbox.width or columns == 1:
            # Room for the axes: legends "outside" need a newer Matplotlib than Ubuntu's.
            height = size.y1 / figure.bbox.height
            figure.set_layout_engine('constrained', rect=(0.0, height, 1.0, 1.0 - height))
            return
        legend.remove()


@contextmanager
def page_of(joints: int) -> Iterator[None]:
    """Draw figures within of a page with so many joints."""
    token = _share.set(min(1.0, _DENSE_JOINTS / max(joints, 1)))
    try:
        yield
    finally:
        _share.reset(token)


def is_crowded() -> bool:
    """Tell whether the page has so many joints that it leaves out figures of methods."""
    return _share.get() < _CROWDED


def points(most: int) -> int:
    """Return how many points a figure shows of at most so many, on the page that it is for."""
    return max(1, round(most * _share.get()))


def draw_line(axes: Axes, time: FloatArray, values: FloatArray, **style: Any) -> None:
    """Draw a line of any number of samples, a long one as its :func:`envelope`."""
    axes.plot(*envelope(time, values), **style)


def envelope(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and largest value of each of many short spans, in order of time."""
    count = points(_LINE_POINTS) // 2
    if len(values) <= 2 * count:
        return time, values
    size = -(-len(values) // count)
    spans = np.full((-(-len(values) // size), size), np.nan)
    spans.ravel()[: len(values)] = values
    known = np.isfinite(spans).any(axis=1)
    # A span without numbers keeps its first sample, which parts the line there.
    ends = np.zeros((len(spans), 2), dtype=np.int64)
    ends[known, 0] = np.nanargmin(spans[known], axis=1)
    ends[known, 1] = np.nanargmax(spans[known], axis=1)
    kept = np.unique(ends + size * np.arange(len(spans))[:, None])
    return time[kept], values[kept]
