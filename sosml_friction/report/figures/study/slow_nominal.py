# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The counterpart of the paper's Figure 2: the slow motion without noise."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.figures.study.phase_plane import draw_phase_plane
from sosml_friction.report.study.view import shown_observers
from sosml_friction.study.metrics import SCORED_FROM_S
from sosml_friction.study.run import Study

_CASE = ('slow', 'nominal')
#: Speeds of the paper's Figure 2 [rad/s].
_SLOW = 0.052


class SlowNominal(Figure[Study]):
    """Draw the slow motion without noise: the phase plane, and what is wrong in it."""

    identifier = 'figure2_slow_nominal'
    title = 'Slow motion, nominal'
    report = 'study'
    order = 10
    caption = (
        'Slow motion, nominal (the paper’s Figure 2). Left: estimates, the law fitted to '
        'them, the true law. Right: estimate minus truth. FO capped has a cutoff of '
        'at most 300 1/s.'
    )

    def applies(self, view: Study) -> bool:
        return bool(shown_observers(view, _CASE))

    def draw(self, view: Study) -> Drawing:
        shown = shown_observers(view, _CASE)
        figure = drawing.new_figure(10.0, 4.8)
        plane, error = figure.subplots(1, 2)
        handles = draw_phase_plane((plane,), view, _CASE, shown, (_SLOW,))
        plane.set_title('friction over velocity', fontsize=drawing.FONT)
        observation = view.observations[_CASE]
        kept = observation.time > SCORED_FROM_S
        v = observation.velocity[kept, 0]
        for k, name in enumerate(shown):
            style = drawing.style_of(name, k)
            wrong = 1e3 * (view.estimate(view.row(_CASE, name)) - observation.friction)[kept, 0]
            width = min(style.width, 2.2)
            error.plot(v, wrong, color=style.colour, linewidth=width, linestyle=style.dashes)
        error.axhline(0.0, color=drawing.GREY, linewidth=0.6)
        error.set_xlim(-_SLOW, _SLOW)
        error.set_title('estimate minus truth', fontsize=drawing.FONT)
        drawing.label_axes(error, 'velocity [rad/s]', 'error [mNm]')
        drawing.legend_below(figure, handles)
        return figure
