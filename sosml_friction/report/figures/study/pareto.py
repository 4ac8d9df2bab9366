# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise against settle time of every causal observer."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import observer_label
from sosml_friction.study.outcome import is_causal
from sosml_friction.study.plant import PERIOD
from sosml_friction.study.run import Study


class Pareto(Figure[Study]):
    """Draw noise against settle time in the reversal, by causal observer, its bandwidth varied."""

    identifier = 'pareto'
    title = 'Noise against settle time'
    report = 'study'
    order = 40
    caption = (
        'Noise against settle time, reversal with noise: the bandwidth of each causal '
        'observer from a fifth to five times the tuned one (large marker), other '
        'ratios of its gains kept. Left and down is better. Times below one sample '
        'are drawn at 1 ms; points at which noise hides the mean error, or '
        'which do not settle, are left out.'
    )

    def applies(self, view: Study) -> bool:
        """Tell whether there are two noise seeds and an observer that settles."""
        return any(
            point.noise_std > 0.0 and np.isfinite(point.settle_s)
            for name, points in view.sweeps.items()
            if is_causal(name)
            for point in points
        )

    def draw(self, view: Study) -> Drawing:
        """Draw a line for each observer; a large marker where it is tuned."""
        figure = drawing.new_figure(10.0, 6.2)
        axes: Axes = figure.subplots()
        handles = []
        shown = [name for name in view.sweeps if is_causal(name)]
        for k, name in enumerate(shown):
            style = drawing.style_of(name, k)
            points = view.sweeps[name]
            # A point that is not known breaks the line.
            settle = 1e3 * np.maximum([p.settle_s for p in points], PERIOD)
            noise = 1e3 * np.array([p.noise_std for p in points])
            noise[np.isnan(settle)] = np.nan
            width, cross = min(style.width, 2.0), style.marker == 'x'
            # The first on top: simple observers are those to be beaten.
            order = 3.0 - 0.05 * k
            axes.plot(settle, noise, color=style.colour, linestyle=style.dashes, linewidth=width,
                      marker=style.marker, markersize=5.0, zorder=order)  # fmt: skip
            tuned = [abs(np.log(p.factor)) < 1e-9 for p in points]
            axes.plot(settle[tuned], noise[tuned], linestyle='', color=style.colour,
                      marker=style.marker, markersize=11.0, zorder=order + 1.0,
                      markeredgecolor=style.colour if cross else 'white',
                      markeredgewidth=2.5 if cross else 1.0)  # fmt: skip
            seen = np.isfinite(noise).any()
            handles.append(
                drawing.key(color=style.colour, linestyle=style.dashes, linewidth=width,
                       marker=style.marker, markersize=6.0,
                       label=observer_label(name) + ('' if seen else ' (never settled)'))
            )  # fmt: skip
        axes.set_xscale('log')
        axes.set_yscale('log')
        least = 1e3 * PERIOD
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter(
            FuncFormatter(lambda x, _: f'≤ {x:g}' if x == least else f'{x:g}')
        )
        axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f'{y:g}'))
        drawing.label_axes(
            axes, 'time until the mean error stays below 10 % of the jump [ms]',
            'noise while friction is steady, std [mNm]',
        )  # fmt: skip
        drawing.legend_below(figure, handles)
        return figure
