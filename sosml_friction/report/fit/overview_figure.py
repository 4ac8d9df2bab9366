# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The recording over time: the counterpart of the paper's Figure 5."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from sosml_friction.observers.signal_noise import signal_noise
from sosml_friction.report.common.drawing import (
    FONT,
    GREY,
    draw_line,
    label_axes,
    legend_below,
    new_figure,
    style_of,
)
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.law_curve import fitted_law
from sosml_friction.report.fit.joint_view import WINDOW_S, JointView
from sosml_friction.report.fit.segment_marks import number_rejected, shade_segments
from sosml_friction.report.fit.segment_rows import segment_rows

FloatArray = NDArray[np.float64]

_LAW, _REPORTED = 'black', '#b8b8b8'
#: More estimates than this over one another cannot be told apart.
_MOST_LINES = 4
_WIDTH_IN = 10.0
#: Height of a panel that has nothing to show, as a share of another's.
_UNKNOWN = 0.6
#: Share of the figure's width that the axes have, near enough to place marks.
_AXES_SHARE = 0.92


def overview_figure(view: JointView) -> Figure:
    """
    Draw position, velocity, effort and estimated friction over time with the law's prediction.

    Windows of steady motion are shaded; those not used are hatched and have the number of their
    row in the table, the legend says why. Lines of many samples are drawn as their envelope. Of
    many observers those of :func:`shown_estimates` are drawn.
    """
    heights = [
        1.0,
        1.0,
        1.0 if np.isfinite(view.tau).any() else _UNKNOWN,
        1.7 if any(np.isfinite(x).any() for x in view.estimates.values()) else _UNKNOWN,
    ]
    figure = new_figure(_WIDTH_IN, 1.2 + 1.6 * sum(heights))
    axes: Sequence[Axes] = figure.subplots(4, 1, sharex=True, height_ratios=heights)
    time = view.time
    draw_line(axes[0], time, view.q, color='black', linewidth=1.0)
    reported = np.isfinite(view.v).any()
    if reported:
        draw_line(axes[1], time, view.v, color=_REPORTED, linewidth=0.8)
    draw_line(axes[1], time, view.speed, color='black', linewidth=1.0)
    draw_line(axes[2], time, view.tau, color='black', linewidth=0.8)
    handles, known = _draw_friction(axes[3], view)
    if reported:
        handles.append(Line2D([], [], color=_REPORTED, linewidth=2.0, label='velocity, reported'))
        handles.append(
            Line2D([], [], color='black', linewidth=1.0, label='velocity, position difference')
        )
    rows = segment_rows(view)
    handles += shade_segments(axes, rows)
    _robust_height(axes[3], np.concatenate(known) if known else np.zeros(0))
    names = ('position', 'velocity', 'effort', 'friction τ_f')
    units = (view.position_unit, view.velocity_unit, view.effort_unit, view.effort_unit)
    for axis, name, unit in zip(axes, names, units, strict=True):
        label_axes(axis, '', f'{name} [{unit}]')
        axis.margins(x=0.01)
    number_rejected(axes[0], rows, 72.0 * _WIDTH_IN * _AXES_SHARE)
    for axis, missing in (
        (axes[2], np.isnan(view.tau).all()),
        (axes[3], not sum(map(len, known))),
    ):
        if missing:
            axis.set_yticks([])
            axis.set_ylabel(axis.get_ylabel().replace(' [', '\n['), fontsize=FONT)
            axis.text(0.5, 0.5, 'unknown', transform=axis.transAxes, ha='center', va='center',
                      fontsize=FONT, color=GREY)  # fmt: skip
    if any(map(len, known)):
        axes[3].axhline(0.0, color=GREY, linewidth=0.6)
    axes[3].set_xlabel('time [s]', fontsize=FONT)
    figure.align_ylabels(axes)
    if handles:
        legend_below(figure, handles)
    return figure


def shown_estimates(view: JointView) -> list[str]:
    """Return which estimates a figure shows over one another: the model's and the first others."""
    first = [] if view.preferred is None else [view.preferred]
    others = [name for name in view.estimates if name not in first]
    chosen = {*first, *others[: _MOST_LINES - len(first)]}
    return [name for name in view.estimates if name in chosen]


def standstill(view: JointView) -> float:
    """Return the speed that is not told from standstill: the zero band, or two counts' worth."""
    return max(view.zero_band, 2.0 * signal_noise(view.q)[0] / WINDOW_S)


def _draw_friction(axes: Axes, view: JointView) -> tuple[list[Any], list[FloatArray]]:
    """Draw the estimates and the law; return legend entries and all that is finite of them."""
    handles: list[Any] = []
    known = []
    names = list(view.estimates)
    for place, observer in enumerate(shown_estimates(view)):
        tau_f = view.estimates[observer]
        if not np.isfinite(tau_f).any():
            continue
        known.append(tau_f[np.isfinite(tau_f)])
        colour = style_of(observer, names.index(observer)).colour
        draw_line(axes, view.time, tau_f, color=colour, linewidth=1.8 if place == 0 else 1.0)
        handles.append(Line2D([], [], color=colour, linewidth=2.0, label=observer_label(observer)))
    law = None if view.preferred is None else fitted_law(view.fits[view.preferred].fit)
    if law is not None and view.preferred is not None:
        # At rest friction is what holds the joint: the law says nothing of it.
        # Nor does it where it is slower than all data it was fitted to.
        slowest = np.nan_to_num(view.fits[view.preferred].fit.slowest)
        moving = np.abs(np.nan_to_num(view.speed)) > max(standstill(view), 0.5 * slowest)
        predicted = np.where(moving, law.torque(view.speed), np.nan)
        known.append(predicted[np.isfinite(predicted)])
        draw_line(axes, view.time, predicted, color=_LAW, linewidth=1.0, linestyle='--')
        text = f'law fitted to {observer_label(view.preferred)}'
        handles.append(Line2D([], [], color=_LAW, linewidth=1.0, linestyle='--', label=text))
    return handles, known


def _robust_height(axes: Axes, values: FloatArray) -> None:
    """Cut the height at a start-up spike that would flatten all the rest."""
    if not len(values):
        return
    low, high = (float(x) for x in np.quantile(values, (0.001, 0.999)))
    reach = max(high - low, 1e-12)
    low, high = max(low - reach, float(values.min())), min(high + reach, float(values.max()))
    axes.set_ylim(low - 0.06 * reach, high + 0.06 * reach)
