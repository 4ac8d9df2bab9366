# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One law over several recordings: friction against velocity, and what the law leaves."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.patches import Patch

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.law_curve import band, fitted_law
from sosml_friction.identification.several.bag_points import (
    BagPoints,
    bag_points,
    consolidated_law,
    own_bias,
)
from sosml_friction.identification.several.consolidation import JOINT
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import motion_units
from sosml_friction.report.fit.consolidation_view import BagsJoint, bag_name

_LAW: dict[str, Any] = {'color': 'black', 'linewidth': 1.6}
_JOINT: dict[str, Any] = {'color': 'black', 'linestyle': ':', 'linewidth': 1.6}
_TRUTH: dict[str, Any] = {'color': '#D55E00', 'linestyle': '--', 'linewidth': 1.4}
_BAND: dict[str, Any] = {'color': 'black', 'alpha': 0.2, 'linewidth': 0}


class BagsLaw(Figure[BagsJoint]):
    """
    Draw friction of every recording against velocity and speed, the law, and what it leaves.

    The lower left panel is sgn(v) (tau_f - bias), both directions over one another; a recording
    that has a bias of its own in the joint fit is drawn less that.
    """

    identifier = 'law'
    title = 'Friction against velocity'
    report = 'bags'
    order = 10
    caption = (
        'Joint {view.entry.joint}, {view.observer}: what each '
        'recording says of friction (levels of windows, or means in bins of speed with their '
        'standard deviation) and the law of the model; right against the logarithm of speed, '
        'both directions over one another; below, what the law leaves.'
    )

    def applies(self, view: BagsJoint) -> bool:
        return consolidated_law(view.entry) is not None and bool(_points_of(view))

    def draw(self, view: BagsJoint) -> Drawing:
        entry, law, points = view.entry, consolidated_law(view.entry), _points_of(view)
        assert law is not None
        figure = drawing.new_figure(10.0, 7.6)
        panels = np.asarray(figure.subplots(2, 2))
        whole, knee, residual, residual_log = panels.ravel()
        top = 1.08 * max(float(np.abs(p.velocity).max()) for p in points.values())
        slowest = min(float(np.abs(p.velocity).min()) for p in points.values())
        common = law.parameters.get('bias', 0.0)
        handles: list[Any] = []
        for k, bag in enumerate(view.consolidation.bags):
            if bag not in points:
                continue
            colour, marker, _, _ = drawing.bag_style(k)
            v, y, spread = points[bag]
            own = own_bias(entry, bag, common)
            left = y - law.torque(v) + common - own
            _points(whole, v, y - own + common, spread, colour, marker)
            _points(residual, v, left, spread, colour, marker)
            for way, arrow in ((1.0, '^'), (-1.0, 'v')):
                mine = way * v > 0.0
                x, error = way * v[mine], spread[mine]
                _points(knee, x, way * (y[mine] - own), error, colour, arrow)
                _points(residual_log, x, way * left[mine], error, colour, arrow)
            label = bag_name(view.consolidation, bag)
            handles.append(drawing.key(linestyle='', marker=marker, color=colour, label=label))
        v = np.geomspace(0.3 * slowest, top, 300)
        half = other = None
        if entry.joint_fit is not None and entry.preferred == JOINT:
            half = band(entry.joint_fit, v)
        elif entry.joint_fit is not None:
            other = fitted_law(entry.joint_fit)
        truth = None if view.truth is None else view.truth.make_law()
        for axes, x, bias_drawn in ((whole, v, True), (whole, -v, True), (knee, v, False)):
            for one, look, order in ((law, _LAW, 2.0), (other, _JOINT, 2.1), (truth, _TRUTH, 3.5)):
                if one is None:
                    continue
                y = one.torque(x) - (0.0 if bias_drawn else one.parameters.get('bias', 0.0))
                axes.plot(x, y, zorder=order, **look)
                if one is law and half is not None:
                    axes.fill_between(x, y - half, y + half, zorder=1.8, **_BAND)
        _, speed = motion_units(entry.unit)
        for axes, x_label, y_label in (
            (whole, 'velocity', f'friction τ_f [{entry.unit}]'),
            (knee, 'speed', f'sgn(v) (τ_f − bias) [{entry.unit}]'),
            (residual, 'velocity', f'friction − law [{entry.unit}]'),
            (residual_log, 'speed', f'sgn(v) (friction − law) [{entry.unit}]'),
        ):
            drawing.label_axes(axes, f'{x_label} [{speed}]', y_label)
            if axes in (knee, residual_log):
                drawing.log_axis(axes)
                axes.set_xlim(0.5 * slowest, top)
            else:
                axes.axvline(0.0, color=drawing.GREY, linewidth=0.6)
                axes.set_xlim(-top, top)
            if axes is not knee:
                axes.axhline(0.0, color=drawing.GREY, linewidth=0.8)
        for column in panels.T:
            figure.align_ylabels(column)
        handles += [
            drawing.key(linestyle='', marker='^', color=drawing.GREY, label='v > 0'),
            drawing.key(linestyle='', marker='v', color=drawing.GREY, label='v < 0'),
            drawing.key(label='law of the model', **_LAW),
        ]
        if half is not None:
            handles.append(Patch(label='95 % band', **_BAND))
        if other is not None:
            handles.append(drawing.key(label='joint fit', **_JOINT))
        if truth is not None:
            handles.append(drawing.key(label='truth', **_TRUTH))
        drawing.legend_below(figure, handles)
        return figure


def _points_of(view: BagsJoint) -> dict[str, BagPoints]:
    entry = view.entry
    return {
        bag: points
        for bag in view.consolidation.bags
        if bag in view.fits
        and (points := bag_points(view.fits[bag], entry.joint, entry.observer)) is not None
    }


def _points(
    axes: Axes, x: FloatArray, y: FloatArray, spread: FloatArray, colour: str, marker: str
) -> None:
    axes.errorbar(
        x, y, np.where(spread > 0.0, spread, np.nan), fmt=marker, markersize=5, color=colour,
        markeredgecolor='white', markeredgewidth=0.5, elinewidth=0.8, capsize=0, zorder=3,
    )  # fmt: skip
