# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the unexplained variance goes."""

import numpy as np
from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.diagnosis.residual.variance_steps import variance_steps
from sosml_friction.report.common.drawing import FONT, label_axes, new_figure
from sosml_friction.report.common.figure import Figure

_COLOURS = {'cause': '#0072B2', 'rest': '#D55E00', 'noise': '#bdbdbd', 'start': '#f2c9ad'}


class VarianceWaterfall(Figure[Diagnosis]):
    """Draw a cascade of bars for each joint, from what the refitted model leaves to the noise."""

    identifier = 'variance_waterfall'
    title = 'What was considered'
    report = 'diagnosis'
    order = 50
    caption = (
        'Unexplained variance on folds left out: what each cause takes of it, what stays '
        'unexplained, and what is noise by the estimate'
    )

    def applies(self, view: Diagnosis) -> bool:
        return view.laboratory is not None and bool(view.ranking) and bool(view.stages)

    def draw(self, view: Diagnosis) -> Drawing:
        steps = [variance_steps(view, i) for i in range(len(view.names))]
        most = max(len(x) for x in steps)
        figure = new_figure(10.0, 0.9 + (0.3 + 0.3 * most) * len(steps))
        panels = np.atleast_1d(figure.subplots(len(steps), 1, sharex=True))
        for ax, bars, name in zip(panels, steps, view.names, strict=True):
            place = np.arange(len(bars))[::-1]
            ax.barh(
                place,
                [bar.high - bar.low for bar in bars],
                left=[bar.low for bar in bars],
                color=[_COLOURS[bar.kind] for bar in bars],
                height=0.7,
            )
            right = max(bar.high for bar in bars)
            for y, bar in zip(place, bars, strict=True):
                text = f'{bar.high - bar.low:.1f} %'
                ax.text(bar.high + 0.01 * right, y, text, va='center', fontsize=FONT)
            ax.set_yticks(place, [bar.label for bar in bars], fontsize=FONT)
            ax.set_title(name, fontsize=FONT, loc='left')
            ax.set_xlim(0.0, 1.12 * right)
            last = ax is panels[-1]
            label_axes(ax, 'share of the variance that the refitted model leaves [%]' * last, '')
            ax.grid(False, axis='y')
        return figure
