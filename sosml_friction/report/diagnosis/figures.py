# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of a diagnosis: what is unexplained before and after, and what was considered."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numba import njit

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.regression.signals import Signals
from sosml_friction.report.common.drawing import (
    AFTER,
    BEFORE,
    FONT,
    GREY,
    FloatArray,
    draw_line,
    fix_axes,
    label_axes,
    legend_below,
    log_axis,
    new_figure,
)

_BINS = 24
#: A bin is at least so much of the range: narrower ones draw a plateau's noise as a vertical line.
_NARROWEST = 0.02
#: Bars of the ranking.
_BARS = 12


def rows_of(diagnosis: Diagnosis) -> dict[str, FloatArray]:
    """
    Return what the rows of the residuals are drawn against, time (rows,), the others (rows, n).

    q, v, a, load and effort; since: the way since the last reversal [rad or m].
    """
    laboratory = diagnosis.laboratory
    assert laboratory is not None
    parts: dict[str, list[FloatArray]] = {k: [] for k in ('time', 'q', 'v', 'a', 'load', 'since')}
    y, _ = laboratory.unwhitened()
    for signals, part in zip(laboratory.signals, laboratory.split(y), strict=True):
        rows = slice(signals.band.first, None, signals.band.factor)
        for name, x in (
            ('time', signals.time),
            ('q', signals.q),
            ('v', signals.v),
            ('a', signals.a),
            ('load', signals.rigid),
            ('since', _since_reversal(signals)),
        ):
            kept = x[rows][: signals.band.count(len(x))]
            parts[name].append(kept[-len(part) :])
    joined = {name: np.concatenate(x) for name, x in parts.items()}
    return {**joined, 'tau': laboratory.measured()}


def _since_reversal(signals: Signals) -> FloatArray:
    """Return how far each joint has gone since it turned around last, (N, n), at least a sign."""
    return np.column_stack(
        [
            way_since_reversal(
                np.ascontiguousarray(signals.q[:, i]), float(signals.scales.displacement[i])
            )
            for i in range(signals.robot.n)
        ]
    )


@njit(cache=True)
def way_since_reversal(q: FloatArray, least: float) -> FloatArray:
    """
    Return |q - q_r|, (N,), q_r the extreme of position where it turned around last.

    A way back of less than ``least`` [rad or m] is no reversal, but noise.
    """
    result = np.empty(len(q))
    turn, extreme, way = q[0], q[0], 0
    for k in range(len(q)):
        if way == 0:
            # Not yet under way.
            if abs(q[k] - turn) >= least:
                way = 1 if q[k] > turn else -1
                extreme = q[k]
        elif way * (q[k] - extreme) >= 0.0:
            extreme = q[k]
        elif way * (extreme - q[k]) >= least:
            turn, extreme, way = extreme, q[k], -way
        result[k] = abs(q[k] - turn)
    return result


def residual_over_time(diagnosis: Diagnosis, i: int, before: FloatArray, after: FloatArray,
                       rows: dict[str, FloatArray]) -> Figure:  # fmt: skip
    """Return measured effort, and below what the refitted and the extended model leave of it."""
    figure = new_figure(10.0, 4.6)
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.2])
    unit = diagnosis.units[i]
    draw_line(top, rows['time'], rows['tau'][:, i], color=GREY, linewidth=1.0)
    draw_line(bottom, rows['time'], before[:, i], color=BEFORE, linewidth=0.9)
    draw_line(bottom, rows['time'], after[:, i], color=AFTER, linewidth=0.9)
    label_axes(top, '', f'measured effort [{unit}]')
    label_axes(bottom, 'time [s]', f'unexplained [{unit}]')
    legend_below(
        figure,
        [
            Line2D([], [], color=BEFORE, label='refitted model'),
            Line2D([], [], color=AFTER, label='with what was named'),
        ],
    )
    return figure


def binned_residual(diagnosis: Diagnosis, i: int, before: FloatArray, after: FloatArray,
                    rows: dict[str, FloatArray]) -> Figure:  # fmt: skip
    """
    Return the mean unexplained effort along six axes, by direction.

    Velocity, position, load, acceleration, way since the last reversal, time.
    """
    figure = new_figure(10.0, 6.4)
    axes = figure.subplots(2, 3, sharey=True).ravel()
    unit = diagnosis.units[i]
    length = 'rad' if unit == 'Nm' else 'm'
    forwards = rows['v'][:, i] > 0.0
    for ax, (name, label) in zip(
        axes,
        (
            ('v', f'velocity [{length}/s]'),
            ('q', f'position [{length}]'),
            ('load', f'load [{unit}]'),
            ('a', f'acceleration [{length}/s²]'),
            ('since', f'way since reversal [{length}]'),
            ('time', 'time [s]'),
        ),
        strict=True,
    ):
        x = rows[name] if name == 'time' else rows[name][:, i]
        if np.ptp(x) <= 1e-9 * max(float(np.abs(x).max()), 1e-300):
            ax.text(0.5, 0.5, 'constant', transform=ax.transAxes, ha='center', fontsize=FONT)
            label_axes(ax, label, '')
            continue
        edges = _bin_edges(x)
        if name == 'since':
            # Over decades: what matters happens in the first thousandths.
            x = np.maximum(x, 1e-4 * float(x.max()))
            edges = np.geomspace(float(x.min()), float(x.max()), _BINS + 1)
            log_axis(ax)
        place = np.clip(np.searchsorted(edges, x, side='right') - 1, 0, len(edges) - 2)
        for way, dashes in ((forwards, '-'), (~forwards, '--')):
            for values, colour in ((before, BEFORE), (after, AFTER)):
                middle, mean = [], []
                for k in range(len(edges) - 1):
                    inside = way & (place == k)
                    if inside.sum() >= 5:
                        middle.append(float(x[inside].mean()))
                        mean.append(float(values[inside, i].mean()))
                ax.plot(middle, mean, color=colour, linestyle=dashes, linewidth=1.4)
        label_axes(ax, label, f'mean unexplained effort [{unit}]' if name in 'va' else '')
    handles = [
        Line2D([], [], color=BEFORE, label='refitted model, forwards'),
        Line2D([], [], color=BEFORE, linestyle='--', label='backwards'),
        Line2D([], [], color=AFTER, label='with what was named, forwards'),
        Line2D([], [], color=AFTER, linestyle='--', label='backwards'),
    ]
    fix_axes(figure, (0.85, 0.15, 0.95, 0.12), (0.2, 0.6), handles)
    return figure


def _bin_edges(x: FloatArray) -> FloatArray:
    """Return quantiles of x, at least a fiftieth of its range apart."""
    least = _NARROWEST * float(np.ptp(x))
    kept = [float(x.min())]
    for edge in np.quantile(x, np.linspace(0.0, 1.0, _BINS + 1)[1:]):
        if edge - kept[-1] >= least:
            kept.append(float(edge))
    # What was left out at the upper end belongs to the last bin.
    kept[-1] = float(x.max())
    return np.array(kept)


def ranking_bars(diagnosis: Diagnosis) -> Figure:
    """Return the held-out gain of the first round's best candidates, with standard errors."""
    entries = list(diagnosis.ranking[:_BARS])[::-1]
    figure = new_figure(10.0, 0.6 + 0.32 * len(entries))
    ax = figure.subplots()
    named = {cause.key for cause in diagnosis.terms}
    place = np.arange(len(entries))
    ax.barh(
        place,
        [100.0 * max(entry['cv_gain'], 0.0) for entry in entries],
        xerr=[100.0 * entry['cv_gain_se'] for entry in entries],
        color=[
            AFTER
            if (entry['effect'], entry['joint']) in named
            else ('#d9d9d9' if entry['objection'] else '#9ecae1')
            for entry in entries
        ],
        ecolor=GREY,
    )
    labels = [
        f'{entry["effect"].replace("_", " ")}, {entry["joint"]}'
        + (' (impossible)' if entry['objection'] else '')
        for entry in entries
    ]
    ax.set_yticks(place, labels, fontsize=FONT)
    floor = [cause.evidence.get('floor') for cause in diagnosis.terms]
    known = [f for f in floor if f is not None]
    if known:
        ax.axvline(100.0 * known[0], color='black', linestyle=':', linewidth=1.2)
    label_axes(ax, 'removed of what is unexplained, on data left out [%]', '')
    return figure
