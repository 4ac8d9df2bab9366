# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The counterpart of the paper's Figure 4: the reversal with a wrong model."""

import numpy as np
from matplotlib.figure import Figure as Drawing

from sosml_friction.model.laws import unit_of
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import SYMBOLS
from sosml_friction.report.figures.study.phase_plane import TRUTH_STYLE, draw_phase_plane
from sosml_friction.report.study.view import shown_observers
from sosml_friction.study.condition import GRAVITY_OFFSET, INERTIA_SCALES
from sosml_friction.study.outcome import fitted_laws
from sosml_friction.study.plant import TRUTH
from sosml_friction.study.run import Study

_CASE = ('reversal', 'mismatch')
#: Speeds of the panel near zero [rad/s].
_NEAR = 0.1


class Mismatch(Figure[Study]):
    """Draw the reversal with a wrong model: phase plane above, fitted parameters below."""

    identifier = 'figure4_mismatch'
    title = 'Reversal with a wrong model'
    report = 'study'
    order = 30
    caption = (
        'Reversal with a wrong model (the paper’s Figure 4). Above: estimates, fitted laws, '
        'truth. Below: the parameters of the fitted laws; dashed: truth. The bias is the '
        'error of the gravity model, which cannot be told from friction that does not change '
        'sign.'
    )

    def applies(self, view: Study) -> bool:
        return bool(shown_observers(view, _CASE))

    def draw(self, view: Study) -> Drawing:
        """Draw it with the first model of the condition, the one with too much inertia."""
        shown = shown_observers(view, _CASE)
        figure = drawing.new_figure(10.0, 7.4)
        grid = figure.add_gridspec(2, 10, height_ratios=(1.5, 1.0))
        whole, near = figure.add_subplot(grid[0, :6]), figure.add_subplot(grid[0, 6:])
        top = 1.05 * float(np.abs(view.observations[_CASE].velocity[:, 0]).max())
        handles = draw_phase_plane((whole, near), view, _CASE, shown, (top, _NEAR))
        whole.set_title(
            f'believed: M × {INERTIA_SCALES[0]:g}, g + {GRAVITY_OFFSET[0]:g} Nm',
            fontsize=drawing.FONT,
        )
        near.set_title('near zero velocity', fontsize=drawing.FONT)
        near.set_ylabel('')
        laws = fitted_laws(view, _CASE, shown)
        for column, (name, symbol) in enumerate(SYMBOLS.items()):
            axes = figure.add_subplot(grid[1, 2 * column : 2 * column + 2])
            for k, observer in enumerate(shown):
                value = laws[observer].parameters[name]
                axes.bar(k, value, width=0.7, color=drawing.style_of(observer, k).colour)
            axes.axhline(TRUTH[0][name], **TRUTH_STYLE)
            axes.axhline(0.0, color=drawing.GREY, linewidth=0.6)
            axes.set_title(f'{symbol} [{unit_of(name, "Nm")}]', fontsize=drawing.FONT)
            drawing.label_axes(axes, '', '')
            axes.set_xticks([])
            axes.set_xlim(-0.7, len(shown) - 0.3)
            axes.margins(y=0.12)
        drawing.legend_below(figure, handles)
        return figure
