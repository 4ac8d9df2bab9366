# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How well the data tell the Stribeck term: its profile likelihood."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from sosml_friction.identification.law.law_profile import LawProfile
from sosml_friction.report.common.drawing import (
    GREY,
    label_axes,
    legend_below,
    new_figure,
    style_of,
)
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.fit.joint_view import JointView

FloatArray = NDArray[np.float64]

#: The height of the panels, in units of the 95 % limit.
_HEIGHT = 3.0
#: S of laws that fit so many heights worse is not shown.
_FAR = 10.0
#: How far above the usual S the panel of S goes.
_DECADES = 100.0


def with_best(
    profile: LawProfile, drawn: Mapping[str, float]
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return v_s, excess, S and half range of a profile with the best fit among its points."""
    columns = [profile.stribeck_velocity, profile.excess, profile.stribeck, profile.half]
    v_s, size = drawn.get('stribeck_velocity', np.nan), drawn.get('stribeck', np.nan)
    there = np.isclose(columns[0], v_s, rtol=1e-9, atol=0.0).any()
    if np.isfinite(v_s) and np.isfinite(size) and not there:
        place = int(np.searchsorted(columns[0], v_s))
        near = float(profile.half[min(place, len(profile.half) - 1)])
        best = (v_s, 0.0, size, near)
        columns = [np.insert(c, place, x) for c, x in zip(columns, best, strict=True)]
    v, excess, s, half = columns
    return v, excess, s, half


def profile_figure(view: JointView) -> Figure | None:
    """
    Draw the cost over v_s, and the S that goes with each v_s, of each observer that has a profile.

    The cost is above its least, in units of the 95 % limit: below 1 a value is in the interval.
    None where no fit has a profile.
    """
    profiles = {
        observer: profile
        for observer, fit in view.fits.items()
        if (profile := fit.fit.profile) is not None
    }
    if not profiles:
        return None
    figure = new_figure(10.0, 3.6)
    panels: Sequence[Axes] = figure.subplots(1, 2)
    names = list(view.estimates)
    handles: list[Any] = []
    reach: list[float] = []
    for observer, profile in profiles.items():
        style = style_of(observer, names.index(observer))
        v_s, excess, size, half = with_best(profile, view.fits[observer].fit.drawn)
        within = excess <= 1.0
        size = np.where(excess <= _FAR * _HEIGHT, size, np.nan)
        panels[0].plot(v_s, excess, color=style.colour, linestyle=style.dashes, linewidth=1.8)
        panels[1].plot(v_s, size, color=style.colour, linewidth=1.0, alpha=0.5)
        panels[1].plot(v_s, np.where(within, size, np.nan), color=style.colour, linewidth=3.0)
        half = np.where(within & np.isfinite(half), half, np.nan)
        panels[1].fill_between(v_s, size - half, size + half, color=style.colour, alpha=0.2,
                               linewidth=0)  # fmt: skip
        reach += [*size[within], *(size + half)[np.isfinite(half)]]
        handles.append(
            Line2D([], [], color=style.colour, linewidth=1.8, linestyle=style.dashes,
                   label=observer_label(observer))
        )  # fmt: skip
    for axes in panels:
        axes.set_xscale('log')
    panels[0].axhline(1.0, color=GREY, linestyle=':', linewidth=1.4)
    panels[0].set_ylim(-0.04 * _HEIGHT, _HEIGHT)
    panels[1].set_yscale('log')
    seen = [x for x in reach if 0.0 < x < np.inf]
    if seen:
        # Where v_s is next to nothing S is any number: the panel ends before that.
        low, high = float(np.min(seen)), float(np.max(seen))
        high = min(high, _DECADES * float(np.median(seen)))
        panels[1].set_ylim(0.4 * low, 2.5 * high)
    span = panels[0].get_xlim()
    for axes in panels:
        axes.set_xlim(span)
    handles += [
        Line2D(
            [], [], color=GREY, linestyle=':', linewidth=1.4, label='limit of the 95 % interval'
        ),
        Line2D([], [], color=GREY, linewidth=3.0, label='S at a v_s within the limit'),
    ]
    if view.truth is not None:
        known = view.truth.parameters
        if 'stribeck' in known and 'stribeck_velocity' in known:
            place = (known['stribeck_velocity'].value, known['stribeck'].value)
            panels[0].axvline(place[0], color='black', linestyle='--', linewidth=1.1)
            panels[1].plot(*place, marker='+', markersize=12, color='black', markeredgewidth=1.6)
            handles.append(Line2D([], [], color='black', linestyle='--', label='truth'))
    x = f'v_s [{view.velocity_unit}]'
    label_axes(panels[0], x, 'cost above its least [limit]')
    label_axes(panels[1], x, f'best S at this v_s [{view.effort_unit}]')
    legend_below(figure, handles)
    return figure
