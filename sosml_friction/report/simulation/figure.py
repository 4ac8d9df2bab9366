# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figure of a recording and its simulation, one joint."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from sosml_friction.report.common.drawing import (
    GREY,
    envelope,
    label_axes,
    legend_below,
    new_figure,
)
from sosml_friction.simulation.recorded.recorded_simulation import WINDOWS, RecordedSimulation

FloatArray = NDArray[np.float64]

#: A line ends where so many usual steps are missing.
_HOLE = 10.0
_SIMULATED, _ERROR = '#0072B2', '#D55E00'


def simulation_figure(found: RecordedSimulation, i: int) -> Figure:
    """Return position, velocity, effort, and the error of each beside it, over time."""
    figure = new_figure(11.0, 7.6)
    axes = figure.subplots(3, 2, sharex=True, width_ratios=[1.0, 1.0])
    effort = found.units[i]
    metres = effort == 'N'
    length = 'm' if metres else 'rad'
    panels = (
        ('position', length, 1e3, 'mm' if metres else 'mrad'),
        ('velocity', f'{length}/s', 1e3, 'mm/s' if metres else 'mrad/s'),
        ('effort', effort, 1.0, effort),
    )
    steps = np.diff(found.time, prepend=found.time[:1])
    holes = steps > _HOLE * np.median(steps)
    begins = holes | found.begins
    for row, (what, unit, factor, small) in enumerate(panels):
        measured, simulated = found.measured[what][:, i], found.simulated[what][:, i]
        left, right = axes[row]
        left.plot(*_parted(found.time, measured, holes), color=GREY, linewidth=2.2)
        left.plot(*_parted(found.time, simulated, begins), color=_SIMULATED, linewidth=1.0)
        error = factor * (simulated - measured)
        right.plot(*_parted(found.time, error, begins), color=_ERROR, linewidth=0.9)
        last = row == len(panels) - 1
        label_axes(left, 'time [s]' if last else '', f'{what} [{unit}]')
        label_axes(right, 'time [s]' if last else '', f'simulated - measured [{small}]')
    own = 'simulated'
    if found.mode == WINDOWS:
        own = 'simulated (effort: what the model needs for the measured motion)'
    legend_below(
        figure,
        [
            Line2D([], [], color=GREY, linewidth=2.2, label='measured'),
            Line2D([], [], color=_SIMULATED, label=own),
            Line2D([], [], color=_ERROR, label='error'),
        ],
    )
    return figure


def _parted(
    time: FloatArray, values: FloatArray, begins: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Return a line, a long one as its envelope, with a hole before each sample that begins."""
    t, x = envelope(time, values)
    piece = np.searchsorted(time[begins], t, side='right')
    first = np.flatnonzero(np.diff(piece)) + 1
    return np.insert(t, first, t[first]), np.insert(x, first, np.nan)
