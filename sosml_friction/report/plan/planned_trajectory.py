# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``sosml trajectory`` makes: a trajectory for a robot, and what it asks of it."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from sosml_friction.exceptions import ConfigurationError, TrajectoryError
from sosml_friction.model.model_folder import RobotModelFile, read_model
from sosml_friction.model.robot import Robot
from sosml_friction.motion.building_blocks import per_joint
from sosml_friction.motion.limit_use import LimitUse
from sosml_friction.motion.trajectories import COMMON, build_trajectory, find_kind
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_loads import (
    TrajectoryLoads,
    limit_uses,
    trajectory_loads,
)
from sosml_friction.motion.trajectory_option import TrajectoryOption, Value
from sosml_friction.report.common.labels import motion_units
from sosml_friction.report.common.number_text import UNKNOWN
from sosml_friction.share import share_directory

FORMAT = 'sosml_friction/trajectory/1'
#: Step of the samples that are checked, drawn and written [s].
STEP_S = 0.01

#: As the parameters of identifier_node of these names.
_ROBOT_OPTIONS = (
    TrajectoryOption('centre', 'centre', (), 'about which each joint moves', 'rad or m'),
    TrajectoryOption('start', 'start', (), 'where each joint is; default: centre', 'rad or m'),
    TrajectoryOption(
        'effort_margin',
        'effort_margin',
        0.85,
        'share of the effort limit the rigid body alone may need',
        '',
        (0.01, 1.0),
    ),
    TrajectoryOption(
        'acceleration_limit',
        'acceleration_limit',
        (),
        'one for all joints or one for each; default: effort alone limits it',
        'rad/s2 or m/s2',
        (1e-6, 1e6),
    ),
)


@dataclass(frozen=True)
class PlannedTrajectory:
    """
    Hold a trajectory, the robot it is for, and how much of the robot's limits it uses.

    ``options`` are the values it was made from; ``uses`` those of all joints and quantities.
    """

    kind: type[TrajectoryKind]
    options: Mapping[str, Value]
    robot: Robot
    trajectory: Trajectory
    loads: TrajectoryLoads
    effort_margin: float
    acceleration_limit: NDArray[np.float64] | None
    uses: tuple[LimitUse, ...]

    @property
    def beyond(self) -> list[LimitUse]:
        """Return what is beyond a limit."""
        return [use for use in self.uses if use.excess > 0.0]


def plan_trajectory(
    name: str, model: Path | None, urdf: Path | None, stated: Sequence[str]
) -> PlannedTrajectory:
    """
    Build trajectory ``name`` for a robot.

    Options have, in this order, the value that is stated, that of identifier_node in the parameter
    file beside the model folder (``DIR.yaml`` for ``DIR``), or their default; the centre of a
    joint is by default the middle of its range.

    :param model: model folder; None: the exoskeleton.
    :param urdf: URDF file in place of the model's.
    :param stated: entries ``KEY=VALUE``.
    :raises ConfigurationError: if a file cannot be used.
    :raises TrajectoryError: if an option is unknown or its value cannot be used.
    """
    kind = find_kind(name)
    folder = share_directory() / 'config' / 'exoskeleton' if model is None else model
    nominal = read_model(folder)
    robot = _make_robot(nominal, urdf)
    options = {o.name: o for o in (*kind.options, *COMMON, *_ROBOT_OPTIONS)}
    values = {key: option.default for key, option in options.items()}
    values |= _from_parameters(folder, kind, options)
    for entry in stated:
        key, equals, text = entry.partition('=')
        if not equals or key not in options:
            raise TrajectoryError(
                f'{entry!r} sets no option of {name}: write KEY=VALUE with {", ".join(options)}'
            )
        values[key] = options[key].parse(text)
    centre = _positions('centre', values['centre'], robot) or _middles(robot)
    start = _positions('start', values['start'], robot) or centre
    own = {o.name: values[o.name] for o in (*kind.options, *COMMON)}
    trajectory = build_trajectory(name, start, centre, own)
    margin, acceleration = values['effort_margin'], values['acceleration_limit']
    assert isinstance(margin, float)
    assert isinstance(acceleration, tuple)
    limit = per_joint('acceleration_limit', acceleration, robot.n) if acceleration else None
    loads = trajectory_loads(trajectory, robot, STEP_S)
    uses = tuple(limit_uses(loads, robot, margin, limit))
    own |= {'centre': tuple(centre.values()), 'start': tuple(start.values())}
    return PlannedTrajectory(kind, own, robot, trajectory, loads, margin, limit, uses)


def trajectory_document(planned: PlannedTrajectory) -> dict[str, Any]:
    """Return the object of ``sosml trajectory --json``."""
    loads, robot = planned.loads, planned.robot
    joints = {}
    for i, (name, limit) in enumerate(zip(robot.names, robot.limits, strict=True)):
        peak = {
            what: _peak(loads.t, values[:, i])
            for what, values in (('speed', loads.v), ('acceleration', loads.a),
                                 ('effort', loads.tau))
        }  # fmt: skip
        bound = planned.acceleration_limit
        joints[name] = {
            'unit': robot.effort_units[i],
            'position': {
                'lowest': float(loads.q[:, i].min()),
                'highest': float(loads.q[:, i].max()),
                'lower_limit': limit.lower,
                'upper_limit': limit.upper,
            },
            'speed': {**peak['speed'], 'limit': limit.velocity},
            'acceleration': {
                **peak['acceleration'],
                'limit': None if bound is None else float(bound[i]),
            },
            'effort': {
                **peak['effort'],
                'friction_allowance': (1.0 - planned.effort_margin) * limit.effort,
                'limit': limit.effort,
            },
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


def trajectory_table(planned: PlannedTrajectory) -> RenderableType:
    """Return duration, extremes of each joint beside its limits, and what is beyond them."""
    document = trajectory_document(planned)
    table = Table(box=box.SIMPLE, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column('joint', no_wrap=True)
    table.add_column('quantity', no_wrap=True)
    table.add_column('unit', no_wrap=True)
    for heading in ('reaches', 'friction needs', 'limit', 'share'):
        table.add_column(heading, justify='right', no_wrap=True)
    for name, joint in document['joints'].items():
        way, speed = motion_units(joint['unit'])
        q = joint['position']
        table.add_row(
            name, 'position', way, f'{q["lowest"]:.3g} to {q["highest"]:.3g}', '',
            f'{q["lower_limit"]:.3g} to {q["upper_limit"]:.3g}', '',
        )  # fmt: skip
        for what, unit in (('speed', speed), ('acceleration', f'{speed}2'),
                           ('effort', joint['unit'])):  # fmt: skip
            entry = joint[what]
            limit, allowance = entry['limit'], entry.get('friction_allowance', 0.0)
            table.add_row(
                '', what, unit, f'{entry["peak"]:.3g}', f'{allowance:.3g}' if allowance else '',
                UNKNOWN if limit is None else f'{limit:.3g}',
                UNKNOWN if not limit else f'{100.0 * (entry["peak"] + allowance) / limit:.0f} %',
                end_section=what == 'effort',
            )  # fmt: skip
    verdict = [f'Beyond a limit: {sentence}' for sentence in document['beyond']]
    return Group(
        Text(f'{planned.kind.description}: {document["duration_s"]:.1f} s'),
        table,
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
    stream = StringIO()
    writer = csv.writer(stream, lineterminator='\n')
    writer.writerow(header)
    writer.writerows([f'{x:.9g}' for x in row] for row in np.column_stack(columns).tolist())
    return stream.getvalue()


def check_file(path: Path, option: str, suffix: str, begins: bytes) -> Path:
    """
    Return ``path`` if a file of this kind may be written there, in place of another of its kind.

    :param begins: how a file of this kind begins.
    :raises ConfigurationError: if its name or its folder does not fit, or another file is there.
    """
    if path.suffix.lower() != suffix:
        raise ConfigurationError(f'{option} {path} does not end in {suffix}: name it so')
    if not path.parent.is_dir():
        raise ConfigurationError(f'{path.parent} is no folder: choose another place with {option}')
    try:
        foreign = path.exists() and not path.read_bytes().startswith(begins)
    except OSError as error:
        raise ConfigurationError(
            f'{path} cannot be read: choose another place with {option}'
        ) from error
    if foreign:
        raise ConfigurationError(
            f'{path} exists and is something else, so it is not overwritten: choose another place '
            f'with {option}'
        )
    return path


def write_file(path: Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all."""
    beside = path.with_name(f'.{path.name}.part')
    beside.write_bytes(content)
    beside.replace(path)


def _make_robot(nominal: RobotModelFile, urdf: Path | None) -> Robot:
    if urdf is None:
        return nominal.make_robot()
    try:
        return nominal.make_robot(urdf.read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f'the URDF {urdf} cannot be read: give a URDF file') from error


def _from_parameters(
    folder: Path, kind: type[TrajectoryKind], options: Mapping[str, TrajectoryOption]
) -> dict[str, Value]:
    """Return the options that the parameter file beside the model folder sets."""
    file = folder.resolve().with_suffix('.yaml') if folder.is_dir() else None
    if file is None or not file.is_file():
        return {}
    try:
        document = yaml.safe_load(file.read_text(encoding='utf-8')) or {}
        sections = [
            entry.get('ros__parameters', {})
            for key, entry in document.items()
            if str(key).rpartition('/')[2] == 'identifier_node'
        ]
        flat: dict[str, Any] = {}
        for section in sections:
            for key, value in section.items():
                nested = value.items() if isinstance(value, dict) else ()
                flat |= {f'{key}.{name}': x for name, x in nested} or {key: value}
    except (OSError, UnicodeDecodeError, yaml.YAMLError, AttributeError) as error:
        raise ConfigurationError(
            f'{file}, the parameter file beside the model, cannot be read: correct it'
        ) from error
    plain = {o.name for o in (*COMMON, *_ROBOT_OPTIONS)}
    found = {}
    for name, option in options.items():
        ladder = kind.name == 'speed_ladder'
        key = name if ladder or name in plain else f'{kind.name}.{name}'
        if key in flat:
            try:
                found[name] = option.check(flat[key])
            except (TypeError, ValueError, TrajectoryError) as error:
                raise ConfigurationError(
                    f'{key} of identifier_node in {file} is {flat[key]!r}: correct it'
                ) from error
    return found


def _positions(what: str, values: Value, robot: Robot) -> dict[str, float]:
    assert isinstance(values, tuple)
    if not values:
        return {}
    if len(values) != robot.n:
        raise TrajectoryError(
            f'{what} has {len(values)} values for the joints {", ".join(robot.names)}: give one '
            'for each'
        )
    return dict(zip(robot.names, values, strict=True))


def _middles(robot: Robot) -> dict[str, float]:
    middles = {
        name: 0.5 * (limit.lower + limit.upper)
        for name, limit in zip(robot.names, robot.limits, strict=True)
    }
    if not np.isfinite(list(middles.values())).all():
        raise TrajectoryError('a joint has no range in the URDF: set centre=VALUE,...')
    return middles


def _peak(t: NDArray[np.float64], values: NDArray[np.float64]) -> dict[str, float]:
    k = int(np.argmax(np.abs(values)))
    return {'peak': float(np.abs(values[k])), 'at_s': float(t[k])}
