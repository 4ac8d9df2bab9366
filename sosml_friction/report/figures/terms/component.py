# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A term over its own axis, with what the data say of it."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.identification.number_text import words
from sosml_friction.identification.term_residual import TermAxis
from sosml_friction.report.common.drawing import AFTER, GREY, label_axes, new_figure
from sosml_friction.report.common.figure import Figure


class Component(Figure[TermAxis]):
    """Draw a term and its partial residual, in bins along the axis that the term names."""

    identifier = 'component'
    title = 'A term over its axis'
    report = 'terms'
    order = 10
    caption = (
        'Line: mean effort of the term; points: the same with what is left of the data, mean and '
        'standard error in bins of as many samples each. Points beside the line are structure '
        'that the term does not have.'
    )

    def draw(self, view: TermAxis) -> Drawing:
        figure = new_figure(6.4, 3.4)
        ax = figure.subplots()
        ax.errorbar(
            view.x, view.seen, yerr=view.error, fmt='o', color=GREY, markersize=4, linewidth=1.0
        )
        ax.plot(view.x, view.said, color=AFTER, linewidth=1.8)
        what = 'time' if view.axis == 'none' else 'position' if view.axis == 'body' else view.axis
        label_axes(ax, f'{what} [{view.unit}]', f'{words(view.term.term)} [{view.effort_unit}]')
        ax.set_title(f'{view.joint}: {words(view.term.term)}')
        return figure
