# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort over time, and what is unexplained of it."""

from __future__ import annotations

from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.residual.joint_residual import JointResidual
from sosml_friction.report.common.drawing import (
    AFTER,
    BEFORE,
    GREY,
    before_and_after,
    draw_line,
    label_axes,
    legend_below,
    new_figure,
)
from sosml_friction.report.common.figure import Figure


class EffortOverTime(Figure[JointResidual]):
    """Draw measured effort, and below what the refitted and the extended model leave of it."""

    identifier = 'effort_over_time'
    title = 'Effort over time'
    report = 'diagnosis'
    order = 10
    caption = 'Effort, and what is unexplained of it'

    def draw(self, view: JointResidual) -> Drawing:
        """Draw both over time."""
        figure = new_figure(10.0, 4.6)
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.2])
        time = view.axes['time']
        draw_line(top, time, view.effort, color=GREY, linewidth=1.0)
        draw_line(bottom, time, view.before, color=BEFORE, linewidth=0.9)
        draw_line(bottom, time, view.after, color=AFTER, linewidth=0.9)
        label_axes(top, '', f'measured effort [{view.unit}]')
        label_axes(bottom, 'time [s]', f'unexplained [{view.unit}]')
        legend_below(figure, before_and_after())
        return figure
