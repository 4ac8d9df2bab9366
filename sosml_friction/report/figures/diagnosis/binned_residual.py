# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The mean unexplained effort along six axes."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.residual import joint_residual
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import motion_units


class BinnedResidual(Figure[joint_residual.JointResidual]):
    """Draw the mean of what is unexplained over what it may depend on, by direction."""

    identifier = 'binned_residual'
    title = 'What is unexplained along six axes'
    report = 'diagnosis'
    order = 20
    caption = 'Mean of what is unexplained along six axes, by direction'

    def draw(self, view: joint_residual.JointResidual) -> Drawing:
        """Draw velocity, position, load, acceleration, way since the last reversal, time."""
        figure = drawing.new_figure(10.0, 6.4)
        panels = figure.subplots(2, 3, sharey=True).ravel()
        length, speed = motion_units(view.unit)
        labels = {
            'v': f'velocity [{speed}]',
            'q': f'position [{length}]',
            'load': f'load [{view.unit}]',
            'a': f'acceleration [{speed}²]',
            'since': f'way since reversal [{length}]',
            'time': 'time [s]',
        }
        forwards = view.axes['v'] > 0.0
        for ax, (name, label) in zip(panels, labels.items(), strict=True):
            x = view.axes[name]
            if joint_residual.is_constant(x):
                ax.text(0.5, 0.5, 'constant', transform=ax.transAxes, ha='center',
                        fontsize=drawing.FONT)  # fmt: skip
                drawing.label_axes(ax, label, '')
                continue
            # What matters of the way since a reversal happens in its first thousandths.
            x, edges = joint_residual.bins_of(x, name == 'since')
            if name == 'since':
                drawing.log_axis(ax)
            for way, dashes in ((forwards, '-'), (~forwards, '--')):
                for values, colour in ((view.before, drawing.BEFORE), (view.after, drawing.AFTER)):
                    middle, mean = joint_residual.means_in_bins(x, values, way, edges)
                    ax.plot(middle, mean, color=colour, linestyle=dashes, linewidth=1.4)
            drawing.label_axes(
                ax, label, f'mean unexplained effort [{view.unit}]' if name in 'va' else ''
            )
        handles = [
            drawing.key(color=drawing.BEFORE, label='refitted model, forwards'),
            drawing.key(color=drawing.BEFORE, linestyle='--', label='backwards'),
            drawing.key(color=drawing.AFTER, label='with what was named, forwards'),
            drawing.key(color=drawing.AFTER, linestyle='--', label='backwards'),
        ]
        drawing.fix_axes(figure, (0.85, 0.15, 0.95, 0.12), (0.2, 0.6), handles)
        return figure
