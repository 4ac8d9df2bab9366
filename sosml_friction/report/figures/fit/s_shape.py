# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction against velocity, a panel per observer: the counterpart of the paper's Figure 6."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.patches import Patch

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.identification.law.law_curve import band, fitted_law
from sosml_friction.identification.law_residual import level_spreads
from sosml_friction.model.laws import FrictionLaw
from sosml_friction.report.common import drawing
from sosml_friction.report.common.drawing import Style
from sosml_friction.report.common.figure import METHOD, Figure
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.fit.joint_view import JointView

_COLUMNS = 3
#: Points of one scatter that a panel shows.
_SCATTER_POINTS = 800
#: Windows not used that a panel shows: the longest ones.
_REJECTED_SHOWN = 40
#: How far beyond the data an extrapolated law is followed, as a share of their height.
_BEYOND = 0.2
_PALE = '#b0b0b0'
_ZERO_BAND = '#ece7d8'
#: Lower end of the axis of speed: a share of the zero band, but at least this share of the
#: fastest speed. Chosen, no measurement.
_BELOW_BAND, _DEEPEST = 0.6, 1e-3


class _Levels(NamedTuple):
    """Hold what the windows say of friction: velocity, level and spread, which are used."""

    velocity: FloatArray
    level: FloatArray
    spread: FloatArray
    used: BoolArray
    shown: BoolArray


class SShape(Figure[JointView]):
    """Draw tau_f against velocity and against the logarithm of speed, two panels per observer."""

    identifier = 's_shape'
    title = 'Friction against velocity'
    report = 'fit'
    order = 10
    part = METHOD
    caption = (
        'S-shape of joint {view.name}: samples (thinned), levels of steady windows with the '
        'standard deviation within each, the fitted law with its 95 % band, for each observer. '
        'Below, both directions over one another against the logarithm of speed: a knee is '
        'extra friction at low speed (Stribeck), triangles apart are friction that is not '
        'symmetric. Loops between plateaus are the observers’ lag while velocity changes.'
    )

    def caption_of(self, view: JointView) -> str:
        """Leave out the band where no law has one."""
        text = super().caption_of(view)
        return text if has_band(view) else text.replace(' with its 95 % band', '')

    def applies(self, view: JointView) -> bool:
        return view.preferred is not None

    def draw(self, view: JointView) -> Drawing:
        """Draw blocks of up to three observers below one another."""
        observers = list(view.fits)
        blocks = [observers[k : k + _COLUMNS] for k in range(0, len(observers), _COLUMNS)]
        figure = drawing.new_figure(10.0, 6.2 * len(blocks) + 0.5)
        columns = min(len(observers), _COLUMNS)
        panels = np.asarray(figure.subplots(2 * len(blocks), columns, squeeze=False))
        levels = {observer: window_levels(view, observer) for observer in observers}
        limit = view.fastest
        fastest = limit / 1.05
        # The lower panels begin within the zero band.
        slowest = min(max(_BELOW_BAND * view.zero_band, _DEEPEST * fastest), 0.1 * fastest)
        heights = [panel_height(view, levels, limit, slowest, folded) for folded in (False, True)]
        for (row, block), place in itertools.product(enumerate(blocks), range(columns)):
            whole, knee = panels[2 * row, place], panels[2 * row + 1, place]
            if place >= len(block):
                whole.set_visible(False)
                knee.set_visible(False)
                continue
            observer = block[place]
            for axes, folded, span, x, y in (
                (whole, False, (1e-4 * limit, limit), 'velocity', 'friction τ_f'),
                (knee, True, (slowest, 1.1 * fastest), 'speed', 'sgn(v) (τ_f − bias)'),
            ):
                draw_panel(axes, view, observer, levels[observer], span, folded)
                axes.set_ylim(heights[folded])
                height = '' if place else f'{y} [{view.effort_unit}]'
                drawing.label_axes(axes, f'{x} [{view.velocity_unit}]', height)
            whole.locator_params(axis='x', nbins=5)
            mark = ' (the model)' if observer == view.preferred else ''
            whole.set_title(
                observer_label(observer) + mark, fontsize=drawing.FONT, fontweight='bold'
            )
            figure.align_ylabels(panels[:, 0])
        drawing.legend_below(figure, panel_legend(view))
        return figure


def has_band(view: JointView) -> bool:
    """Tell whether a law has a 95 % band."""
    return any(band(fit.fit, np.ones(1)) is not None for fit in view.fits.values())


def window_levels(view: JointView, observer: str) -> _Levels:
    """Return what the windows say of friction by an observer."""
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


def _fold(
    x: FloatArray, y: FloatArray, bias: float, folded: bool
) -> tuple[FloatArray, FloatArray]:
    """Return speed and the friction that opposes motion, where the directions are folded."""
    return (np.abs(x), np.sign(x) * (y - bias)) if folded else (x, y)


def draw_panel(
    axes: Axes,
    view: JointView,
    observer: str,
    levels: _Levels,
    span: tuple[float, float],
    folded: bool,
) -> None:
    """
    Draw one panel: samples, levels and laws.

    :param span: slowest and fastest speed.
    :param folded: both directions over one another, against the logarithm of speed.
    """
    style, fit, tau_f = view.style(observer), view.fits[observer].fit, view.estimates[observer]
    law = fitted_law(fit)
    bias = _bias(law)
    slowest, fastest = span
    standstill = max(view.zero_band, slowest) if folded else view.zero_band
    axes.axvspan(slowest if folded else -standstill, standstill, color=_ZERO_BAND, zorder=0.4,
                 linewidth=0)  # fmt: skip
    for way, marker in ((1.0, '^'), (-1.0, 'v')) if folded else ((0.0, style.marker),):
        if folded:
            inside = way * np.nan_to_num(view.speed) >= slowest
        else:
            inside = np.abs(np.nan_to_num(view.speed, nan=np.inf)) <= fastest
        kept = np.flatnonzero(np.isfinite(tau_f) & inside)
        kept = kept[:: max(1, len(kept) // drawing.points(_SCATTER_POINTS))]
        axes.plot(*_fold(view.speed[kept], tau_f[kept], bias, folded), linestyle='', marker='.',
                  markersize=3.0, color=style.colour, alpha=0.22, markeredgewidth=0.0,
                  zorder=1.5)  # fmt: skip
        for some, rejected in ((levels.shown, True), (levels.used, False)):
            mine = some & (way * levels.velocity > 0.0) if folded else some
            points = _fold(levels.velocity[mine], levels.level[mine], bias, folded)
            _points(axes, points, levels.spread[mine], marker, style, rejected)
    v = np.geomspace(slowest, fastest, 160)
    # Two branches: a law with sgn(v) has no line across zero. Folded a symmetric law is one line.
    for branch in (v, -v):
        again = folded and branch is not v
        if law is not None and not (again and 'viscous_asymmetry' not in law.parameters):
            x, y = _fold(branch, law.torque(branch), bias, folded)
            _law(axes, x, y, band(fit, branch), np.abs(branch) >= fit.slowest, style)
        if view.truth is not None and not again:
            truth = view.truth.make_law()
            axes.plot(*_fold(branch, truth.torque(branch), _bias(truth), folded), color='black',
                      linestyle='--', linewidth=1.1, zorder=2.7)  # fmt: skip
    if folded:
        drawing.log_axis(axes)
        axes.set_xlim(span)
    else:
        axes.axhline(0.0, color=drawing.GREY, linewidth=0.6)
        axes.axvline(0.0, color=drawing.GREY, linewidth=0.6)
        axes.set_xlim(-fastest, fastest)


def _law(
    axes: Axes,
    x: FloatArray,
    y: FloatArray,
    half: FloatArray | None,
    measured: BoolArray,
    style: Style,
) -> None:
    """Draw a law with its band, dotted where it is extrapolated."""
    line: dict[str, Any] = {'color': style.colour, 'linewidth': 1.8, 'zorder': 2.5}
    seen = measured if measured.any() else np.ones(len(x), dtype=bool)
    if half is not None:
        axes.fill_between(x, y - half, y + half, color=style.colour, alpha=0.25, linewidth=0,
                          zorder=2.0)  # fmt: skip
    axes.plot(x, np.where(seen, y, np.nan), **line)
    if not seen.all():
        axes.plot(x, np.where(seen, np.nan, y), linestyle=':', **line)


def _points(
    axes: Axes,
    points: tuple[FloatArray, FloatArray],
    spread: FloatArray,
    marker: str,
    style: Style,
    rejected: bool,
) -> None:
    """Draw levels with their spread; pale and hollow where they are not used."""
    axes.errorbar(
        *points, np.nan_to_num(spread), fmt=marker, markersize=6,
        color=_PALE if rejected else style.colour,
        markerfacecolor='white' if rejected else style.colour,
        markeredgecolor=_PALE if rejected else drawing.marker_edge(style._replace(marker=marker)),
        markeredgewidth=1.0 if rejected else 0.7,
        elinewidth=0.9, capsize=0, zorder=3.2 if rejected else 4,
    )  # fmt: skip


def _bias(law: FrictionLaw | None) -> float:
    return 0.0 if law is None else law.parameters.get('bias', 0.0)


def panel_height(
    view: JointView, levels: Mapping[str, _Levels], limit: float, slowest: float, folded: bool
) -> tuple[float, float]:
    """Choose the height by what samples, levels and laws reach, spikes left out."""
    values = [np.zeros(0 if folded else 1)]
    beyond = []
    inside = np.abs(np.nan_to_num(view.speed, nan=np.inf)) <= limit
    v = np.geomspace(slowest, limit, 60)

    def curve(law: FrictionLaw, bias: float, floor: float) -> FloatArray:
        x = np.concatenate([v[v >= floor], -v[v >= floor]])
        return _fold(x, law.torque(x), bias, folded)[1]

    for observer, some in levels.items():
        tau_f, fit = view.estimates[observer], view.fits[observer].fit
        law, known = fitted_law(fit), inside & np.isfinite(tau_f)
        bias = _bias(law)
        # Below the data only transients of reversals are left, which would flatten the knee.
        used = np.abs(some.velocity[some.used])
        slow = float(used.min()) if len(used) else fit.slowest
        floor = max(0.5 * slow, view.zero_band) if np.isfinite(slow) else view.zero_band
        if folded:
            known &= np.abs(np.nan_to_num(view.speed)) > floor
        if known.any():
            share = 0.05 if folded else 0.005
            samples = _fold(view.speed[known], tau_f[known], bias, folded)[1]
            values.append(np.quantile(samples, (share, 1.0 - share)))
        level = _fold(some.velocity, some.level, bias, folded)[1]
        spread = np.where(some.used, np.nan_to_num(some.spread), 0.0)
        values += [(level + reach)[some.used | some.shown] for reach in (-spread, spread)]
        if law is not None:
            values.append(curve(law, bias, floor))
            if law.smoothing_velocity == 0.0:
                beyond.append(curve(law, bias, 0.0))
        if view.truth is not None:
            truth = view.truth.make_law()
            values.append(curve(truth, _bias(truth), floor))
    everything = np.concatenate(values)
    everything = everything[np.isfinite(everything)]
    if not len(everything):
        return -1.0, 1.0
    low, high = float(everything.min()), float(everything.max())
    span = high - low or 1.0
    # What is extrapolated may run out of the panel.
    lowest = min([low, *(max(float(x.min()), low - _BEYOND * span) for x in beyond)])
    highest = max([high, *(min(float(x.max()), high + _BEYOND * span) for x in beyond)])
    return lowest - 0.07 * span, highest + 0.07 * span


def panel_legend(view: JointView, style: Style | None = None) -> Sequence[Any]:
    """
    Return the legend of panels.

    :param style: of the one observer that is drawn; None for several, and with panels that have
        the directions over one another.
    """
    colour = drawing.GREY if style is None else style.colour
    dot: dict[str, Any] = {'color': colour, 'linestyle': ''}
    hollow: dict[str, Any] = {'color': _PALE, 'linestyle': '', 'markerfacecolor': 'white'}
    used = 'window used: level, ± std within it'
    mark = 'o' if style is None else style.marker
    handles: list[Any] = [
        drawing.key(marker='.', markersize=5, alpha=0.5, label='samples', **dot),
        drawing.key(marker=mark, markeredgecolor='white', label=used, **dot),
    ]
    if style is None:
        handles += [
            drawing.key(marker='^', label='v > 0', **dot),
            drawing.key(marker='v', label='v < 0', **dot),
        ]
    count = sum(bool(segment.rejected) for segment in view.segments)
    if count:
        longest = f' (longest {_REJECTED_SHOWN} of {count})' if count > _REJECTED_SHOWN else ''
        handles.append(drawing.key(marker=mark, label=f'window not used{longest}', **hollow))
    line: dict[str, Any] = {'color': colour, 'linewidth': 1.8}
    handles.append(drawing.key(label='fitted law', **line))
    handles.append(drawing.key(linestyle=':', label='slower than the data', **line))
    if has_band(view):
        handles.append(Patch(color=colour, alpha=0.3, linewidth=0, label='95 % band'))
    handles.append(Patch(color=_ZERO_BAND, linewidth=0, label='standstill, excluded'))
    if view.truth is not None:
        handles.append(drawing.key(color='black', linestyle='--', linewidth=1.1, label='truth'))
    return handles
