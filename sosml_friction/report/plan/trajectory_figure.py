# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A picture of a trajectory: position, velocity and effort of each joint, with the limits."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sosml_friction.arrays import FloatArray
from sosml_friction.motion.plan import PlannedTrajectory
from sosml_friction.report.common import drawing
from sosml_friction.report.common.drawing import FONT, GREY
from sosml_friction.report.common.labels import motion_units

_LINE, _LIMIT = '#0072B2', '#D55E00'
#: Farthest that a limit may be from the line to be drawn, as a share of the line's height.
#: Chosen, no measurement.
_NEAR = 0.6


def trajectory_figure(planned: PlannedTrajectory) -> Figure:
    """
    Draw one column per joint: position, velocity, and the rigid body's effort over time.

    Limits are dashed where they are near, and always written; what is beyond them is in their
    colour. The limit of effort is what the allowance for friction leaves.
    """
    loads, robot = planned.loads, planned.robot
    figure = drawing.new_figure(max(9.0, 4.6 * robot.n), 7.2)
    panels = np.asarray(
        figure.subplots(3, robot.n, sharex=True, squeeze=False, height_ratios=(1.0, 1.0, 1.0))
    )
    for i, (name, limit) in enumerate(zip(robot.names, robot.limits, strict=True)):
        unit = robot.effort_units[i]
        way, speed = motion_units(unit)
        effort = planned.effort_margin * limit.effort
        rows = (
            (loads.q[:, i], (limit.lower, limit.upper), f'position [{way}]', way),
            (loads.v[:, i], (-limit.velocity, limit.velocity), f'velocity [{speed}]', speed),
            (loads.tau[:, i], (-effort, effort), f'rigid-body effort [{unit}]', unit),
        )
        for row, (values, limits, label, of) in enumerate(rows):
            axes: Axes = panels[row, i]
            _draw(axes, loads.t, values, limits)
            drawing.label_axes(axes, '', label)
            text = f'limits {limits[0]:.3g} to {limits[1]:.3g} {of}'
            if row == 2 and planned.effort_margin < 1.0:
                text += f' ({100 * planned.effort_margin:.0f} %, the rest is for friction)'
            axes.set_title(text.replace('-', '−'), fontsize=FONT, color=GREY, loc='right')
        panels[0, i].set_title(name, fontsize=FONT + 2, fontweight='bold', loc='left')
        panels[2, i].set_xlabel('time [s]', fontsize=FONT)
        figure.align_ylabels(panels[:, i])
    verdict = 'beyond a limit' if planned.beyond else 'within all limits'
    figure.suptitle(
        f'{planned.kind.name} of {robot.robot_name}, {planned.trajectory.duration:.1f} s, '
        f'{verdict}',
        fontsize=FONT + 3,
    )
    if planned.beyond:
        handles = [
            drawing.key(color=_LINE, linewidth=1.6, label='within the limits'),
            drawing.key(color=_LIMIT, linewidth=1.6, label='beyond a limit'),
        ]
        panels[0, 0].legend(handles=handles, fontsize=FONT, frameon=False, loc='best')
    return figure


def _draw(axes: Axes, t: FloatArray, values: FloatArray, limits: tuple[float, float]) -> None:
    axes.margins(x=0.01)
    axes.axhline(0.0, color=GREY, linewidth=0.6)
    drawing.draw_line(axes, t, values, color=_LINE, linewidth=1.4)
    beyond = (values < limits[0]) | (values > limits[1])
    if beyond.any():
        drawing.draw_line(axes, t, np.where(beyond, values, np.nan), color=_LIMIT, linewidth=2.4)
    low, high = float(values.min()), float(values.max())
    height = high - low or abs(high) or 1.0
    low, high = low - 0.08 * height, high + 0.08 * height
    for limit in limits:
        if low - _NEAR * height <= limit <= high + _NEAR * height:
            axes.axhline(limit, color=_LIMIT, linewidth=1.2, linestyle='--')
            low, high = min(low, limit - 0.05 * height), max(high, limit + 0.05 * height)
    axes.set_ylim(low, high)
