# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The counterpart of the paper's Figure 3: errors over time with noise."""

import numpy as np
from matplotlib.figure import Figure as Drawing

from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.study.view import shown_observers
from sosml_friction.study.metrics import SCORED_FROM_S, reversals
from sosml_friction.study.outcome import ranked
from sosml_friction.study.run import Study, rmse_mean

_CASES = (('slow', 'noise'), ('reversal', 'noise'))
#: Around the reversal that is shown [s].
_BEFORE_S, _AFTER_S = 0.2, 0.6


class ErrorTraces(Figure[Study]):
    """Draw estimate minus truth over time with noise, a row for each motion, with the RMSE."""

    identifier = 'figure3_noise'
    title = 'Errors with noise'
    report = 'study'
    order = 20
    caption = (
        'Estimate minus truth with encoder noise (the paper’s Figure 3), first scoring seed; '
        'the RMSE is the mean over all seeds. Long traces are drawn as their envelope.'
    )

    def applies(self, view: Study) -> bool:
        return any(shown_observers(view, case) for case in _CASES)

    def draw(self, view: Study) -> Drawing:
        """Draw all that is scored on the left, and one reversal on the right."""
        cases = [case for case in _CASES if case in view.observations]
        figure = drawing.new_figure(10.0, 0.8 + 3.4 * len(cases))
        rows = figure.subplots(len(cases), 2, width_ratios=(2.6, 1.0), squeeze=False, sharey='row')
        for (whole, near), case in zip(rows, cases, strict=True):
            observation = view.observations[case]
            scored = observation.time > SCORED_FROM_S
            time = observation.time[scored]
            found = reversals(observation.time, observation.velocity[:, 0])
            turn = float(observation.time[found[len(found) // 2]])
            handles, reach = [], 0.0
            # The smallest error last: it would vanish under the others.
            shown = sorted(
                shown_observers(view, case), key=lambda name: ranked(view, case).index(name)
            )[::-1]
            for k, name in enumerate(shown):
                row = view.row(case, name)
                wrong = 1e3 * (view.estimate(row) - observation.friction)[scored, 0]
                reach = max(reach, float(np.quantile(np.abs(wrong), 0.999)))
                colour = drawing.style_of(name, k).colour
                drawing.draw_line(whole, time, wrong, color=colour, linewidth=0.8 + 0.2 * k)
                close = (time > turn - _BEFORE_S) & (time < turn + _AFTER_S)
                near.plot(time[close], wrong[close], color=colour, linewidth=0.8 + 0.2 * k)
                error = 1e3 * rmse_mean('noise', row.scores[0])
                text = f'{observer_label(name)}: RMSE {error:.3g} mNm'
                handles.append(drawing.key(color=colour, linewidth=2.5, label=text))
            for axes in (whole, near):
                axes.axhline(0.0, color=drawing.GREY, linewidth=0.6)
                drawing.label_axes(axes, '', '')
            whole.set_ylim(-1.1 * reach, 1.1 * reach)
            whole.margins(x=0.01)
            whole.set_ylabel(f'{case[0]}: error [mNm]', fontsize=drawing.FONT)
            near.set_xlim(turn - _BEFORE_S, turn + _AFTER_S)
            near.locator_params(axis='x', nbins=5)
            # Room for the legend, which is wider than its panel.
            whole.set_title(' ', fontsize=drawing.FONT, pad=12.0)
            legend = whole.legend(
                handles=handles, loc='lower left', bbox_to_anchor=(0.0, 1.0), ncols=3,
                fontsize=drawing.FONT, frameon=False, borderaxespad=0.2, handlelength=1.4,
            )  # fmt: skip
            legend.set_in_layout(False)
        for axes, text in zip(rows[-1], ('time [s]', 'time [s], one reversal'), strict=True):
            axes.set_xlabel(text, fontsize=drawing.FONT)
        figure.align_ylabels(rows[:, 0])
        return figure
