# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's loop as a bag tells of it: gains, trajectory, and the driver's own model."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.controllers import ACTUATOR, PD, read_controllers
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.recorded_robot import read_nominal
from sosml_friction.exceptions import ConfigurationError, DataError, TrajectoryError
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory import Trajectory

#: Largest sampling interval, in cycles of the controller, in which each of its cycles is still
#: recorded: at 1 all are, at 2 every other. The middle.
_SLOWER = 1.5
#: Times before the trajectory is recorded, and after it ends, between which the robot is under its
#: controller [s]. Chosen, no measurement.
_BEFORE_S, _AFTER_S = 0.1, 1.0


@dataclass(frozen=True)
class PdGains:
    """
    Hold one joint's controller, as :mod:`sosml_friction.bags.controllers` describes it.

    ``kp`` [Nm/rad or N/m], ``kd`` [Nm s/rad or N s/m], ``limit`` [Nm or N], ``rate_limit`` [Nm/s
    or N/s], ``rate`` [Hz], ``velocity_window`` [samples].
    """

    kp: float
    kd: float
    limit: float
    rate_limit: float
    rate: float
    velocity_window: int


@dataclass(frozen=True)
class RecordedLoop:
    """
    Hold what drove a robot.

    ``gains`` of the joints under the driver's own controller; ``followed``: why the loop of the
    others is not known, by joint. ``robot``: the driver's model, whose inverse dynamics at the
    reference is fed forward. ``wanted``: what was sent, joints in the robot's order, ``sent`` [s]
    after the first sample of the log as the recorder's clock has it.
    """

    gains: Mapping[str, PdGains]
    followed: Mapping[str, str]
    robot: Robot
    wanted: Trajectory
    sent: float


def recorded_loop(bag: Bag, path: str | Path, log: JointLog) -> RecordedLoop | str:
    """
    Return the loop that a bag holds, or a sentence why it cannot be closed; '' says nothing of it.

    :param log: the motion of the bag, all joints of the driver.
    :raises BagError: if a controller or a trajectory is recorded that cannot be read.
    """
    entries = read_controllers(bag)
    kinds = {entry['kind'] for entry in entries.values()}
    if PD not in kinds:
        if kinds == {ACTUATOR}:
            return f'the loops of {", ".join(entries)} are in the actuators and not known'
        return ''
    if not kinds <= {PD, ACTUATOR}:
        return (
            'the recording has controllers of different programs, which are not simulated at once'
        )
    sent = bag.trajectories()
    if len(sent) != 1:
        many = f'{len(sent)} trajectories' if sent else 'no trajectory (joint_trajectory)'
        return (
            f'the closed loop needs the one trajectory that was followed, and the bag has {many}'
        )
    try:
        robot = read_nominal(bag, path, None, None).make_robot()
    except ConfigurationError:
        return (
            "the closed loop needs the driver's own model, and the bag has no model_description "
            'or robot_description that can be read'
        )
    gains = {
        name: PdGains(
            **{key: float(entry[key]) for key in ('kp', 'kd', 'limit', 'rate_limit', 'rate')},
            velocity_window=int(entry['velocity_window']),
        )
        for name, entry in entries.items()
        if entry['kind'] == PD
    }
    followed = {
        name: str(entry.get('reason', f"the loop of {name} is its actuator's own"))
        for name, entry in entries.items()
        if entry['kind'] == ACTUATOR
    }
    missing = [
        name
        for name in robot.names
        if name not in log.names or name not in sent[0].names or name not in entries
    ]
    if missing:
        return (
            'the closed loop needs controller, trajectory and position of each joint, and the '
            f'recording lacks one for {", ".join(missing)}'
        )
    if not all(
        min(g.rate, g.rate_limit, g.limit) > 0.0 and g.velocity_window >= 2 for g in gains.values()
    ):
        return 'a recorded controller has a limit, a rate or a velocity window that cannot work'
    if not (np.diff(log.t_ns) >= 0).all():
        return 'the stamps of the recording jump backwards'
    step, rate = float(np.median(np.diff(log.time))), max(g.rate for g in gains.values())
    if not step < _SLOWER / rate:
        return (
            f'the controller ran at {rate:g} Hz and was recorded at {1.0 / max(step, 1e-9):.0f} '
            'Hz: what it saw is not in the recording'
        )
    at = (sent[0].log_time_ns - int(log.t_ns[0])) * 1e-9
    try:
        wanted = Trajectory(sent[0].names, sent[0].times, sent[0].positions, sent[0].velocities)
    except TrajectoryError as error:
        return f'the closed loop needs the trajectory that was followed: {error}'
    return RecordedLoop(gains, followed, robot, wanted.ordered(robot.names), at)


def during(log: JointLog, loop: RecordedLoop) -> tuple[JointLog, RecordedLoop]:
    """
    Return the part of a log in which its trajectory was followed, and the loop as seen from there.

    Samples before and after may belong to a disabled robot, or to another motion.

    :raises DataError: if nothing is left.
    """
    begin, end = loop.sent - _BEFORE_S, loop.sent + loop.wanted.duration + _AFTER_S
    rows = np.flatnonzero((log.time >= begin) & (log.time <= end))
    if not len(rows):
        raise DataError('the trajectory was sent when nothing was recorded')
    return log.rows(rows), replace(loop, sent=loop.sent - float(log.time[rows[0]]))
