# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Figures as files of their own, for a paper, a talk or another program."""

import gc
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.container import BarContainer, ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.report.common.figure import figures_of
from sosml_friction.report.common.output import csv_text, refused

#: The folder of the figures, in that of the report.
FOLDER = 'figures'
_COLUMNS = ('panel', 'x_label', 'y_label', 'series', 'x', 'y', 'low', 'high')


def figure_csv(figure: Figure) -> str:
    """
    Return the numbers that a figure shows, as CSV with a heading, UTF-8.

    A row for each point of each curve, mark or bar. ``series`` is the entry of the legend that
    looks like it, else its colour; ``low`` and ``high`` are the ends of its error bar.
    """
    known = dict(_legend(figure))
    rows = (
        [panel, axes.get_xlabel(), axes.get_ylabel(), series, *map(float, row)]
        for panel, axes in enumerate(figure.axes, 1)
        for series, *numbers in _series(axes, known)
        for row in zip(*numbers, strict=True)
    )
    return csv_text(_COLUMNS, rows)


#: The forms of ``--figures``.
FORMS = ('png', 'pdf', 'svg', 'csv')


def check_forms(forms: Sequence[str]) -> tuple[str, ...]:
    """
    Return the forms of ``--figures``.

    :raises ConfigurationError: if one is not known.
    """
    for form in forms:
        if form not in FORMS:
            raise ConfigurationError(
                f'--figures {form} is no form of a figure: give some of {", ".join(FORMS)}'
            )
    return tuple(forms)


def write_figures(
    folder: Path, report: str, views: Mapping[str, object], forms: Sequence[str]
) -> None:
    """
    Write each figure of a report as ``figures/<name>_<figure>.<form>``, in place of earlier ones.

    :param views: what is drawn, by the name that its files begin with.
    :raises ConfigurationError: if the folder cannot be written.
    """
    try:
        if forms:
            (folder / FOLDER).mkdir(parents=True, exist_ok=True)
        for name, view in views.items() if forms else ():
            for figure in figures_of(report, view):
                stem = re.sub(r'[^\w.-]+', '_', f'{name}_{figure.identifier}'.strip('_'))
                drawn = figure.draw(view)
                for form in forms:
                    file = folder / FOLDER / f'{stem}.{form}'
                    if form == 'csv':
                        file.write_text(figure_csv(drawn), encoding='utf-8')
                    else:
                        drawn.savefig(file)
            # A drawn figure is a cycle, which commands leave where it is.
            gc.collect()
    except OSError as error:
        raise refused(folder / FOLDER, error) from error


def _look(line: Line2D) -> tuple[str, str, str]:
    return to_hex(line.get_color()), str(line.get_linestyle()), str(line.get_marker())


def _legend(figure: Figure) -> Iterator[tuple[tuple[str, str, str], str]]:
    """Yield how an entry of a legend looks, and what it says."""
    legends = [*figure.legends, *(x for axes in figure.axes if (x := axes.get_legend()))]
    for legend in legends:
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=False):
            if isinstance(handle, Line2D):
                yield _look(handle), text.get_text()


def _series(axes: Axes, known: Mapping[tuple[str, str, str], str]) -> Iterator[tuple[Any, ...]]:
    """Yield name, x, y, and the ends of the error bars of each series of an axes."""
    ends: dict[Line2D, Any] = {}
    for container in axes.containers:
        if isinstance(container, ErrorbarContainer) and container.lines[0] is not None:
            bars = container.lines[2]
            if bars:
                ends[container.lines[0]] = [
                    piece[:, 1] if np.ndim(piece) == 2 else (np.nan, np.nan)
                    for piece in bars[0].get_segments()
                ]
        if isinstance(container, BarContainer):
            places = [bar.get_y() + 0.5 * bar.get_height() for bar in container]
            widths = [bar.get_width() for bar in container]
            empty = [np.nan] * len(places)
            yield to_hex(container[0].get_facecolor()), widths, places, empty, empty
    for line in axes.get_lines():
        x = np.asarray(line.get_xdata(), dtype=float)
        y = np.asarray(line.get_ydata(), dtype=float)
        colour, dashes, marker = _look(line)
        alike = [text for look, text in known.items() if look[0] == colour]
        name = known.get((colour, dashes, marker)) or (alike[0] if len(alike) == 1 else colour)
        span = np.reshape(ends.get(line, ()), (-1, 2))
        if len(span) != len(x):
            span = np.full((len(x), 2), np.nan)
        yield name, x, y, span[:, 0], span[:, 1]
