# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How well the data know the Stribeck term: the profile likelihood of v_s and S."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing

from sosml_friction.report.common.drawing import GREY, key, label_axes, legend_below, new_figure
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.fit.joint_view import JointView

#: The height of the panels, in units of the 95 % limit.
_HEIGHT = 3.0
#: Excess, in heights of the panel, above which S of a law is not drawn. Chosen, no measurement.
_FAR = 10.0
#: How far above the usual S the panel of S goes.
_DECADES = 100.0


class Profile(Figure[JointView]):
    """
    Draw the cost over v_s, and the S that goes with each v_s, of each observer that has a profile.

    The cost is above its least, in units of the 95 % limit: below 1 a value is in the interval.
    """

    identifier = 'profile'
    title = 'How well the Stribeck term is known'
    report = 'fit'
    order = 50
    caption = (
        'Profile likelihood of joint {view.name}: how much worse the best law with this v_s '
        '(or this S) fits. Below the line it is within the 95 % interval; a curve that stays '
        'below it to an edge is a parameter that the data leave open on that side.'
    )

    def applies(self, view: JointView) -> bool:
        return any(fit.fit.profile is not None for fit in view.fits.values())

    def draw(self, view: JointView) -> Drawing:
        figure = new_figure(10.0, 3.6)
        panels: Sequence[Axes] = figure.subplots(1, 2)
        cost, sizes = panels
        handles: list[Any] = []
        reach: list[float] = []
        for observer, fit in view.fits.items():
            if fit.fit.profile is None:
                continue
            colour, _, dashes, _ = view.style(observer)
            v_s, excess, size, half = fit.fit.profile.with_best(fit.fit.drawn)
            within = excess <= 1.0
            size = np.where(excess <= _FAR * _HEIGHT, size, np.nan)
            cost.plot(v_s, excess, color=colour, linestyle=dashes, linewidth=1.8)
            sizes.plot(v_s, size, color=colour, linewidth=1.0, alpha=0.5)
            sizes.plot(v_s, np.where(within, size, np.nan), color=colour, linewidth=3.0)
            half = np.where(within & np.isfinite(half), half, np.nan)
            sizes.fill_between(v_s, size - half, size + half, color=colour, alpha=0.2, linewidth=0)
            reach += [*size[within], *(size + half)[np.isfinite(half)]]
            label = observer_label(observer)
            handles.append(key(color=colour, linewidth=1.8, linestyle=dashes, label=label))
        for axes in panels:
            axes.set_xscale('log')
        cost.axhline(1.0, color=GREY, linestyle=':', linewidth=1.4)
        cost.set_ylim(-0.04 * _HEIGHT, _HEIGHT)
        sizes.set_yscale('log')
        seen = [x for x in reach if 0.0 < x < np.inf]
        if seen:
            # Where v_s is next to nothing S is any number: the panel ends before that.
            high = min(float(np.max(seen)), _DECADES * float(np.median(seen)))
            sizes.set_ylim(0.4 * float(np.min(seen)), 2.5 * high)
        span = cost.get_xlim()
        for axes in panels:
            axes.set_xlim(span)
        limit = 'limit of the 95 % interval'
        handles += [
            key(color=GREY, linestyle=':', linewidth=1.4, label=limit),
            key(color=GREY, linewidth=3.0, label='S at a v_s within the limit'),
        ]
        if {'stribeck', 'stribeck_velocity'} <= set(view.known):
            place = (view.known['stribeck_velocity'].value, view.known['stribeck'].value)
            cost.axvline(place[0], color='black', linestyle='--', linewidth=1.1)
            sizes.plot(*place, marker='+', markersize=12, color='black', markeredgewidth=1.6)
            handles.append(key(color='black', linestyle='--', label='truth'))
        x = f'v_s [{view.velocity_unit}]'
        label_axes(cost, x, 'cost above its least [limit]')
        label_axes(sizes, x, f'best S at this v_s [{view.effort_unit}]')
        legend_below(figure, handles)
        return figure
