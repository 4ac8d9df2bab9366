# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Estimates over velocity with the laws fitted to them: the phase plane of a study's case."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from sosml_friction.model.laws import make_friction_law
from sosml_friction.report.common.drawing import GREY, key, label_axes, style_of
from sosml_friction.report.common.labels import observer_label
from sosml_friction.study.metrics import SCORED_FROM_S
from sosml_friction.study.outcome import fitted_laws
from sosml_friction.study.plant import SMOOTHING_VELOCITY, TRUTH
from sosml_friction.study.run import Study
from sosml_friction.study.task import Case

TRUTH_STYLE: dict[str, Any] = {'color': 'black', 'linestyle': '--', 'linewidth': 1.4}


def draw_phase_plane(
    panels: Sequence[Axes], study: Study, case: Case, shown: Sequence[str], limits: Sequence[float]
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
        axes.plot(grid, truth.torque(grid), zorder=3.0, **TRUTH_STYLE)
        axes.axhline(0.0, color=GREY, linewidth=0.6)
        axes.axvline(0.0, color=GREY, linewidth=0.6)
        axes.set_xlim(-limit, limit)
        label_axes(axes, 'velocity [rad/s]', 'friction τ_f [Nm]')
        axes.locator_params(axis='x', nbins=6)
    handles: list[Any] = []
    for k, name in enumerate(shown):
        style = style_of(name, k)
        handles.append(
            key(color=style.colour, linewidth=style.width, linestyle=style.dashes,
                   marker='.', markersize=8.0, label=f'{observer_label(name)}: samples and law')
        )  # fmt: skip
    handles.append(key(label='truth', **TRUTH_STYLE))
    return handles
