# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the model leaves of effort and position, before and after what was named."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.identification.number_text import format_number
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import SUMMARY, Figure


class BeforeAfter(Figure[Diagnosis]):
    """Draw the errors of effort and of simulated position by joint, before and after."""

    identifier = 'before_after'
    title = 'Before and after what was named'
    report = 'diagnosis'
    order = 5
    part = SUMMARY
    caption = (
        'What the model gets wrong, by joint: the refitted model as it was given, and with what '
        'was named. Left: error of effort. Right: error of the position that it simulates.'
    )

    def applies(self, view: Diagnosis) -> bool:
        return view.gain is not None and bool(np.isfinite(view.gain.relative_before).any())

    def draw(self, view: Diagnosis) -> Drawing:
        gain = view.gain
        assert gain is not None
        shown = np.flatnonzero(np.isfinite(gain.relative_before))
        figure = drawing.new_figure(9.0, 1.3 + 0.55 * len(shown))
        left, right = figure.subplots(1, 2, sharey=True)
        units = {view.units[i] for i in shown}
        length = ' or '.join(sorted({'mrad' if unit == 'Nm' else 'mm' for unit in units}))
        _bars(left, gain.relative_before[shown], gain.relative_after[shown])
        _bars(right, 1e3 * gain.forward_before[shown], 1e3 * gain.forward_after[shown])
        left.set_yticks(range(len(shown)), [view.names[i] for i in shown], fontsize=drawing.FONT)
        left.set_ylim(len(shown) - 0.5, -0.5)
        drawing.label_axes(left, 'effort error, share of effort [%]', '')
        drawing.label_axes(right, f'position error after {gain.horizon_s:g} s [{length}]', '')
        for axes in (left, right):
            axes.grid(False, axis='y')
            axes.tick_params(axis='y', length=0)
        drawing.legend_below(figure, drawing.before_and_after())
        return figure


def _bars(axes: Axes, before: FloatArray, after: FloatArray) -> None:
    both = np.array([before, after])
    top = float(np.max(both, initial=0.0, where=np.isfinite(both))) or 1.0
    for shift, values, colour in ((-0.2, before, drawing.BEFORE), (0.2, after, drawing.AFTER)):
        place = np.arange(len(values)) + shift
        # A simulation that is impossible or runs away has no length: it fills the axis.
        lengths = np.nan_to_num(values, posinf=top)
        axes.barh(place, lengths, height=0.36, color=colour)
        for y, value, length in zip(place, values, lengths, strict=True):
            text = 'runs away' if np.isposinf(value) else format_number(value, 0.1 * abs(value))
            axes.annotate(
                text, (length, y), xytext=(4, 0),
                textcoords='offset points', va='center', fontsize=drawing.FONT,
            )  # fmt: skip
    axes.set_xlim(0.0, 1.18 * top)
