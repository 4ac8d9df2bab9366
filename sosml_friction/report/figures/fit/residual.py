# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the law leaves of friction, and whether there is a pattern in it."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.patches import Patch

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law_residual import (
    Residual,
    autocorrelation,
    binned_mean,
    lags_of,
    level_residual,
    white_band,
)
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.fit.joint_view import JointView, shown_estimates

#: Direction of motion: colours of samples and of means, words.
_WAYS = ((1.0, '#56B4E9', '#0072B2', 'v > 0'), (-1.0, '#E69F00', '#A84800', 'v < 0'))
_POINTS = 1200


class LawResidual(Figure[JointView]):
    """Draw what the model's fit leaves against velocity, position and time, and with itself."""

    identifier = 'residual'
    title = 'What the law leaves'
    report = 'fit'
    order = 40
    caption = (
        'What the law leaves of friction of joint {view.name}. A pattern over velocity is '
        'friction that the law does not have, one over position is gravity, cogging or wear, '
        'one over time is warming or drift. Autocorrelation that outlasts the observer’s own '
        'lag (for the weak form, its test functions) says that the samples are not '
        'independent.'
    )

    def applies(self, view: JointView) -> bool:
        return view.residual() is not None

    def draw(self, view: JointView) -> Drawing:
        residual = view.residual()
        assert residual is not None
        assert view.model is not None
        figure = drawing.new_figure(10.0, 6.6)
        panels = np.asarray(figure.subplots(2, 2, width_ratios=(1.0, 1.0)))
        by_velocity, by_position, by_time, with_itself = panels.ravel()
        for axes, x, label in (
            (by_velocity, view.speed, f'velocity [{view.velocity_unit}]'),
            (by_position, view.q, f'position [{view.position_unit}]'),
            (by_time, view.time, 'time [s]'),
        ):
            _scatter(axes, view, residual, x)
            axes.axhline(0.0, color=drawing.GREY, linewidth=0.8)
            drawing.label_axes(axes, label, f'estimate − law [{view.effort_unit}]')
        _window_means(by_time, view, residual)
        levels, largest = _levels(by_velocity, view)
        std = view.model.fit.residual_std
        for side in (-std, std):
            by_velocity.axhline(side, color=drawing.GREY, linestyle=':', linewidth=1.2)
        reach = float(np.quantile(np.abs(residual.value), 0.995))
        for axes in (by_velocity, by_position, by_time):
            height = 1.15 * (max(reach, largest) if axes is by_velocity else reach)
            axes.set_ylim(-height, height)
        white = _draw_autocorrelation(with_itself, view, residual)
        for column in panels.T:
            figure.align_ylabels(column)
        of = observer_label(view.preferred or '')
        handles = [
            *(
                drawing.key(linestyle='', marker='.', markersize=8, color=colour,
                       label=f'{of}, samples, {text}')
                for _, colour, _, text in _WAYS
            ),
            drawing.key(color=drawing.GREY, linewidth=2.0, label='mean in a bin or window'),
            drawing.key(color=drawing.GREY, linestyle=':', label='± residual std of the fit'),
            *levels,
        ]  # fmt: skip
        if white:
            handles.append(Patch(color='#dddddd', linewidth=0, label='95 % of white noise'))
        drawing.legend_below(figure, handles)
        return figure


def _scatter(axes: Axes, view: JointView, residual: Residual, x: FloatArray) -> None:
    place, way = x[residual.samples], np.sign(view.speed[residual.samples])
    for sign, pale, colour, _ in _WAYS:
        mine = np.flatnonzero((way == sign) & np.isfinite(place))
        kept = mine[:: max(1, len(mine) // drawing.points(_POINTS))]
        axes.plot(place[kept], residual.value[kept], linestyle='', marker='.', markersize=3.5,
                  color=pale, alpha=0.35, markeredgewidth=0, zorder=1.5)  # fmt: skip
        if x is view.q and len(mine):
            _on_white(axes, *binned_mean(place[mine], residual.value[mine]), colour, 1.8)


def _window_means(axes: Axes, view: JointView, residual: Residual) -> None:
    """Draw the mean of each window as long as the window is."""
    for part in residual.windows():
        samples = residual.samples[part]
        mean = float(np.mean(residual.value[part]))
        colour = _WAYS[0 if np.mean(view.speed[samples]) > 0.0 else 1][2]
        _on_white(axes, view.time[[samples[0], samples[-1]]], [mean, mean], colour, 2.4)


def _on_white(axes: Axes, x: Any, y: Any, colour: str, width: float) -> None:
    """Draw a line that stands out from the samples."""
    axes.plot(x, y, color='white', linewidth=1.75 * width, zorder=2.4)
    axes.plot(x, y, color=colour, linewidth=width, zorder=2.5)


def _levels(axes: Axes, view: JointView) -> tuple[list[Any], float]:
    """Draw what the law of each observer leaves of its levels; return legend and largest."""
    handles: list[Any] = []
    largest = 0.0
    for observer in shown_estimates(view):
        left = level_residual(view.fits[observer]) if observer in view.fits else None
        if left is None:
            continue
        style = view.style(observer)
        look: dict[str, Any] = {
            'linestyle': '', 'marker': style.marker, 'markersize': 6, 'color': style.colour,
            'markeredgecolor': drawing.marker_edge(style), 'markeredgewidth': 0.7,
        }  # fmt: skip
        axes.plot(*left, zorder=4, **look)
        largest = max(largest, float(np.max(np.abs(np.nan_to_num(left[1])), initial=0.0)))
        label = f'{observer_label(observer)}, level of a window'
        handles.append(drawing.key(label=label, **look))
    return handles, largest


def _draw_autocorrelation(axes: Axes, view: JointView, residual: Residual) -> bool:
    """Draw the autocorrelation and return True, or False where it is not known."""
    step = float(np.median(np.diff(view.time)))
    lags = lags_of(residual, step)
    drawing.label_axes(axes, 'lag [s]', 'autocorrelation [1]')
    if lags < 2:
        axes.text(0.5, 0.5, 'windows too short', transform=axes.transAxes, ha='center',
                  va='center', fontsize=drawing.FONT, color=drawing.GREY)  # fmt: skip
        return False
    values, pairs = autocorrelation(residual, lags)
    lag, half = step * np.arange(lags + 1), white_band(pairs)
    axes.fill_between(lag, -half, half, color='#dddddd', linewidth=0, zorder=1.0)
    axes.axhline(0.0, color=drawing.GREY, linewidth=0.8)
    axes.plot(lag, values, color=view.style(view.preferred or '').colour, linewidth=1.6)
    axes.set_ylim(min(-0.4, float(np.nanmin(values)) - 0.05), 1.05)
    return True
