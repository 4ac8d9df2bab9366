# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The counterparts of the paper's Figures 2, 3 and 4, and noise against settle time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from sosml_friction.model.laws import make_friction_law, unit_of
from sosml_friction.report.common.drawing import (
    FONT,
    GREY,
    Style,
    draw_line,
    label_axes,
    legend_below,
    new_figure,
    style_of,
)
from sosml_friction.report.common.labels import SYMBOLS, observer_label
from sosml_friction.report.study.view import fitted_laws, is_causal, ranked, shown_observers
from sosml_friction.study.condition import GRAVITY_OFFSET, INERTIA_SCALES
from sosml_friction.study.metrics import SCORED_FROM_S, reversals
from sosml_friction.study.plant import PERIOD, SMOOTHING_VELOCITY, TRUTH
from sosml_friction.study.run import Study, rmse_mean
from sosml_friction.study.task import Case

FloatArray = NDArray[np.float64]

#: The figures by name of their file, with the cases each needs.
FIGURES: dict[str, tuple[Case, ...]] = {
    'figure2_slow_nominal': (('slow', 'nominal'),),
    'figure3_noise': (('slow', 'noise'), ('reversal', 'noise')),
    'figure4_mismatch': (('reversal', 'mismatch'),),
    'pareto': (('reversal', 'noise'),),
}
#: Speeds of the paper's Figure 2, and of the panel near zero of Figure 4 [rad/s].
_SLOW, _NEAR = 0.052, 0.1
#: Around the reversal that Figure 3 shows [s].
_BEFORE_S, _AFTER_S = 0.2, 0.6
_TRUTH_STYLE: dict[str, Any] = {'color': 'black', 'linestyle': '--', 'linewidth': 1.4}


def available_figures(study: Study) -> list[str]:
    """
    Return the figures that have something to show: their cases were run, Figure 3 with either.

    The Pareto front needs two noise seeds and an observer that settles.
    """
    return [
        name
        for name, cases in FIGURES.items()
        if any(case in study.observations and shown_observers(study, case) for case in cases)
        and (name != 'pareto' or _can_be_drawn(study))
    ]


def _can_be_drawn(study: Study) -> bool:
    return any(
        point.noise_std > 0.0 and np.isfinite(point.settle_s)
        for name, points in study.sweeps.items()
        if is_causal(name)
        for point in points
    )


def draw(study: Study, name: str) -> Figure:
    """Return one of :func:`available_figures`."""
    return {
        'figure2_slow_nominal': slow_nominal,
        'figure3_noise': error_traces,
        'figure4_mismatch': mismatch,
        'pareto': pareto,
    }[name](study)


def slow_nominal(study: Study) -> Figure:
    """
    Draw the slow motion without noise: the phase plane, and what is wrong in it.

    Left estimates, laws fitted to them and the true law; right estimate minus truth.
    """
    case = FIGURES['figure2_slow_nominal'][0]
    shown = shown_observers(study, case)
    figure = new_figure(10.0, 4.8)
    plane, error = figure.subplots(1, 2)
    handles = _phase_plane((plane,), study, case, shown, (_SLOW,))
    plane.set_title('friction over velocity', fontsize=FONT)
    observation = study.observations[case]
    kept = observation.time > SCORED_FROM_S
    v = observation.velocity[kept, 0]
    for k, name in enumerate(shown):
        style = style_of(name, k)
        wrong = 1e3 * (study.estimate(study.row(case, name)) - observation.friction)[kept, 0]
        width = min(style.width, 2.2)
        error.plot(v, wrong, color=style.colour, linewidth=width, linestyle=style.dashes)
    error.axhline(0.0, color=GREY, linewidth=0.6)
    error.set_xlim(-_SLOW, _SLOW)
    error.set_title('estimate minus truth', fontsize=FONT)
    label_axes(error, 'velocity [rad/s]', 'error [mNm]')
    legend_below(figure, handles)
    return figure


def error_traces(study: Study) -> Figure:
    """
    Draw estimate minus truth over time with noise, a row for each motion, with the RMSE.

    Left all that is scored, right one reversal.
    """
    cases = [case for case in FIGURES['figure3_noise'] if case in study.observations]
    figure = new_figure(10.0, 0.8 + 3.4 * len(cases))
    rows = figure.subplots(len(cases), 2, width_ratios=(2.6, 1.0), squeeze=False, sharey='row')
    for (whole, near), case in zip(rows, cases, strict=True):
        observation = study.observations[case]
        scored = observation.time > SCORED_FROM_S
        time = observation.time[scored]
        found = reversals(observation.time, observation.velocity[:, 0])
        turn = float(observation.time[found[len(found) // 2]])
        handles, reach = [], 0.0
        # The smallest error last: it would vanish under the others.
        shown = sorted(
            shown_observers(study, case), key=lambda name: ranked(study, case).index(name)
        )[::-1]
        for k, name in enumerate(shown):
            row = study.row(case, name)
            wrong = 1e3 * (study.estimate(row) - observation.friction)[scored, 0]
            reach = max(reach, float(np.quantile(np.abs(wrong), 0.999)))
            colour = style_of(name, k).colour
            draw_line(whole, time, wrong, color=colour, linewidth=0.8 + 0.2 * k)
            close = (time > turn - _BEFORE_S) & (time < turn + _AFTER_S)
            near.plot(time[close], wrong[close], color=colour, linewidth=0.8 + 0.2 * k)
            error = 1e3 * rmse_mean('noise', row.scores[0])
            text = f'{observer_label(name)}: RMSE {error:.3g} mNm'
            handles.append(Line2D([], [], color=colour, linewidth=2.5, label=text))
        for axes in (whole, near):
            axes.axhline(0.0, color=GREY, linewidth=0.6)
            label_axes(axes, '', '')
        whole.set_ylim(-1.1 * reach, 1.1 * reach)
        whole.margins(x=0.01)
        whole.set_ylabel(f'{case[0]}: error [mNm]', fontsize=FONT)
        near.set_xlim(turn - _BEFORE_S, turn + _AFTER_S)
        near.locator_params(axis='x', nbins=5)
        # Room for the legend, which is wider than its panel.
        whole.set_title(' ', fontsize=FONT, pad=12.0)
        legend = whole.legend(
            handles=handles, loc='lower left', bbox_to_anchor=(0.0, 1.0), ncols=3, fontsize=FONT,
            frameon=False, borderaxespad=0.2, handlelength=1.4,
        )  # fmt: skip
        legend.set_in_layout(False)
    for axes, text in zip(rows[-1], ('time [s]', 'time [s], one reversal'), strict=True):
        axes.set_xlabel(text, fontsize=FONT)
    figure.align_ylabels(rows[:, 0])
    return figure


def mismatch(study: Study) -> Figure:
    """
    Draw the reversal with a wrong model: phase plane above, fitted parameters below.

    The model is the first of the condition, the one with too much inertia.
    """
    case = FIGURES['figure4_mismatch'][0]
    shown = shown_observers(study, case)
    figure = new_figure(10.0, 7.4)
    grid = figure.add_gridspec(2, 10, height_ratios=(1.5, 1.0))
    whole, near = figure.add_subplot(grid[0, :6]), figure.add_subplot(grid[0, 6:])
    top = 1.05 * float(np.abs(study.observations[case].velocity[:, 0]).max())
    handles = _phase_plane((whole, near), study, case, shown, (top, _NEAR))
    whole.set_title(
        f'believed: M × {INERTIA_SCALES[0]:g}, g + {GRAVITY_OFFSET[0]:g} Nm', fontsize=FONT
    )
    near.set_title('near zero velocity', fontsize=FONT)
    near.set_ylabel('')
    laws = fitted_laws(study, case, shown)
    for column, (name, symbol) in enumerate(SYMBOLS.items()):
        axes = figure.add_subplot(grid[1, 2 * column : 2 * column + 2])
        for k, observer in enumerate(shown):
            value = laws[observer].parameters[name]
            axes.bar(k, value, width=0.7, color=style_of(observer, k).colour)
        axes.axhline(TRUTH[0][name], **_TRUTH_STYLE)
        axes.axhline(0.0, color=GREY, linewidth=0.6)
        axes.set_title(f'{symbol} [{unit_of(name, "Nm")}]', fontsize=FONT)
        label_axes(axes, '', '')
        axes.set_xticks([])
        axes.set_xlim(-0.7, len(shown) - 0.3)
        axes.margins(y=0.12)
    legend_below(figure, handles)
    return figure


def pareto(study: Study) -> Figure:
    """
    Draw noise against settle time in the reversal, by causal observer, its bandwidth varied.

    Large markers: as tuned for the smallest RMSE. Settle times below one sample are drawn there.
    """
    figure = new_figure(10.0, 6.2)
    axes: Axes = figure.subplots()
    handles = []
    shown = [name for name in study.sweeps if is_causal(name)]
    for k, name in enumerate(shown):
        style = style_of(name, k)
        points = study.sweeps[name]
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
            Line2D([], [], color=style.colour, linestyle=style.dashes, linewidth=width,
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
    label_axes(
        axes, 'time until the mean error stays below 10 % of the jump [ms]',
        'noise while friction is steady, std [mNm]',
    )  # fmt: skip
    legend_below(figure, handles)
    return figure


def _phase_plane(
    panels: Sequence[Axes],
    study: Study,
    case: Case,
    shown: Sequence[str],
    limits: Sequence[float],
) -> list[Any]:
    """Draw estimates, fitted laws and the truth into panels of rising detail; return handles."""
    observation = study.observations[case]
    kept = observation.time > SCORED_FROM_S
    v = observation.velocity[kept, 0]
    laws = fitted_laws(study, case, shown)
    estimates = {name: study.estimate(study.row(case, name))[kept, 0] for name in shown}
    truth = make_friction_law('stribeck', TRUTH[0], SMOOTHING_VELOCITY)
    for axes, limit in zip(panels, limits, strict=True):
        inside = np.flatnonzero(np.abs(v) <= limit)
        grid = np.linspace(-limit, limit, 801)
        for k, (name, estimate) in enumerate(estimates.items()):
            style = style_of(name, k)
            rows = inside[:: max(1, len(inside) // 4000)]
            axes.plot(v[rows], estimate[rows], linestyle='', marker='.', markersize=3.5,
                      color=style.colour, alpha=0.35, markeredgewidth=0.0)  # fmt: skip
            axes.plot(grid, laws[name].torque(grid), color=style.colour, linewidth=style.width,
                      linestyle=style.dashes, zorder=2.5)  # fmt: skip
        axes.plot(grid, truth.torque(grid), zorder=3.0, **_TRUTH_STYLE)
        axes.axhline(0.0, color=GREY, linewidth=0.6)
        axes.axvline(0.0, color=GREY, linewidth=0.6)
        axes.set_xlim(-limit, limit)
        label_axes(axes, 'velocity [rad/s]', 'friction τ_f [Nm]')
        axes.locator_params(axis='x', nbins=6)
    return _phase_handles(shown)


def _phase_handles(shown: Sequence[str]) -> list[Any]:
    handles: list[Any] = []
    for k, name in enumerate(shown):
        style: Style = style_of(name, k)
        handles.append(
            Line2D([], [], color=style.colour, linewidth=style.width, linestyle=style.dashes,
                   marker='.', markersize=8.0, label=f'{observer_label(name)}: samples and law')
        )  # fmt: skip
    handles.append(Line2D([], [], label='truth', **_TRUTH_STYLE))
    return handles
