# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction of a joint: the law that became its model, and what it was measured to be."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import SUMMARY, Figure
from sosml_friction.report.figures.fit import s_shape
from sosml_friction.report.fit.joint_view import JointView

_WIDTH_IN, _HEIGHT_IN = 6.0, 4.1


class Curve(Figure[JointView]):
    """Draw the law of the model with its 95 % band, and the friction of steady windows."""

    identifier = 'curve'
    title = 'Friction against velocity'
    report = 'fit'
    order = 5
    part = SUMMARY
    caption = (
        'Friction of joint {view.name}: the law of the model over what was measured. Positive '
        'for positive velocity; dotted where no speed was recorded.'
    )

    def applies(self, view: JointView) -> bool:
        return view.preferred is not None

    def draw(self, view: JointView) -> Drawing:
        assert view.preferred is not None
        figure = drawing.new_figure(_WIDTH_IN, _HEIGHT_IN)
        axes = figure.subplots()
        levels = s_shape.window_levels(view, view.preferred)
        limit = view.fastest
        s_shape.draw_panel(axes, view, view.preferred, levels, (1e-4 * limit, limit), folded=False)
        own = {view.preferred: levels}
        axes.set_ylim(s_shape.panel_height(view, own, limit, 1e-3 * limit, folded=False))
        drawing.label_axes(
            axes, f'velocity [{view.velocity_unit}]', f'friction τ_f [{view.effort_unit}]'
        )
        drawing.legend_below(figure, s_shape.panel_legend(view, view.style(view.preferred)))
        return figure
