# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One law over several recordings: friction against velocity, and what the law leaves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from sosml_friction.identification.friction_fit import FrictionFit
from sosml_friction.identification.several.consolidation import JOINT, Consolidated, Consolidation
from sosml_friction.model.laws import FRICTION_LAWS, FrictionLaw, make_friction_law
from sosml_friction.model.model_folder import FrictionParameters
from sosml_friction.report.common.drawing import (
    GREY,
    bag_style,
    label_axes,
    legend_below,
    new_figure,
)
from sosml_friction.report.common.labels import motion_units
from sosml_friction.report.common.law_curve import band, fitted_law
from sosml_friction.report.fit.consolidation_view import bag_name

FloatArray = NDArray[np.float64]

#: Bins per direction of what is not windows, equal in the logarithm of speed.
_BINS = 24
#: A bin of fewer rows is not shown.
_FEWEST_IN_BIN = 3
#: Rows that are few enough to be shown one by one.
_MOST_POINTS = 200


class BagPoints(NamedTuple):
    """
    Hold what one recording says of friction: velocity, tau_f and its spread, (K,) each.

    ``spread`` is the standard deviation in the bin, 0 for a row that stands alone.
    """

    velocity: FloatArray
    friction: FloatArray
    spread: FloatArray


def bag_points(fit: FrictionFit, joint: str, observer: str) -> BagPoints | None:
    """Return the rows that a recording was fitted by, many of them as means in bins of speed."""
    rows = fit.rows.get(joint, {}).get(observer)
    if rows is None:
        return None
    keep = rows.keep & np.isfinite(rows.y) & np.isfinite(rows.mean_v) & (rows.mean_v != 0.0)
    v, y = rows.mean_v[keep], rows.y[keep]
    if not len(v):
        return None
    if len(v) <= _MOST_POINTS:
        return BagPoints(v, y, np.zeros(len(v)))
    speed = np.abs(v)
    edges = np.geomspace(float(np.quantile(speed, 0.01)), float(speed.max()), _BINS + 1)
    where = np.digitize(speed, edges[1:-1])
    found = []
    for way in (-1.0, 1.0):
        for k in range(_BINS):
            inside = (where == k) & (np.sign(v) == way)
            if np.sum(inside) >= _FEWEST_IN_BIN:
                found.append((np.mean(v[inside]), np.mean(y[inside]), np.std(y[inside])))
    columns = np.array(found, dtype=float).reshape(-1, 3)
    return BagPoints(columns[:, 0], columns[:, 1], columns[:, 2])


def bags_figure(
    consolidation: Consolidation,
    entry: Consolidated,
    fits: Mapping[str, FrictionFit],
    truth: FrictionParameters | None = None,
) -> Figure | None:
    """
    Draw friction of every recording against velocity and speed, the law, and what it leaves.

    The lower left panel is sgn(v) (tau_f - bias), both directions over one another; a recording
    that has a bias of its own in the joint fit is drawn less that. None where there is no law.

    :param fits: the fits of each recording, by its label.
    """
    law = _law(entry)
    points = {
        bag: known
        for bag in consolidation.bags
        if bag in fits
        and (known := bag_points(fits[bag], entry.joint, entry.observer)) is not None
    }
    if law is None or not points:
        return None
    figure = new_figure(10.0, 7.6)
    panels = np.asarray(figure.subplots(2, 2))
    whole, knee, residual, residual_log = panels.ravel()
    top = 1.08 * max(float(np.abs(p.velocity).max()) for p in points.values())
    slowest = min(float(np.abs(p.velocity).min()) for p in points.values())
    common = law.parameters.get('bias', 0.0)
    handles: list[Any] = []
    for k, bag in enumerate(consolidation.bags):
        if bag not in points:
            continue
        style = bag_style(k)
        v, y, spread = points[bag]
        own = entry.bias[bag].value if entry.own_bias and bag in entry.bias else common
        own = own if math.isfinite(own) else common
        left = y - law.torque(v) + common - own
        _points(whole, v, y - own + common, spread, style.colour, style.marker)
        _points(residual, v, left, spread, style.colour, style.marker)
        for way, marker in ((1.0, '^'), (-1.0, 'v')):
            mine = way * v > 0.0
            _points(knee, way * v[mine], way * (y[mine] - own), spread[mine], style.colour, marker)
            _points(residual_log, way * v[mine], way * left[mine], spread[mine], style.colour,
                    marker)  # fmt: skip
        handles.append(
            Line2D([], [], linestyle='', marker=style.marker, color=style.colour,
                   label=bag_name(consolidation, bag))
        )  # fmt: skip
    curve = np.geomspace(0.3 * slowest, top, 300)
    half = None
    if entry.preferred == JOINT and entry.joint_fit is not None:
        half = band(entry.joint_fit, curve)
    for branch in (curve, -curve):
        _curve(whole, branch, law.torque(branch), half)
        if truth is not None:
            _truth(whole, branch, truth.make_law().torque(branch))
    _curve(knee, curve, law.torque(curve) - common, half)
    other = None
    if entry.preferred != JOINT and entry.joint_fit is not None:
        other = fitted_law(entry.joint_fit)
    if other is not None:
        _joint(whole, curve, other.torque(curve))
        _joint(whole, -curve, other.torque(-curve))
        _joint(knee, curve, other.torque(curve) - other.parameters.get('bias', 0.0))
    if truth is not None:
        bias = truth.parameters.get('bias')
        _truth(knee, curve, truth.make_law().torque(curve) - (bias.value if bias else 0.0))
    _, speed = motion_units(entry.unit)
    labels = (
        (whole, 'velocity', f'friction τ_f [{entry.unit}]'),
        (knee, 'speed', f'sgn(v) (τ_f − bias) [{entry.unit}]'),
        (residual, 'velocity', f'friction − law [{entry.unit}]'),
        (residual_log, 'speed', f'sgn(v) (friction − law) [{entry.unit}]'),
    )
    for axes, x, y_label in labels:
        label_axes(axes, f'{x} [{speed}]', y_label)
        if axes in (knee, residual_log):
            axes.set_xscale('log')
            axes.set_xlim(0.5 * slowest, top)
        else:
            axes.axvline(0.0, color=GREY, linewidth=0.6)
            axes.set_xlim(-top, top)
        if axes is not knee:
            axes.axhline(0.0, color=GREY, linewidth=0.8)
    for column in (panels[:, 0], panels[:, 1]):
        figure.align_ylabels(column)
    legend_below(figure, handles + _legend(half is not None, other is not None, truth is not None))
    return figure


def _law(entry: Consolidated) -> FrictionLaw | None:
    names = FRICTION_LAWS[entry.law].parameter_names
    values = {n: entry.parameters[n].value for n in names if n in entry.parameters}
    if 'bias' in values and not math.isfinite(values['bias']):
        # Where each recording has its own, the law is drawn without any.
        values['bias'] = 0.0
    if len(values) < len(names) or not all(map(math.isfinite, values.values())):
        return None
    width = 0.0 if entry.joint_fit is None else entry.joint_fit.smoothing_velocity
    return make_friction_law(entry.law, values, width)


def _points(
    axes: Axes, x: FloatArray, y: FloatArray, spread: FloatArray, colour: str, marker: str
) -> None:
    axes.errorbar(
        x, y, np.where(spread > 0.0, spread, np.nan), fmt=marker, markersize=5, color=colour,
        markeredgecolor='white', markeredgewidth=0.5, elinewidth=0.8, capsize=0, zorder=3,
    )  # fmt: skip


def _curve(axes: Axes, v: FloatArray, y: FloatArray, half: FloatArray | None) -> None:
    if half is not None:
        axes.fill_between(v, y - half, y + half, color='black', alpha=0.2, linewidth=0, zorder=1.8)
    axes.plot(v, y, color='black', linewidth=1.6, zorder=2.0)


def _joint(axes: Axes, v: FloatArray, y: FloatArray) -> None:
    axes.plot(v, y, color='black', linestyle=':', linewidth=1.6, zorder=2.1)


def _truth(axes: Axes, v: FloatArray, y: FloatArray) -> None:
    axes.plot(v, y, color='#D55E00', linestyle='--', linewidth=1.4, zorder=3.5)


def _legend(with_band: bool, with_joint: bool, with_truth: bool) -> list[Any]:
    handles: list[Any] = [
        Line2D([], [], linestyle='', marker='^', color=GREY, label='v > 0'),
        Line2D([], [], linestyle='', marker='v', color=GREY, label='v < 0'),
        Line2D([], [], color='black', linewidth=1.6, label='law of the model'),
    ]
    if with_band:
        handles.append(Patch(color='black', alpha=0.2, linewidth=0, label='95 % band'))
    if with_joint:
        handles.append(
            Line2D([], [], color='black', linestyle=':', linewidth=1.6, label='joint fit')
        )
    if with_truth:
        handles.append(
            Line2D([], [], color='#D55E00', linestyle='--', linewidth=1.4, label='truth')
        )
    return handles
