# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording and its simulation, one joint."""

import numpy as np
from matplotlib.figure import Figure as Drawing

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.report.common import drawing
from sosml_friction.report.common.figure import Figure
from sosml_friction.report.common.labels import motion_units
from sosml_friction.report.simulation.document import SimulatedJoint
from sosml_friction.simulation.recorded.recorded_simulation import CLOSED_LOOP, WINDOWS

#: Interval, in median sampling intervals, at which a line is broken. Chosen, no measurement.
_HOLE = 10.0
_SIMULATED, _ERROR = '#0072B2', '#D55E00'


class SimulatedJointFigure(Figure[SimulatedJoint]):
    """Draw position, velocity, effort, and the error of each beside it, over time."""

    identifier = 'simulated_joint'
    title = 'Measured and simulated'
    report = 'simulation'
    order = 10
    caption = '{view.name}: measured, and simulated; to the right their difference'

    def caption_of(self, view: SimulatedJoint) -> str:
        """Say also what a window is, where there are any."""
        text = super().caption_of(view)
        if view.found.mode != CLOSED_LOOP:
            text += '; each window begins anew where the error of position is 0'
        return text

    def applies(self, view: SimulatedJoint) -> bool:
        """Tell whether the joint was simulated: in a closed loop some move as recorded."""
        return view.found.mode != CLOSED_LOOP or view.name not in view.found.followed

    def draw(self, view: SimulatedJoint) -> Drawing:
        found, i = view
        figure = drawing.new_figure(11.0, 7.6)
        axes = figure.subplots(3, 2, sharex=True, width_ratios=[1.0, 1.0])
        effort = found.units[i]
        length, speed = motion_units(effort)
        panels = (
            ('position', length, 1e3, f'm{length}'),
            ('velocity', speed, 1e3, f'm{speed}'),
            ('effort', effort, 1.0, effort),
        )
        steps = np.diff(found.time, prepend=found.time[:1])
        holes = steps > _HOLE * np.median(steps)
        begins = holes | found.begins
        for (left, right), (what, unit, factor, small) in zip(axes, panels, strict=True):
            measured, simulated = found.measured[what][:, i], found.simulated[what][:, i]
            left.plot(*_parted(found.time, measured, holes), color=drawing.GREY, linewidth=2.2)
            left.plot(*_parted(found.time, simulated, begins), color=_SIMULATED, linewidth=1.0)
            error = factor * (simulated - measured)
            right.plot(*_parted(found.time, error, begins), color=_ERROR, linewidth=0.9)
            time = 'time [s]' if what == 'effort' else ''
            drawing.label_axes(left, time, f'{what} [{unit}]')
            drawing.label_axes(right, time, f'simulated - measured [{small}]')
        own = 'simulated'
        if found.mode == WINDOWS:
            own = 'simulated (effort: what the model needs for the measured motion)'
        drawing.legend_below(
            figure,
            [
                drawing.key(color=drawing.GREY, linewidth=2.2, label='measured'),
                drawing.key(color=_SIMULATED, label=own),
                drawing.key(color=_ERROR, label='error'),
            ],
        )
        return figure


def _parted(
    time: FloatArray, values: FloatArray, begins: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Return a line, a long one as its envelope, with a hole before each sample that begins."""
    t, x = drawing.envelope(time, values)
    piece = np.searchsorted(time[begins], t, side='right')
    first = np.flatnonzero(np.diff(piece)) + 1
    return np.insert(t, first, t[first]), np.insert(x, first, np.nan)
