# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of a report, one joint each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.identification.segments import Segment, SegmentSettings
from sosml_friction.model.friction_law import FrictionLaw
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.drawing import (
    FONT,
    GREY,
    Style,
    draw_line,
    label_axes,
    legend_below,
    new_figure,
    style_of,
)
from sosml_friction.report.joint_view import JointView, fitted_law
from sosml_friction.report.labels import SYMBOLS, observer_label
from sosml_friction.report.number_text import NOT_IDENTIFIABLE_TEXT, allowed_range

FloatArray = NDArray[np.float64]

_STEADY = '#dfeee6'
_REJECTED = '#efe3e3'
_LAW = 'black'
#: Points of one scatter that a figure shows.
_SCATTER_POINTS = 3000
#: Windows not used that a figure shows: the longest ones.
_REJECTED_SHOWN = 40


def s_curve(view: JointView) -> Figure:
    """
    Draw tau_f against velocity: samples, levels, fitted laws, the truth where it is known.

    Left the whole range, right the neighbourhood of zero velocity.
    """
    figure = new_figure(10.0, 4.6)
    whole, near = figure.subplots(1, 2, width_ratios=(1.7, 1.0))
    top = _top_speed(view)
    for axes, limit in ((whole, 1.08 * top), (near, _near_zero(view, top))):
        for k, (observer, tau_f) in enumerate(view.estimates.items()):
            _scatter(axes, view, tau_f, limit, style_of(observer, k))
        for k, (observer, fit) in enumerate(view.fits.items()):
            style = style_of(observer, k)
            law = fitted_law(fit.fit)
            _draw_law(axes, law, limit, style.colour, style.dashes, style.width)
            _levels(axes, fit, fit.levels, style)
        if view.truth is not None:
            _draw_law(axes, view.truth.make_law(), limit, 'black', '--', 1.4)
        axes.axhline(0.0, color=GREY, linewidth=0.6)
        axes.axvline(0.0, color=GREY, linewidth=0.6)
        axes.set_xlim(-limit, limit)
        label_axes(axes, f'velocity [{view.velocity_unit}]', f'friction τ_f [{view.effort_unit}]')
    _fit_height(whole, view, 1.08 * top)
    _fit_height(near, view, _near_zero(view, top))
    near.set_ylabel('')
    near.locator_params(axis='x', nbins=5)
    whole.set_title('whole range', fontsize=FONT)
    near.set_title('near zero velocity', fontsize=FONT)
    legend_below(figure, _s_curve_legend(view))
    return figure


def time_traces(view: JointView) -> Figure:
    """
    Draw position, velocity, effort and estimated friction over time with the law's prediction.

    Windows of steady motion are shaded; those not used are marked with a letter, which the legend
    explains. Lines of many samples are drawn as their envelope.
    """
    figure = new_figure(10.0, 8.6)
    axes: Sequence[Axes] = figure.subplots(4, 1, sharex=True, height_ratios=(1, 1, 1, 1.7))
    time = view.time
    draw_line(axes[0], time, view.q, color='black', linewidth=1.0)
    if np.isfinite(view.v).any():
        draw_line(axes[1], time, view.v, color='#b8b8b8', linewidth=0.8)
    draw_line(axes[1], time, view.speed, color='black', linewidth=1.0)
    draw_line(axes[2], time, view.tau, color='black', linewidth=0.8)
    handles: list[Any] = []
    known = [tau_f[np.isfinite(tau_f)] for tau_f in view.estimates.values()]
    for k, (observer, tau_f) in enumerate(view.estimates.items()):
        colour = style_of(observer, k).colour
        draw_line(axes[3], time, tau_f, color=colour, linewidth=1.8 if k == 0 else 1.0)
        handles.append(Line2D([], [], color=colour, linewidth=2.0, label=observer_label(observer)))
    if view.preferred is not None:
        # At rest friction is what holds the joint: the law says nothing of it.
        moving = np.abs(np.nan_to_num(view.speed)) > SegmentSettings().zero_band
        predicted = fitted_law(view.fits[view.preferred].fit).torque(view.speed)
        predicted = np.where(moving, predicted, np.nan)
        known.append(predicted[np.isfinite(predicted)])
        draw_line(axes[3], time, predicted, color=_LAW, linewidth=1.0, linestyle='--')
        text = f'law fitted to {observer_label(view.preferred)}'
        handles.append(Line2D([], [], color=_LAW, linewidth=1.0, linestyle='--', label=text))
    if np.isfinite(view.v).any():
        handles.append(Line2D([], [], color='#b8b8b8', linewidth=2.0, label='velocity, reported'))
        handles.append(
            Line2D([], [], color='black', linewidth=1.0, label='velocity, position difference')
        )
    handles += _mark_segments(axes, view)
    _robust_height(axes[3], np.concatenate(known) if known else np.zeros(0))
    names = ('position', 'velocity', 'effort', 'friction τ_f')
    units = (view.position_unit, view.velocity_unit, view.effort_unit, view.effort_unit)
    for axis, name, unit in zip(axes, names, units, strict=True):
        label_axes(axis, '', f'{name} [{unit}]')
        axis.margins(x=0.01)
    for axis, missing in (
        (axes[2], np.isnan(view.tau).all()),
        (axes[3], not sum(map(len, known))),
    ):
        if missing:
            axis.set_yticks([])
            axis.text(0.5, 0.5, 'unknown', transform=axis.transAxes, ha='center', va='center',
                      fontsize=FONT, color=GREY)  # fmt: skip
    if any(map(len, known)):
        axes[3].axhline(0.0, color=GREY, linewidth=0.6)
    axes[3].set_xlabel('time [s]', fontsize=FONT)
    figure.align_ylabels(axes)
    legend_below(figure, handles)
    return figure


def parameter_bars(view: JointView) -> Figure:
    """
    Draw each parameter per observer and method with its 95 % interval, and the truth if known.

    Filled: the fit in use; hollow: the other method. What is not identifiable is the bare range
    that the data allow, or the words.
    """
    figure = new_figure(10.0, 3.6)
    panels: Sequence[Axes] = figure.subplots(1, len(SYMBOLS))
    entries = [
        (observer, k, fit, fits is view.fits)
        for k, observer in enumerate(view.fits)
        for fits in (view.fits, view.alternatives)
        if (fit := fits.get(observer)) is not None
    ]
    for axes, (name, symbol) in zip(panels, SYMBOLS.items(), strict=True):
        known = None if view.truth is None else view.truth.parameters.get(name)
        numbers = [] if known is None else [known.value]
        ranges: list[float] = []
        for place, (observer, k, fit, in_use) in enumerate(entries):
            parameter = fit.fit.parameters[name]
            axes.set_title(f'{symbol} [{parameter.unit}]', fontsize=FONT)
            if not _draw_parameter(axes, place, name, parameter, style_of(observer, k), in_use):
                # In the panel's own height: the data say nothing of where it would be.
                axes.text(
                    place, 0.5, NOT_IDENTIFIABLE_TEXT, transform=axes.get_xaxis_transform(),
                    rotation=90, color=GREY, fontsize=FONT, ha='center', va='center',
                )  # fmt: skip
            elif NOT_IDENTIFIABLE in parameter.flags:
                ranges += allowed_range(name, parameter) or ()
            else:
                numbers += [x for x in (parameter.value, *(parameter.interval or ()))
                            if np.isfinite(x)]  # fmt: skip
        if known is not None:
            axes.axhline(known.value, color='black', linestyle='--', linewidth=1.2)
        axes.set_xlim(-0.6, len(entries) - 0.4)
        label_axes(axes, '', '')
        axes.set_xticks([])
        if numbers or ranges:
            _bar_height(axes, numbers, ranges)
        else:
            axes.set_yticks([])
    handles: list[Any] = [
        Line2D([], [], linestyle='', label=f'{observer_label(observer)}, {fit.method}',
               **_marker(style_of(observer, k), in_use))
        for observer, k, fit, in_use in entries
    ]  # fmt: skip
    handles.append(Line2D([], [], color=GREY, linewidth=1.4, label='95 % interval'))
    handles.append(
        Line2D([], [], color=GREY, linewidth=6, alpha=0.45, label='not identifiable: range')
    )
    if view.truth is not None:
        handles.append(Line2D([], [], color='black', linestyle='--', label='truth'))
    legend_below(figure, handles)
    return figure


def residuals(view: JointView) -> Figure:
    """Draw what the fitted laws leave of the levels, against velocity."""
    figure = new_figure(10.0, 3.2)
    axes: Axes = figure.subplots()
    handles: list[Any] = []
    for k, (observer, fit) in enumerate(view.fits.items()):
        style = style_of(observer, k)
        velocity = np.array([segment.velocity for segment in fit.segments])
        residual = fit.levels - fitted_law(fit.fit).torque(velocity)
        _levels(axes, fit, residual, style)
        for side in (-1.0, 1.0):
            axes.axhline(
                side * fit.fit.residual_std, color=style.colour, linestyle=':', linewidth=1.2
            )
        handles.append(
            Line2D([], [], color=style.colour, marker=style.marker, markersize=style.marker_size,
                   linestyle=':', markeredgecolor='white',
                   label=f'{observer_label(observer)}, ± residual std of its fit')
        )  # fmt: skip
    handles += _hollow_legend(view)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    label_axes(axes, f'velocity [{view.velocity_unit}]', f'level − law [{view.effort_unit}]')
    legend_below(figure, handles)
    return figure


def _shown(segments: Sequence[Segment]) -> NDArray[np.bool_]:
    """Tell which of the rejected windows a figure shows: the longest."""
    length = np.array([s.end_s - s.start_s if s.rejected else -1.0 for s in segments])
    shown = np.zeros(len(segments), dtype=bool)
    shown[np.argsort(-length, kind='stable')[:_REJECTED_SHOWN]] = True
    return shown & (length >= 0.0)


def _hollow_legend(view: JointView) -> list[Any]:
    count = sum(bool(segment.rejected) for segment in view.segments)
    if not count:
        return []
    label = 'window not used'
    if count > _REJECTED_SHOWN:
        label += f' (longest {_REJECTED_SHOWN} of {count})'
    return [
        Line2D([], [], linestyle='', marker='o', markerfacecolor='none', color=GREY, label=label)
    ]


def _s_curve_legend(view: JointView) -> list[Any]:
    handles: list[Any] = []
    for k, observer in enumerate(view.estimates):
        style = style_of(observer, k)
        name = observer_label(observer)
        handles.append(Line2D([], [], linestyle='', marker='.', color=style.colour, alpha=0.5,
                              label=f'{name} samples'))  # fmt: skip
        if observer in view.fits:
            handles.append(Line2D([], [], color=style.colour, marker=style.marker,
                                  markersize=style.marker_size, linestyle=style.dashes,
                                  linewidth=style.width, markeredgecolor='white',
                                  label=f'{name} levels and law'))  # fmt: skip
    handles += _hollow_legend(view)
    if view.truth is not None:
        handles.append(Line2D([], [], color='black', linestyle='--', label='truth'))
    return handles


def _top_speed(view: JointView) -> float:
    speeds = np.abs(view.speed[np.isfinite(view.speed)])
    top = float(speeds.max()) if len(speeds) else 0.0
    return top if top > 0.0 else 1.0


def _near_zero(view: JointView, top: float) -> float:
    """Return up to what speed the panel near zero goes: three plateaus, where they are slow."""
    used = sorted(abs(s.velocity) for s in view.segments if not s.rejected)
    slow = used[0] if used else top
    return float(min(max(3.0 * slow, 0.05 * top), 0.3 * top))


def _scatter(axes: Axes, view: JointView, tau_f: FloatArray, limit: float, style: Style) -> None:
    inside = np.flatnonzero(
        np.isfinite(tau_f) & (np.abs(np.nan_to_num(view.speed, nan=np.inf)) <= limit)
    )
    kept = inside[:: max(1, len(inside) // _SCATTER_POINTS)]
    axes.plot(
        view.speed[kept], tau_f[kept], linestyle='', marker='.', markersize=3.5,
        color=style.colour, alpha=0.3, markeredgewidth=0.0, zorder=1.5,
    )  # fmt: skip


def _levels(axes: Axes, fit: JointFit, values: FloatArray, style: Style) -> None:
    velocity = np.array([segment.velocity for segment in fit.segments])
    used = np.array([not segment.rejected for segment in fit.segments], dtype=bool)
    hollow = _shown(fit.segments)
    axes.plot(
        velocity[hollow], values[hollow], linestyle='', marker=style.marker, markersize=5,
        markerfacecolor='none', markeredgecolor=GREY, markeredgewidth=1.1, zorder=3.5,
    )  # fmt: skip
    axes.plot(
        velocity[used], values[used], linestyle='', marker=style.marker,
        markersize=style.marker_size, color=style.colour, markeredgecolor='white',
        markeredgewidth=0.8, zorder=4,
    )  # fmt: skip


def _draw_law(
    axes: Axes, law: FrictionLaw, limit: float, colour: str, dashes: str, width: float
) -> None:
    v = np.geomspace(1e-4 * limit, limit, 400)
    # Two branches: a law with sgn(v) has no line across zero.
    for branch in (v, -v):
        axes.plot(branch, law.torque(branch), color=colour, linestyle=dashes, linewidth=width,
                  zorder=2.5)  # fmt: skip


def _fit_height(axes: Axes, view: JointView, limit: float) -> None:
    """Choose the height by what the samples, levels and laws reach, spikes left out."""
    values = [np.zeros(1)]
    inside = np.abs(np.nan_to_num(view.speed, nan=np.inf)) <= limit
    for tau_f in view.estimates.values():
        known = tau_f[inside & np.isfinite(tau_f)]
        if len(known):
            values.append(np.quantile(known, (0.003, 0.997)))
    v = np.linspace(0.01 * limit, limit, 50)
    laws = [fitted_law(fit.fit) for fit in view.fits.values()]
    if view.truth is not None:
        laws.append(view.truth.make_law())
    for law in laws:
        values += [law.torque(v), law.torque(-v)]
    for fit in view.fits.values():
        close = np.array([abs(segment.velocity) <= limit for segment in fit.segments], dtype=bool)
        levels = fit.levels[close]
        values.append(levels[np.isfinite(levels)])
    everything = np.concatenate(values)
    low, high = float(everything.min()), float(everything.max())
    margin = 0.07 * (high - low) or 1.0
    axes.set_ylim(low - margin, high + margin)


def _robust_height(axes: Axes, values: FloatArray) -> None:
    """Cut the height at a start-up spike that would flatten all the rest."""
    if not len(values):
        return
    low, high = (float(x) for x in np.quantile(values, (0.001, 0.999)))
    reach = max(high - low, 1e-12)
    low, high = max(low - reach, float(values.min())), min(high + reach, float(values.max()))
    axes.set_ylim(low - 0.06 * reach, high + 0.06 * reach)


def _mark_segments(axes: Sequence[Axes], view: JointView) -> list[Any]:
    """Shade the windows and return the legend entries that explain them."""
    used = [segment for segment in view.segments if not segment.rejected]
    rejected = [segment for segment in view.segments if segment.rejected]
    handles: list[Any] = []
    groups = _rejected_groups(view.segments)
    for axis in axes:
        for segments, colour in ((used, _STEADY), (rejected, _REJECTED)):
            axis.broken_barh(
                [(s.start_s, s.end_s - s.start_s) for s in segments],
                (0.0, 1.0),
                transform=axis.get_xaxis_transform(),
                facecolors=colour,
                edgecolors='none',
                zorder=0.5,
            )
    if used:
        handles.append(Patch(facecolor=_STEADY, label=f'steady window used ({len(used)})'))
    for letter, (reason, segments) in zip(
        'abcdefghijklmnopqrstuvwxyz', groups.items(), strict=False
    ):
        # Where windows crowd, one letter stands for its neighbours.
        last = -np.inf
        for segment in segments:
            if segment.start_s - last < 0.014 * (view.time[-1] - view.time[0]):
                continue
            last = segment.start_s
            axes[0].text(
                0.5 * (segment.start_s + segment.end_s), 1.01, letter,
                transform=axes[0].get_xaxis_transform(), ha='center', va='bottom', fontsize=FONT,
                color='#8a3b3b',
            )  # fmt: skip
        label = f'{letter}: not used, {reason} ({len(segments)})'
        handles.append(Patch(facecolor=_REJECTED, label=label))
    return handles


def _rejected_groups(segments: Sequence[Segment]) -> dict[str, list[Segment]]:
    """Return the rejected windows by reason, reasons that differ in numbers only as one."""
    groups: dict[str, list[Segment]] = {}
    for segment in segments:
        if segment.rejected:
            groups.setdefault(re.sub(r'\d+(\.\d+)?', '#', segment.rejected), []).append(segment)
    named = {}
    for pattern, members in groups.items():
        numbers = [re.findall(r'\d+(?:\.\d+)?', member.rejected) for member in members]
        reason = pattern
        for column in zip(*numbers, strict=True):
            low, high = min(column, key=float), max(column, key=float)
            reason = reason.replace('#', low if low == high else f'{low} to {high}', 1)
        named[reason] = members
    return named


def _draw_parameter(
    axes: Axes, place: int, name: str, parameter: Parameter, style: Style, in_use: bool
) -> bool:
    """Draw one parameter and return True, or False where there is nothing to draw."""
    if NOT_IDENTIFIABLE in parameter.flags:
        allowed = allowed_range(name, parameter)
        if allowed is None:
            return False
        axes.plot([place, place], allowed, color=style.colour, linewidth=6, alpha=0.3,
                  solid_capstyle='butt')  # fmt: skip
        return True
    if not np.isfinite(parameter.value):
        return False
    if parameter.interval is not None and np.isfinite(parameter.interval).all():
        axes.plot([place, place], parameter.interval, color=style.colour, linewidth=1.6)
        for end in parameter.interval:
            axes.plot([place - 0.16, place + 0.16], [end, end], color=style.colour, linewidth=1.6)
    axes.plot([place], [parameter.value], **_marker(style, in_use))
    if AT_BOUND in parameter.flags:
        axes.annotate('at bound', (place, parameter.value), xytext=(0, 8), rotation=90,
                      textcoords='offset points', fontsize=FONT, color=GREY, ha='center',
                      va='bottom')  # fmt: skip
    return True


def _bar_height(axes: Axes, numbers: Sequence[float], ranges: Sequence[float]) -> None:
    """Let ranges that the data hardly bound run out of the panel rather than flatten the rest."""
    low, high = min([*numbers, *ranges]), max([*numbers, *ranges])
    if numbers:
        reach = max(numbers) - min(numbers) or abs(max(numbers)) or 1.0
        low = max(low, min(numbers) - 2.0 * reach)
        high = min(high, max(numbers) + 2.0 * reach)
    margin = 0.12 * (high - low) or 0.1 * abs(high) or 1.0
    axes.set_ylim(low - margin, high + margin)


def _marker(style: Style, in_use: bool) -> dict[str, Any]:
    return {
        'marker': style.marker,
        'markersize': 8,
        'color': style.colour,
        'markerfacecolor': style.colour if in_use else 'white',
        'markeredgewidth': 1.4,
    }
