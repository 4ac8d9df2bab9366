# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Plan a trajectory for a robot: from a name and options to what it asks of each joint."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError, TrajectoryError
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.robot import Robot
from sosml_friction.motion.building_blocks import per_joint
from sosml_friction.motion.parameter_file import node_parameters
from sosml_friction.motion.trajectories import COMMON, TrajectoryKind, build_trajectory, find_kind
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.motion.trajectory_loads import (
    LimitUse,
    TrajectoryLoads,
    limit_uses,
    trajectory_loads,
)
from sosml_friction.motion.trajectory_option import TrajectoryOption, Value
from sosml_friction.share import share_directory
from sosml_friction.text_file import read_text

#: Step of the samples that are checked, drawn and written [s].
STEP_S = 0.01

#: As the parameters of identifier_node of these names.
_ROBOT_OPTIONS = tuple(
    TrajectoryOption(name, name, default, description, unit, limits)
    for name, default, description, unit, limits in (
        ('centre', (), 'about which each joint moves', 'rad or m', None),
        ('start', (), 'where each joint is; default: centre', 'rad or m', None),
        ('effort_margin', 0.85, 'share of the effort limit the rigid body alone may need', '',
         (0.01, 1.0)),
        ('acceleration_limit', (), 'one for all joints or one for each; default: effort alone '
         'limits it', 'rad/s2 or m/s2', (1e-6, 1e6)),
    )
)  # fmt: skip


@dataclass(frozen=True)
class Demand:
    """
    Hold the largest magnitude ``peak`` of a quantity of one joint, reached at ``at_s`` [s].

    ``allowance`` is what friction may need beside it; ``limit`` bounds the sum, where one does.
    """

    peak: float
    at_s: float
    limit: float | None
    allowance: float = 0.0

    @property
    def share(self) -> float | None:
        """Return which share of the limit is used, None where there is none."""
        return (self.peak + self.allowance) / self.limit if self.limit else None


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
    acceleration_limit: FloatArray | None
    uses: tuple[LimitUse, ...]

    @property
    def beyond(self) -> list[LimitUse]:
        """Return what is beyond a limit."""
        return [use for use in self.uses if not use.excess <= 0.0]

    def demands(self, joint: int) -> dict[str, Demand]:
        """Return what speed, acceleration and rigid-body effort a joint, by its index, needs."""
        loads, limit = self.loads, self.robot.limits[joint]
        fastest = self.acceleration_limit
        allowance = (1.0 - self.effort_margin) * limit.effort

        def demand(values: FloatArray, bound: float | None, more: float = 0.0) -> Demand:
            k = int(np.argmax(np.abs(values[:, joint])))
            return Demand(float(np.abs(values[k, joint])), float(loads.t[k]), bound, more)

        return {
            'speed': demand(loads.v, limit.velocity),
            'acceleration': demand(loads.a, None if fastest is None else float(fastest[joint])),
            'effort': demand(loads.tau, limit.effort, allowance),
        }


def plan_trajectory(
    name: str, model: Path | None = None, urdf: Path | None = None, stated: Sequence[str] = ()
) -> PlannedTrajectory:
    """
    Build trajectory ``name`` for a robot.

    Options have, in this order, the value that is stated, that of identifier_node in the parameter
    file beside the model folder (``DIR.yaml`` for ``DIR``), or their default; the centre of a
    joint is by default the middle of its range.

    :param model: model folder; None: the exoskeleton.
    :raises ConfigurationError: if a file cannot be used.
    :raises TrajectoryError: if an option is unknown or its value cannot be used.
    """
    kind = find_kind(name)
    folder = share_directory() / 'config' / 'exoskeleton' if model is None else model
    robot = read_model(folder).make_robot(None if urdf is None else read_text(urdf, 'URDF'))
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
    loads = trajectory_loads(trajectory, robot, STEP_S)
    margin = cast('float', values['effort_margin'])
    fastest = cast('tuple[float, ...]', values['acceleration_limit'])
    limit = per_joint('acceleration_limit', fastest, robot.n) if fastest else None
    uses = tuple(limit_uses(loads, robot, margin, limit))
    own |= {'centre': tuple(centre.values()), 'start': tuple(start.values())}
    return PlannedTrajectory(kind, own, robot, trajectory, loads, margin, limit, uses)


def _from_parameters(
    folder: Path, kind: type[TrajectoryKind], options: Mapping[str, TrajectoryOption]
) -> dict[str, Value]:
    """Return the options that the parameter file beside the model folder sets."""
    file = folder.resolve().with_suffix('.yaml')
    if not folder.is_dir() or not file.is_file():
        return {}
    flat = node_parameters(file, 'identifier_node', 'the parameter file beside the model,')
    plain = {o.name for o in (*COMMON, *_ROBOT_OPTIONS)}
    found = {}
    for name, option in options.items():
        key = name if kind.name == 'speed_ladder' or name in plain else f'{kind.name}.{name}'
        if key in flat:
            try:
                found[name] = option.check(flat[key])
            except (TypeError, ValueError, TrajectoryError) as error:
                raise ConfigurationError(
                    f'{key} of identifier_node in {file} is {flat[key]!r}: correct it'
                ) from error
    return found


def _positions(what: str, values: Value, robot: Robot) -> dict[str, float]:
    positions = cast('tuple[float, ...]', values)
    if positions and len(positions) != robot.n:
        raise TrajectoryError(
            f'{what} has {len(positions)} values for the joints {", ".join(robot.names)}: give '
            'one for each'
        )
    return dict(zip(robot.names, positions, strict=False))


def _middles(robot: Robot) -> dict[str, float]:
    middles = [0.5 * (limit.lower + limit.upper) for limit in robot.limits]
    if not np.isfinite(middles).all():
        raise TrajectoryError('a joint has no range in the URDF: set centre=VALUE,...')
    return dict(zip(robot.names, middles, strict=True))
