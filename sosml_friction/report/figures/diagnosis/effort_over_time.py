# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort over time, and what is unexplained of it."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.residual.joint_residual import JointResidual
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure


class EffortOverTime(Figure[JointResidual]):
    """Draw measured effort, and below what the refitted and the extended model leave of it."""

    identifier = 'effort_over_time'
    title = 'Effort over time'
    report = 'diagnosis'
    order = 10
    caption = 'Effort, and what is unexplained of it'

    def draw(self, view: JointResidual) -> Drawing:
        figure = drawing.new_figure(10.0, 4.6)
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.2])
        time = view.axes['time']
        drawing.draw_line(top, time, view.effort, color=drawing.GREY, linewidth=1.0)
        drawing.draw_line(bottom, time, view.before, color=drawing.BEFORE, linewidth=0.9)
        drawing.draw_line(bottom, time, view.after, color=drawing.AFTER, linewidth=0.9)
        drawing.label_axes(top, '', f'measured effort [{view.unit}]')
        drawing.label_axes(bottom, 'time [s]', f'unexplained [{view.unit}]')
        drawing.legend_below(figure, drawing.before_and_after())
        return figure
