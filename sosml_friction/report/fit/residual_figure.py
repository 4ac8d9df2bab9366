# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the fitted law leaves of friction, where a structure in it would be seen."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from sosml_friction.report.common.drawing import (
    FONT,
    GREY,
    label_axes,
    legend_below,
    marker_edge,
    new_figure,
    style_of,
)
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.law_curve import fitted_law
from sosml_friction.report.fit.joint_view import JointView
from sosml_friction.report.fit.overview_figure import shown_estimates

FloatArray = NDArray[np.float64]

#: Direction of motion: colours of samples and of means, words.
_WAYS = ((1.0, '#56B4E9', '#0072B2', 'v > 0'), (-1.0, '#E69F00', '#A84800', 'v < 0'))
_POINTS = 2500
_BINS = 40
#: A mean of fewer samples is not drawn.
_FEWEST_IN_BIN = 5
#: Lags of the autocorrelation: at most so long [s], and this share of the longest window.
_LONGEST_LAG_S, _LAG_SHARE = 1.0, 0.5


class Residual(NamedTuple):
    """
    Hold what the law of one observer leaves of its estimate.

    ``samples`` (M,) are the samples, inside the windows used, or in motion where there are none;
    ``value`` (M,) [Nm or N] is estimate - law. ``runs`` (M,) numbers the windows.
    """

    samples: NDArray[np.int64]
    value: FloatArray
    runs: NDArray[np.int64]


def law_residual(view: JointView, observer: str) -> Residual | None:
    """Return what the law leaves of an observer's estimate, None where there is no law."""
    law = fitted_law(view.fits[observer].fit)
    if law is None:
        return None
    residual = view.estimates[observer] - law.torque(np.nan_to_num(view.speed))
    known = np.isfinite(residual) & np.isfinite(view.speed)
    runs = np.full(len(residual), -1)
    for k, segment in enumerate(view.segments):
        if not segment.rejected:
            runs[segment.first : segment.last + 1] = k
    if not (known & (runs >= 0)).any():
        moving = np.abs(np.nan_to_num(view.speed)) > view.zero_band
        runs = np.where(moving, np.cumsum(np.append(0, np.diff(moving.astype(int)) != 0)), -1)
    index = np.flatnonzero(known & (runs >= 0))
    return Residual(index, residual[index], runs[index])


def residual_figure(view: JointView) -> Figure | None:
    """
    Draw the residual of the model's fit against velocity, position and time, and with itself.

    Samples in the windows used (in motion where there are none), by direction of motion, with
    their mean in bins; against velocity also the levels of the windows of each observer, with the
    standard deviation of the residual of the fit. The last panel is the autocorrelation within
    windows, with the 95 % band of white noise. None where there is no law.
    """
    observer = view.preferred
    residual = None if observer is None else law_residual(view, observer)
    if observer is None or residual is None or not len(residual.samples):
        return None
    figure = new_figure(10.0, 6.6)
    panels = np.asarray(figure.subplots(2, 2, width_ratios=(1.0, 1.0)))
    by_velocity, by_position, by_time, with_itself = panels.ravel()
    unit = f'[{view.effort_unit}]'
    for axes, x, label in (
        (by_velocity, view.speed, f'velocity [{view.velocity_unit}]'),
        (by_position, view.q, f'position [{view.position_unit}]'),
        (by_time, view.time, 'time [s]'),
    ):
        _scatter(axes, view, residual, x)
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        label_axes(axes, label, f'estimate − law {unit}')
    _window_means(by_time, view, residual)
    handles, largest = _levels(by_velocity, view)
    std = view.fits[observer].fit.residual_std
    for side in (-1.0, 1.0):
        by_velocity.axhline(side * std, color=GREY, linestyle=':', linewidth=1.2)
    reach = float(np.quantile(np.abs(residual.value), 0.995))
    for axes in (by_velocity, by_position, by_time):
        height = 1.15 * (max(reach, largest) if axes is by_velocity else reach)
        axes.set_ylim(-height, height)
    white = _draw_autocorrelation(with_itself, view, residual)
    figure.align_ylabels(panels[:, 0])
    figure.align_ylabels(panels[:, 1])
    of = observer_label(observer)
    handles = [
        *(
            Line2D([], [], linestyle='', marker='.', markersize=8, color=colour,
                   label=f'{of}, samples, {text}')
            for _, colour, _, text in _WAYS
        ),
        Line2D([], [], color=GREY, linewidth=2.0, label='mean in a bin or window'),
        Line2D([], [], color=GREY, linestyle=':', label='± residual std of the fit'),
        *handles,
    ]  # fmt: skip
    if white:
        handles.append(Patch(color='#dddddd', linewidth=0, label='95 % of white noise'))
    legend_below(figure, handles)
    return figure


def _scatter(axes: Axes, view: JointView, residual: Residual, x: FloatArray) -> None:
    place, way = x[residual.samples], np.sign(view.speed[residual.samples])
    for sign, pale, colour, _ in _WAYS:
        mine = np.flatnonzero((way == sign) & np.isfinite(place))
        kept = mine[:: max(1, len(mine) // _POINTS)]
        axes.plot(place[kept], residual.value[kept], linestyle='', marker='.', markersize=3.5,
                  color=pale, alpha=0.35, markeredgewidth=0, zorder=1.5)  # fmt: skip
        if x is view.q and len(mine):
            middle, mean = binned_mean(place[mine], residual.value[mine])
            axes.plot(middle, mean, color='white', linewidth=3.2, zorder=2.4)
            axes.plot(middle, mean, color=colour, linewidth=1.8, zorder=2.5)


def _window_means(axes: Axes, view: JointView, residual: Residual) -> None:
    """Draw the mean of each window as long as the window is."""
    for part in np.split(
        np.arange(len(residual.samples)), np.flatnonzero(np.diff(residual.runs)) + 1
    ):
        samples = residual.samples[part]
        mean = float(np.mean(residual.value[part]))
        colour = _WAYS[0 if np.mean(view.speed[samples]) > 0.0 else 1][2]
        span = view.time[[samples[0], samples[-1]]]
        axes.plot(span, [mean, mean], color='white', linewidth=4.2, zorder=2.4)
        axes.plot(span, [mean, mean], color=colour, linewidth=2.4, zorder=2.5)


def binned_mean(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the middles of equal bins of x, and the mean of y in each, NaN where it has few."""
    edges = np.linspace(float(x.min()), float(x.max()), _BINS + 1)
    where = np.clip(np.digitize(x, edges) - 1, 0, _BINS - 1)
    count = np.bincount(where, minlength=_BINS)
    total = np.bincount(where, weights=y, minlength=_BINS)
    mean = np.where(count >= _FEWEST_IN_BIN, total / np.maximum(count, 1), np.nan)
    return 0.5 * (edges[1:] + edges[:-1]), mean


def _levels(axes: Axes, view: JointView) -> tuple[list[Any], float]:
    """Draw what the law of each observer leaves of its levels; return legend and largest."""
    handles: list[Any] = []
    largest = 0.0
    names = list(view.estimates)
    for observer in shown_estimates(view):
        fit = view.fits.get(observer)
        law = None if fit is None else fitted_law(fit.fit)
        if fit is None or law is None:
            continue
        style = style_of(observer, names.index(observer))
        look: dict[str, Any] = {
            'linestyle': '',
            'marker': style.marker,
            'markersize': 6,
            'color': style.colour,
            'markeredgecolor': marker_edge(style),
            'markeredgewidth': 0.7,
        }
        used = [k for k, segment in enumerate(fit.segments) if not segment.rejected]
        velocity = np.array([fit.segments[k].velocity for k in used], dtype=float)
        residual = fit.levels[used] - law.torque(velocity)
        axes.plot(velocity, residual, zorder=4, **look)
        largest = max(largest, float(np.max(np.abs(np.nan_to_num(residual)), initial=0.0)))
        label = f'{observer_label(observer)}, level of a window'
        handles.append(Line2D([], [], label=label, **look))
    return handles, largest


def autocorrelation(residual: Residual, lags: int) -> tuple[FloatArray, NDArray[np.int64]]:
    """
    Return the autocorrelation of a residual within its windows, lags 0 to ``lags``, and its pairs.

    Sum of products of samples so far apart in the same window, over the root of the product of
    the sums of their squares, so that it is never above 1; NaN where there is no pair. The mean
    is not taken off: what the law leaves on average in a window is structure too.
    """
    parts = np.split(residual.value, np.flatnonzero(np.diff(residual.runs)) + 1)
    product, before, after = (np.zeros(lags + 1) for _ in range(3))
    pairs = np.zeros(lags + 1, dtype=np.int64)
    for part in parts:
        count = min(lags + 1, len(part))
        lag = np.arange(count)
        size = 1 << (2 * len(part) - 1).bit_length()
        product[:count] += np.fft.irfft(np.abs(np.fft.rfft(part, size)) ** 2, size)[:count]
        energy = np.append(0.0, np.cumsum(part**2))
        before[:count] += energy[len(part) - lag]
        after[:count] += energy[-1] - energy[lag]
        pairs[:count] += len(part) - lag
    scale = np.sqrt(before * after)
    result = np.full(lags + 1, np.nan)
    result[scale > 0.0] = product[scale > 0.0] / scale[scale > 0.0]
    return result, pairs


def _draw_autocorrelation(axes: Axes, view: JointView, residual: Residual) -> bool:
    """Draw the autocorrelation and return True, or False where it is not known."""
    _, sizes = np.unique(residual.runs, return_counts=True)
    step = float(np.median(np.diff(view.time)))
    lags = int(min(_LONGEST_LAG_S / step, _LAG_SHARE * sizes.max())) if step > 0.0 else 0
    label_axes(axes, 'lag [s]', 'autocorrelation [1]')
    if lags < 2:
        axes.text(0.5, 0.5, 'windows too short', transform=axes.transAxes, ha='center',
                  va='center', fontsize=FONT, color=GREY)  # fmt: skip
        return False
    values, pairs = autocorrelation(residual, lags)
    lag = step * np.arange(lags + 1)
    half = 1.96 / np.sqrt(np.maximum(pairs, 1))
    axes.fill_between(lag, -half, half, color='#dddddd', linewidth=0, zorder=1.0)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    colour = style_of(
        view.preferred or '', list(view.estimates).index(view.preferred or '')
    ).colour
    axes.plot(lag, values, color=colour, linewidth=1.6)
    axes.set_ylim(min(-0.4, float(np.nanmin(values)) - 0.05), 1.05)
    return True
