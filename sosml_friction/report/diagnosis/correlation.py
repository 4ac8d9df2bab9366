# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figure of time: whether the rest is noise, and whether effort and position are in step."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.interpolate import CubicSpline

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.report.common.drawing import (
    AFTER,
    BEFORE,
    FONT,
    GREY,
    FloatArray,
    fix_axes,
    label_axes,
    new_figure,
)

#: Longest lag of the autocorrelation [s].
_LONGEST_S = 1.5
#: Shifts of effort that are tried, to each side [s], and how many.
_SHIFT_S, _SHIFTS = 0.02, 41
#: Of white noise 99 % of the lags stay below this many standard deviations.
_BOUND = 2.576


def autocorrelation(e: FloatArray, lags: int) -> FloatArray:
    """Return sum e_t e_(t+k) / sum e_t^2 for k = 0 ... lags, (lags + 1,)."""
    size = 2 ** int(np.ceil(np.log2(len(e) + lags + 1)))
    spectrum = np.abs(np.fft.rfft(e, size)) ** 2
    products = np.fft.irfft(spectrum, size)[: lags + 1]
    return np.asarray(products / max(float(products[0]), 1e-300))


def shifted_error(measured: FloatArray, left: FloatArray, step: float, shifts: FloatArray,
                  ends: tuple[int, ...]) -> FloatArray:  # fmt: skip
    """
    Return the root mean square of measured(t + d) - modelled(t) for each shift d, (shifts,).

    modelled = measured - left; measured is interpolated by cubic splines within each stretch,
    which end at the rows ``ends``.
    """
    total, count = np.zeros(len(shifts)), 0
    for a, b in zip((0, *ends), (*ends, len(measured)), strict=True):
        t = step * np.arange(b - a)
        edge = int(np.ceil(np.abs(shifts).max() / step)) + 1
        if b - a < 4 * edge + 8:
            continue
        spline = CubicSpline(t, measured[a:b])
        modelled = (measured - left)[a:b][edge:-edge]
        for k, d in enumerate(shifts):
            total[k] += float(np.sum((spline(t[edge:-edge] + d) - modelled) ** 2))
        count += len(modelled)
    return np.sqrt(total / max(count, 1))


def lowest(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Return where y is least and how much that is: of the parabola through the lowest points."""
    k = int(np.clip(np.argmin(y), 1, len(y) - 2))
    a, b, c = (float(value) for value in y[k - 1 : k + 2])
    bend = a - 2.0 * b + c
    shift = 0.5 * (a - c) / bend if bend > 0.0 else 0.0
    shift = float(np.clip(shift, -1.0, 1.0))
    return float(x[k] + shift * (x[1] - x[0])), b - 0.25 * (a - c) * shift


def correlation(diagnosis: Diagnosis, i: int, before: FloatArray, after: FloatArray,
                rows: dict[str, FloatArray]) -> Figure:  # fmt: skip
    """
    Return the autocorrelation of the whitened rest, and the error were effort earlier or later.

    A rest that is noise stays within the dotted lines. The lowest point of the curve on the right
    is by how much the measured effort is later than the model says.
    """
    laboratory, selection = diagnosis.laboratory, diagnosis.selection
    assert laboratory is not None
    assert selection is not None
    step = laboratory.signals[0].band.output_step
    figure = new_figure(10.0, 3.2)
    left, right = figure.subplots(1, 2)
    lags = max(2, round(_LONGEST_S / step))
    white = (
        (laboratory.y[:, i] - laboratory.system.Z[:, i] @ selection.before.x, BEFORE),
        (laboratory.y[:, i] - selection.system.Z[:, i] @ selection.after.x, AFTER),
    )
    for e, colour in white:
        left.plot(
            step * np.arange(1, lags + 1), autocorrelation(e, lags)[1:], color=colour, lw=1.2
        )
    bound = _BOUND / np.sqrt(len(laboratory.y))
    for level in (-bound, bound):
        left.axhline(level, color='black', linestyle=':', linewidth=1.0)
    label_axes(left, 'lag [s]', 'autocorrelation')
    left.set_title('whitened rest; dotted: 99 % of noise', fontsize=FONT, loc='left')
    lengths = [len(part) for part in laboratory.split(before)]
    ends = tuple(int(x) for x in np.cumsum(lengths)[:-1])
    shifts = np.linspace(-_SHIFT_S, _SHIFT_S, _SHIFTS)
    for values, colour in ((before, BEFORE), (after, AFTER)):
        error = shifted_error(rows['tau'][:, i], values[:, i], step, shifts, ends)
        right.plot(1e3 * shifts, error, color=colour, linewidth=1.4)
        place, least = lowest(shifts, error)
        right.plot(1e3 * place, least, 'o', color=colour)
        right.annotate(
            f'{1e3 * place:.1f} ms',
            (1e3 * place, least),
            xytext=(6, -4 if colour == AFTER else 8),
            textcoords='offset points',
            fontsize=FONT,
            color=colour,
            in_layout=False,
        )
    right.axvline(0.0, color=GREY, linewidth=0.8)
    right.set_ylim(bottom=0.0)
    label_axes(right, 'effort later than position by [ms]', f'error [{diagnosis.units[i]}]')
    right.set_title('error with effort shifted', fontsize=FONT, loc='left')
    handles = [
        Line2D([], [], color=BEFORE, label='refitted model'),
        Line2D([], [], color=AFTER, label='with what was named'),
    ]
    fix_axes(figure, (0.85, 0.15, 0.95, 0.35), (0.9, 0.2), handles)
    return figure
