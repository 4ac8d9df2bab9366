# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort over time, and what is unexplained of it."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.residual.joint_residual import JointResidual
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure

#: A step longer than so many usual ones was left out: nothing is drawn across it.
_HOLE = 20.0


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
        steps = np.diff(time, append=time[-1:])
        hole = steps > _HOLE * np.median(steps)

        def draw(axes: Axes, values: FloatArray, colour: str) -> None:
            parted = np.where(hole, np.nan, values)
            drawing.draw_line(axes, time, parted, color=colour, linewidth=0.9)

        draw(top, view.effort, drawing.GREY)
        draw(bottom, view.before, drawing.BEFORE)
        draw(bottom, view.after, drawing.AFTER)
        drawing.label_axes(top, '', f'measured effort [{view.unit}]')
        drawing.label_axes(bottom, 'time [s]', f'unexplained [{view.unit}]')
        drawing.legend_below(figure, drawing.before_and_after())
        return figure
