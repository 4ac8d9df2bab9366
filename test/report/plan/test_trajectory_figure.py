# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a trajectory: units, limits in words and as lines, what is beyond them."""

import numpy as np
import pytest

from sosml_friction.motion.plan import plan_trajectory
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.plan.trajectory_figure import _LIMIT, trajectory_figure
from sosml_friction.share import share_directory


def panels(figure, joints):
    return np.array(figure.axes).reshape(3, joints)


def dashes(axes):
    """Return the heights of the limits that are drawn."""
    return sorted(line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == '--')


def test_each_joint_has_position_velocity_and_effort_with_units_and_limits():
    figure = trajectory_figure(plan_trajectory('speed_ladder'))
    axes = panels(figure, 2)
    assert [a.get_ylabel() for a in axes[:, 0]] == [
        'position [rad]',
        'velocity [rad/s]',
        'rigid-body effort [Nm]',
    ]
    assert [a.get_title(loc='left') for a in axes[0]] == ['shoulder', 'elbow']
    assert axes[0, 0].get_title(loc='right') == 'limits −2.3 to 0.7 rad'
    assert axes[2, 1].get_title(loc='right') == (
        'limits −4.25 to 4.25 Nm (85 %, the rest is for friction)'
    )
    assert axes[2, 0].get_xlabel() == 'time [s]'
    assert 'within all limits' in figure.texts[0].get_text()
    # Limits near the motion are lines inside the picture, those far away are not.
    assert dashes(axes[2, 0]) == pytest.approx([-6.8, 6.8])
    low, high = axes[2, 0].get_ylim()
    assert low < -6.8 < 6.8 < high
    assert dashes(axes[1, 0]) == []


def test_what_is_beyond_a_limit_is_drawn_in_its_colour():
    planned = plan_trajectory('speed_ladder', stated=['centre=0,1'])
    figure = trajectory_figure(planned)
    assert 'beyond a limit' in figure.texts[0].get_text()
    axes = panels(figure, 2)
    drawn = [
        line for line in axes[2, 0].lines if line.get_color() == _LIMIT and line.get_ls() == '-'
    ]
    assert len(drawn) == 1
    heights = np.asarray(drawn[0].get_ydata())
    assert np.nanmin(np.abs(heights)) > 6.8
    assert not [
        line for line in axes[2, 1].lines if line.get_color() == _LIMIT and line.get_ls() == '-'
    ]
    assert to_png(figure).startswith(b'\x89PNG')


def test_a_prismatic_joint_has_metres_and_newtons():
    emps = share_directory() / 'config' / 'emps'
    options = ['speeds=0.01,0.05', 'top_speed=0.1', 'effort_margin=1']
    figure = trajectory_figure(plan_trajectory('speed_ladder', emps, stated=options))
    axes = panels(figure, 1)
    assert [a.get_ylabel() for a in axes[:, 0]] == [
        'position [m]',
        'velocity [m/s]',
        'rigid-body effort [N]',
    ]
    # No allowance, no words of it.
    assert axes[2, 0].get_title(loc='right') == 'limits −160 to 160 N'
