# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How evenly the joint moved on its plateaus."""

import numpy as np
from matplotlib.figure import Figure as Drawing

from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.fit.joint_view import JointView


class Ripple(Figure[JointView]):
    """Draw the ripple of the speed over the speed of each plateau, beside the encoder's noise."""

    identifier = 'ripple'
    title = 'Ripple of the speed'
    report = 'fit'
    order = 35
    caption = (
        'How evenly joint {view.name} moved: the root mean square of its speed about the mean on '
        'each plateau, with its standard error, and what the encoder’s noise makes in the same '
        'band. Hollow marks are not told from that noise. Above the dotted line a sine of that '
        'size stops the joint.'
    )

    def applies(self, view: JointView) -> bool:
        return any(np.isfinite(own.ripple) for own in view.ripple)

    def draw(self, view: JointView) -> Drawing:
        figure = drawing.new_figure(10.0, 3.2)
        axes = figure.subplots()
        plateaus = view.ripple
        speeds = np.abs([own.velocity for own in plateaus])
        axes.plot(speeds, [own.noise for own in plateaus], color=drawing.GREY, linestyle='',
                  marker='_', markersize=9)  # fmt: skip
        for speed, own in zip(speeds, plateaus, strict=True):
            axes.errorbar(speed, own.ripple, own.ripple_error, color=drawing.AFTER, marker='o',
                          markersize=5, markerfacecolor=drawing.AFTER if own.kind else 'none',
                          linewidth=1.0)  # fmt: skip
        top = axes.get_ylim()[1] if self.applies(view) else 1.0
        axes.plot(np.sort(speeds), np.sort(speeds) / np.sqrt(2.0), color=drawing.BEFORE,
                  linestyle=':')  # fmt: skip
        axes.set_ylim(0.0, top)
        if plateaus:
            drawing.log_axis(axes)
        unit = view.velocity_unit
        drawing.label_axes(axes, f'speed of the plateau [{unit}]', f'ripple [{unit} rms]')
        drawing.legend_below(figure, [
            drawing.key(color=drawing.AFTER, marker='o', label='ripple'),
            drawing.key(color=drawing.GREY, marker='_', linestyle='', label='encoder’s noise'),
            drawing.key(color=drawing.BEFORE, linestyle=':', label='stops the joint'),
        ])  # fmt: skip
        return figure
