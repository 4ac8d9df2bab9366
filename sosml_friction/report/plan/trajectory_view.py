# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml trajectory`` prints and writes of a planned trajectory."""

from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from sosml_friction.identification.number_text import UNKNOWN
from sosml_friction.motion.plan import Demand, PlannedTrajectory
from sosml_friction.report.common.labels import motion_units
from sosml_friction.report.common.output import csv_text
from sosml_friction.report.common.table import terminal_table

FORMAT = 'sosml_friction/trajectory/1'


def trajectory_document(planned: PlannedTrajectory) -> dict[str, Any]:
    """Return the object of ``sosml trajectory --json``."""
    robot = planned.robot
    joints = {}
    for i, (name, limit) in enumerate(zip(robot.names, robot.limits, strict=True)):
        joints[name] = {
            'unit': robot.effort_units[i],
            'position': {
                'lowest': float(planned.loads.q[:, i].min()),
                'highest': float(planned.loads.q[:, i].max()),
                'lower_limit': limit.lower,
                'upper_limit': limit.upper,
            },
            **{what: _demand_entry(what, own) for what, own in planned.demands(i).items()},
        }
    return {
        'format': FORMAT,
        'trajectory': planned.kind.name,
        'robot': robot.robot_name,
        'duration_s': planned.trajectory.duration,
        'knots': len(planned.trajectory.t),
        'options': dict(planned.options),
        'joints': joints,
        'fits': not planned.beyond,
        'beyond': [use.sentence() for use in planned.beyond],
    }


def _demand_entry(what: str, demand: Demand) -> dict[str, Any]:
    friction = {'friction_allowance': demand.allowance} if what == 'effort' else {}
    return {'peak': demand.peak, 'at_s': demand.at_s, **friction, 'limit': demand.limit}


def trajectory_table(planned: PlannedTrajectory) -> RenderableType:
    """Return duration, extremes of each joint beside its limits, and what is beyond them."""
    columns = {'joint': 'w', 'quantity': 'w', 'unit': 'w', 'reaches': 'n w'}
    columns |= {'friction needs': 'n w', 'limit': 'n w', 'share': 'n w'}
    rows = []
    robot = planned.robot
    for i, (name, limit) in enumerate(zip(robot.names, robot.limits, strict=True)):
        way, speed = motion_units(robot.effort_units[i])
        q = planned.loads.q[:, i]
        span, bounds = f'{q.min():.3g} to {q.max():.3g}', f'{limit.lower:.3g} to {limit.upper:.3g}'
        rows.append((name, 'position', way, span, '', bounds, ''))
        units = {'speed': speed, 'acceleration': f'{speed}2', 'effort': robot.effort_units[i]}
        for what, demand in planned.demands(i).items():
            friction = f'{demand.allowance:.3g}' if demand.allowance else ''
            bound = UNKNOWN if demand.limit is None else f'{demand.limit:.3g}'
            share = UNKNOWN if demand.share is None else f'{100.0 * demand.share:.0f} %'
            rows.append(('', what, units[what], f'{demand.peak:.3g}', friction, bound, share))
    verdict = [f'Beyond a limit: {use.sentence()}' for use in planned.beyond]
    return Group(
        Text(f'{planned.kind.description}: {planned.trajectory.duration:.1f} s'),
        terminal_table(columns, rows, sections=True),
        Text('\n'.join(verdict or ['All within the limits.'])),
    )


def trajectory_csv(planned: PlannedTrajectory) -> str:
    """Return time and, for each joint, position, velocity, acceleration, rigid-body effort."""
    loads, robot = planned.loads, planned.robot
    header = ['time [s]']
    columns = [loads.t]
    for i, (name, unit) in enumerate(zip(robot.names, robot.effort_units, strict=True)):
        way, speed = motion_units(unit)
        header += [
            f'{name} position [{way}]',
            f'{name} velocity [{speed}]',
            f'{name} acceleration [{speed}2]',
            f'{name} rigid-body effort [{unit}]',
        ]
        columns += [loads.q[:, i], loads.v[:, i], loads.a[:, i], loads.tau[:, i]]
    return csv_text(header, np.column_stack(columns).tolist())
