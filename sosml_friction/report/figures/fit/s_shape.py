# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction against velocity, a panel per observer: the counterpart of the paper's Figure 6."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from sosml_friction.identification.joint_motion import level_spreads
from sosml_friction.identification.law.law_curve import band, fitted_law
from sosml_friction.model.friction_law import FrictionLaw
from sosml_friction.report.common.drawing import (
    FONT,
    GREY,
    Style,
    label_axes,
    legend_below,
    marker_edge,
    new_figure,
)
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.fit.joint_view import JointView

FloatArray = NDArray[np.float64]

_COLUMNS = 3
#: Points of one scatter that a panel shows.
_SCATTER_POINTS = 1500
#: Windows not used that a panel shows: the longest ones.
_REJECTED_SHOWN = 40
#: How far beyond the data an extrapolated law is followed, as a share of their height.
_BEYOND = 0.2
_PALE = '#b0b0b0'
_ZERO_BAND = '#ece7d8'
#: The panel of speeds begins at this share of the zero band, at most so far below the data.
_BELOW_BAND, _DEEPEST = 0.6, 1e-3


class _Levels(NamedTuple):
    """Hold what the windows say of friction: velocity, level and spread, which are used."""

    velocity: FloatArray
    level: FloatArray
    spread: FloatArray
    used: NDArray[np.bool_]
    shown: NDArray[np.bool_]


class SShape(Figure[JointView]):
    """
    Draw tau_f against velocity and against the logarithm of speed, two panels per observer.

    Samples (thinned), levels of windows with the standard deviation within each, the fitted law
    with its 95 % band, the truth where it is known; windows not used are pale. The law is dotted
    below the slowest window used: there it is extrapolated. The lower panels have the friction
    that opposes motion, sgn(v) (tau_f - bias), of both directions over one another, so that the
    knee and what is not symmetric are seen.
    """

    identifier = 's_shape'
    title = 'Friction against velocity'
    report = 'fit'
    of = JointView
    order = 10

    def caption(self, view: JointView) -> str:
        """Return what the panels show and what to look for."""
        certainty = ' with its 95 % band' if _any_band(view) else ''
        return (
            f'S-shape of joint {view.name}: samples (thinned), levels of steady windows with the '
            f'standard deviation within each, the fitted law{certainty}, for each observer. '
            'Below, both directions over one another against the logarithm of speed: a knee is '
            'extra friction at low speed (Stribeck), triangles apart are friction that is not '
            'symmetric. Loops between plateaus are the observers’ lag while velocity changes.'
        )

    def applies(self, view: JointView) -> bool:
        """Tell whether there is a fit."""
        return view.preferred is not None

    def draw(self, view: JointView) -> Drawing:
        """Draw blocks of up to three observers below one another."""
        observers = list(view.fits)
        blocks = [observers[k : k + _COLUMNS] for k in range(0, len(observers), _COLUMNS)]
        figure = new_figure(10.0, 6.2 * len(blocks) + 0.5)
        columns = min(len(observers), _COLUMNS)
        panels = np.asarray(figure.subplots(2 * len(blocks), columns, squeeze=False))
        top = _top_speed(view)
        levels = {observer: _levels(view, observer) for observer in observers}
        span = _log_span(view, top)
        height = _height(view, levels, 1.05 * top, span[0], by_direction=False)
        opposing = _height(view, levels, 1.05 * top, span[0], by_direction=True)
        for (row, block), place in itertools.product(enumerate(blocks), range(columns)):
            whole, knee = panels[2 * row, place], panels[2 * row + 1, place]
            if place >= len(block):
                whole.set_visible(False)
                knee.set_visible(False)
                continue
            observer = block[place]
            _draw_whole(whole, view, observer, levels[observer], 1.05 * top)
            whole.set_ylim(height)
            _draw_knee(knee, view, observer, levels[observer], span)
            knee.set_ylim(opposing)
            unit = view.effort_unit
            label_axes(whole, f'velocity [{view.velocity_unit}]', f'friction τ_f [{unit}]')
            label_axes(knee, f'speed [{view.velocity_unit}]', f'sgn(v) (τ_f − bias) [{unit}]')
            if place:
                whole.set_ylabel('')
                knee.set_ylabel('')
            whole.locator_params(axis='x', nbins=5)
            mark = ' (the model)' if observer == view.preferred else ''
            whole.set_title(observer_label(observer) + mark, fontsize=FONT, fontweight='bold')
            figure.align_ylabels(panels[:, 0])
        legend_below(figure, _legend(view))
        return figure


def _any_band(view: JointView) -> bool:
    return any(band(fit.fit, np.ones(1)) is not None for fit in view.fits.values())


def _levels(view: JointView, observer: str) -> _Levels:
    fit = view.fits[observer]
    rejected = np.array([bool(s.rejected) for s in fit.segments], dtype=bool)
    length = np.array([s.end_s - s.start_s for s in fit.segments], dtype=float)
    shown = np.zeros(len(rejected), dtype=bool)
    shown[np.argsort(-np.where(rejected, length, -1.0), kind='stable')[:_REJECTED_SHOWN]] = True
    return _Levels(
        np.array([segment.velocity for segment in fit.segments], dtype=float),
        np.asarray(fit.levels, dtype=float),
        level_spreads(view.segments, view.estimates[observer]),
        ~rejected,
        shown & rejected,
    )


def _draw_whole(axes: Axes, view: JointView, observer: str, levels: _Levels, limit: float) -> None:
    style = view.style(observer)
    axes.axvspan(-view.zero_band, view.zero_band, color=_ZERO_BAND, zorder=0.4, linewidth=0)
    inside = np.flatnonzero(
        np.isfinite(view.estimates[observer])
        & (np.abs(np.nan_to_num(view.speed, nan=np.inf)) <= limit)
    )
    _scatter(axes, view.speed, view.estimates[observer], inside, '.', style)
    fit = view.fits[observer]
    law, slowest = fitted_law(fit.fit), fit.fit.slowest
    v = np.geomspace(1e-4 * limit, limit, 300)
    # Two branches: a law with sgn(v) has no line across zero.
    for branch in (v, -v):
        if law is not None:
            half = band(fit.fit, branch)
            _law(axes, branch, law.torque(branch), half, np.abs(branch) >= slowest, style)
        if view.truth is not None:
            _truth(axes, branch, view.truth.make_law().torque(branch))
    for rejected in (True, False):
        some = levels.shown if rejected else levels.used
        _points(axes, levels.velocity[some], levels.level[some], levels.spread[some],
                style.marker, style, rejected)  # fmt: skip
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    axes.axvline(0.0, color=GREY, linewidth=0.6)
    axes.set_xlim(-limit, limit)


def _draw_knee(
    axes: Axes, view: JointView, observer: str, levels: _Levels, span: tuple[float, float]
) -> None:
    style, fit = view.style(observer), view.fits[observer]
    bias = _bias(view, observer)
    axes.axvspan(span[0], max(view.zero_band, span[0]), color=_ZERO_BAND, zorder=0.4, linewidth=0)
    speed, tau_f = view.speed, view.estimates[observer]
    law, slowest = fitted_law(fit.fit), fit.fit.slowest
    v = np.geomspace(*span, 300)
    for way, marker in ((1.0, '^'), (-1.0, 'v')):
        inside = np.flatnonzero(np.isfinite(tau_f) & (way * np.nan_to_num(speed) >= span[0]))
        _scatter(axes, way * speed, way * (tau_f - bias), inside, '.', style)
        for rejected in (True, False):
            some = (levels.shown if rejected else levels.used) & (way * levels.velocity > 0.0)
            _points(axes, way * levels.velocity[some], way * (levels.level[some] - bias),
                    levels.spread[some], marker, style, rejected)  # fmt: skip
    # Both directions of a symmetric law are one line.
    ways = (1.0, -1.0) if law is not None and 'viscous_asymmetry' in law.parameters else (1.0,)
    for way in ways:
        if law is not None:
            y = way * (law.torque(way * v) - bias)
            _law(axes, v, y, band(fit.fit, way * v), v >= slowest, style)
    if view.truth is not None:
        known = view.truth.parameters.get('bias')
        offset = 0.0 if known is None else known.value
        _truth(axes, v, view.truth.make_law().torque(v) - offset)
    axes.set_xscale('log')
    axes.set_xlim(span)


def _law(
    axes: Axes,
    v: FloatArray,
    y: FloatArray,
    half: FloatArray | None,
    measured: NDArray[np.bool_],
    style: Style,
) -> None:
    """Draw a law, dotted where it is extrapolated, with its band where it is measured."""
    seen = measured if measured.any() else np.ones(len(v), dtype=bool)
    if half is not None:
        axes.fill_between(v, y - half, y + half, color=style.colour, alpha=0.25, linewidth=0,
                          zorder=2.0)  # fmt: skip
    axes.plot(v, np.where(seen, y, np.nan), color=style.colour, linewidth=1.8, zorder=2.5)
    if not seen.all():
        axes.plot(v, np.where(seen, np.nan, y), color=style.colour, linewidth=1.8,
                  linestyle=':', zorder=2.5)  # fmt: skip


def _truth(axes: Axes, v: FloatArray, y: FloatArray) -> None:
    axes.plot(v, y, color='black', linestyle='--', linewidth=1.1, zorder=2.7)


def _points(
    axes: Axes,
    x: FloatArray,
    y: FloatArray,
    spread: FloatArray,
    marker: str,
    style: Style,
    rejected: bool,
) -> None:
    """Draw levels with their spread; pale and hollow where they are not used."""
    axes.errorbar(
        x, y, np.nan_to_num(spread), fmt=marker, markersize=6,
        color=_PALE if rejected else style.colour,
        markerfacecolor='white' if rejected else style.colour,
        markeredgecolor=_PALE if rejected else marker_edge(style._replace(marker=marker)),
        markeredgewidth=1.0 if rejected else 0.7,
        elinewidth=0.9, capsize=0, zorder=3.2 if rejected else 4,
    )  # fmt: skip


def _scatter(
    axes: Axes,
    x: FloatArray,
    y: FloatArray,
    inside: NDArray[np.intp],
    marker: str,
    style: Style,
) -> None:
    kept = inside[:: max(1, len(inside) // _SCATTER_POINTS)]
    axes.plot(
        x[kept], y[kept], linestyle='', marker=marker, markersize=3.0, color=style.colour,
        alpha=0.22, markeredgewidth=0.0, zorder=1.5,
    )  # fmt: skip


def _bias(view: JointView, observer: str) -> float:
    law = fitted_law(view.fits[observer].fit)
    return 0.0 if law is None else law.parameters.get('bias', 0.0)


def _top_speed(view: JointView) -> float:
    speeds = np.abs(view.speed[np.isfinite(view.speed)])
    top = float(speeds.max()) if len(speeds) else 0.0
    return top if top > 0.0 else 1.0


def _log_span(view: JointView, top: float) -> tuple[float, float]:
    """Return the speeds of the lower panels: from inside the zero band to the fastest."""
    lowest = max(_BELOW_BAND * view.zero_band, _DEEPEST * top)
    return min(lowest, 0.1 * top), 1.1 * top


def _height(
    view: JointView,
    levels: dict[str, _Levels],
    limit: float,
    slowest: float,
    by_direction: bool,
) -> tuple[float, float]:
    """Choose the height by what samples, levels and laws reach, spikes left out."""
    values = [] if by_direction else [np.zeros(1)]
    beyond = []
    speed = np.abs(np.nan_to_num(view.speed))
    side = np.sign(np.nan_to_num(view.speed))
    inside = np.abs(np.nan_to_num(view.speed, nan=np.inf)) <= limit
    v = np.geomspace(slowest, limit, 60)
    for observer, some in levels.items():
        tau_f, fit = view.estimates[observer], view.fits[observer].fit
        law, known = fitted_law(fit), inside & np.isfinite(tau_f)
        bias = _bias(view, observer) if by_direction else 0.0
        way = np.sign(some.velocity) if by_direction else np.ones(len(some.velocity))
        slow = _slowest(some, fit.slowest)
        # Below the data only transients of reversals are left, which would flatten the knee.
        floor = max(0.5 * slow, view.zero_band) if np.isfinite(slow) else view.zero_band
        samples, share = tau_f[known], 0.005
        if by_direction:
            moving = known & (speed > floor)
            samples, share = side[moving] * (tau_f[moving] - bias), 0.05
        if len(samples):
            values.append(np.quantile(samples, (share, 1.0 - share)))
        spread = np.where(some.used, np.nan_to_num(some.spread), 0.0)
        for sign in (-1.0, 1.0):
            reach = way * (some.level - bias) + sign * spread
            values.append(reach[some.used | some.shown])
        if law is not None:
            values.append(_curves(law, v[v >= floor], bias, by_direction))
            if law.smoothing_velocity == 0.0:
                beyond.append(_curves(law, v, bias, by_direction))
        if view.truth is not None:
            truth = view.truth.make_law()
            true_bias = truth.parameters.get('bias', 0.0) if by_direction else 0.0
            values.append(_curves(truth, v[v >= floor], true_bias, by_direction))
    everything = np.concatenate(values) if values else np.zeros(0)
    everything = everything[np.isfinite(everything)]
    if not len(everything):
        return -1.0, 1.0
    low, high = float(everything.min()), float(everything.max())
    span = high - low or 1.0
    # What is extrapolated may run out of the panel.
    lowest = min([low, *(max(float(x.min()), low - _BEYOND * span) for x in beyond)])
    highest = max([high, *(min(float(x.max()), high + _BEYOND * span) for x in beyond)])
    return lowest - 0.07 * span, highest + 0.07 * span


def _curves(law: FrictionLaw, v: FloatArray, bias: float, by_direction: bool) -> FloatArray:
    """Return the law at both directions of some speeds, as friction or as what opposes motion."""
    backwards = law.torque(-v)
    if by_direction:
        return np.concatenate([law.torque(v) - bias, bias - backwards])
    return np.concatenate([law.torque(v), backwards])


def _slowest(levels: _Levels, otherwise: float) -> float:
    """Return the slowest speed of the windows used, of the fit where there are none."""
    used = np.abs(levels.velocity[levels.used])
    return float(used.min()) if len(used) else otherwise


def _legend(view: JointView) -> Sequence[Any]:
    grey: dict[str, Any] = {'color': GREY, 'linestyle': ''}
    handles: list[Any] = [
        Line2D([], [], marker='.', markersize=5, alpha=0.5, label='samples', **grey),
        Line2D([], [], marker='o', markeredgecolor='white', color=GREY, linestyle='',
               label='window used: level, ± std within it'),
        Line2D([], [], marker='^', label='v > 0', **grey),
        Line2D([], [], marker='v', label='v < 0', **grey),
    ]  # fmt: skip
    count = sum(bool(segment.rejected) for segment in view.segments)
    if count:
        label = 'window not used'
        if count > _REJECTED_SHOWN:
            label += f' (longest {_REJECTED_SHOWN} of {count})'
        handles.append(
            Line2D([], [], linestyle='', marker='o', markerfacecolor='white', color=_PALE,
                   label=label)
        )  # fmt: skip
    handles.append(Line2D([], [], color=GREY, linewidth=1.8, label='fitted law'))
    handles.append(
        Line2D([], [], color=GREY, linewidth=1.8, linestyle=':', label='slower than the data')
    )
    if _any_band(view):
        handles.append(Patch(color=GREY, alpha=0.3, linewidth=0, label='95 % band'))
    handles.append(Patch(color=_ZERO_BAND, linewidth=0, label='standstill, excluded'))
    if view.truth is not None:
        handles.append(Line2D([], [], color='black', linestyle='--', linewidth=1.1, label='truth'))
    return handles
