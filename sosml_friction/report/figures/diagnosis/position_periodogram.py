# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The lines in position of what is unexplained."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.residual.joint_residual import JointResidual
from sosml_friction.diagnosis.residual.position_spectrum import moves_enough, position_lines
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure

_NAMED = '#c9c9c9'


class PositionPeriodogram(Figure[JointResidual]):
    """
    Draw the lines in position of what is unexplained, forwards and backwards.

    What is the same in both directions is a torque of position; friction of position changes its
    sign with the direction, but not its size.
    """

    identifier = 'position_periodogram'
    title = 'What repeats with position'
    report = 'diagnosis'
    order = 30
    caption = (
        'What repeats with position: a torque of position has the same lines in both '
        'directions, and what drifts with time has none'
    )

    def applies(self, view: JointResidual) -> bool:
        return moves_enough(view)

    def draw(self, view: JointResidual) -> Drawing:
        lines = position_lines(view)
        figure = drawing.new_figure(10.0, 3.4)
        panels = figure.subplots(1, 2, sharey=True)
        ways = (('forwards', lines.forwards), ('backwards', lines.backwards))
        for ax, (label, sizes) in zip(panels, ways, strict=True):
            for period in lines.named:
                ax.axvline(period, color=_NAMED, linewidth=3.0)
            for size, colour in zip(sizes, (drawing.BEFORE, drawing.AFTER), strict=True):
                ax.plot(lines.periods, size, color=colour, linewidth=0.9)
            ax.set_title(label, fontsize=drawing.FONT, loc='left')
            drawing.label_axes(
                ax,
                'periods per turn' if view.unit == 'Nm' else 'periods per metre',
                f'size of unexplained line [{view.unit}]' if ax is panels[0] else '',
            )
            # Over decades: harmonics of a turn are few, teeth and slots are many.
            drawing.log_axis(ax)
            ax.set_xlim(float(lines.periods[0]), float(lines.periods[-1]))
            ax.set_ylim(bottom=0.0)
        handles = drawing.before_and_after()
        if lines.named:
            handles.append(drawing.key(color=_NAMED, linewidth=3.0, label='named'))
        drawing.fix_axes(figure, (0.85, 0.15, 0.95, 0.35), (0.2, 0.2), handles)
        return figure
