# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the rest is noise, and whether effort is measured on time."""

from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.residual.joint_residual import JointResidual
from sosml_friction.diagnosis.residual.timing import (
    errors_by_shift,
    lowest,
    whitened_autocorrelation,
)
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure


class Timing(Figure[JointResidual]):
    """Draw the autocorrelation of the whitened rest, and the error by the time of effort."""

    identifier = 'timing'
    title = 'Noise, and the time of effort'
    report = 'diagnosis'
    order = 40
    caption = (
        'Left: is the rest noise? Right: error if effort were measured earlier or later; '
        'dots: where it is least'
    )

    def applies(self, view: JointResidual) -> bool:
        return view.diagnosis.selection is not None

    def draw(self, view: JointResidual) -> Drawing:
        figure = drawing.new_figure(10.0, 3.2)
        left, right = figure.subplots(1, 2)
        colours = (drawing.BEFORE, drawing.AFTER)
        lags, correlations, bound = whitened_autocorrelation(view)
        for values, colour in zip(correlations, colours, strict=True):
            left.plot(lags, values, color=colour, lw=1.2)
        for level in (-bound, bound):
            left.axhline(level, color='black', linestyle=':', linewidth=1.0)
        drawing.label_axes(left, 'lag [s]', 'autocorrelation [1]')
        left.set_title('whitened rest; dotted: 99 % of noise', fontsize=drawing.FONT, loc='left')
        shifts, errors = errors_by_shift(view)
        for error, colour in zip(errors, colours, strict=True):
            right.plot(1e3 * shifts, error, color=colour, linewidth=1.4)
            place, least = lowest(shifts, error)
            right.plot(1e3 * place, least, 'o', color=colour)
            right.annotate(
                milliseconds(place), (1e3 * place, least), textcoords='offset points',
                xytext=(6, -4 if colour == drawing.AFTER else 8), fontsize=drawing.FONT,
                color=colour, in_layout=False,
            )  # fmt: skip
        right.axvline(0.0, color=drawing.GREY, linewidth=0.8)
        right.set_ylim(bottom=0.0)
        drawing.label_axes(right, 'effort later than position by [ms]', f'error [{view.unit}]')
        right.set_title('error with effort shifted', fontsize=drawing.FONT, loc='left')
        drawing.fix_axes(figure, (0.85, 0.15, 0.95, 0.35), (0.9, 0.2), drawing.before_and_after())
        return figure


def milliseconds(seconds: float) -> str:
    """Return a time in ms with one decimal, its zero without a sign."""
    return f'{round(1e3 * seconds, 1) + 0.0:.1f} ms'
