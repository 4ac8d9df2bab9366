# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Output error of a recording: with its controller where that is known, else its effort."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.inverse_model import InverseFits
from sosml_friction.identification.output_error.controlled import fit_output_error
from sosml_friction.identification.output_error.output_error_fit import (
    OutputErrorFit,
    relative_error,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.cascade_loop import PARAMETERS, simulate_closed_loop
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint

#: Name of the fit beside the observers.
OUTPUT_ERROR = 'output_error'
#: Width of the sign that is simulated where none is known, as a share of the top speed.
_SHARPNESS = 1e-3


@dataclass(frozen=True)
class ClosedLoopCheck:
    """
    Hold how well a simulation under the recorded controller follows the recording.

    ``position_error`` and ``effort_error`` [%] are 100 |simulated - measured| / |measured|, with
    the ``parameters`` of the fit ``source``.
    """

    source: str
    parameters: Mapping[str, float]
    position_error: float
    effort_error: float


@dataclass(frozen=True)
class OutputErrorFits:
    """
    Hold what forward simulation says of a recording.

    ``joints[joint]`` is the fit where it was asked for; ``modes[joint]`` is ``controller`` or
    ``measured_effort``; ``unavailable[joint]`` says why there is none. ``closed_loop[joint]`` are
    simulations with parameters that were fitted otherwise.
    """

    joints: Mapping[str, OutputErrorFit] = field(default_factory=dict)
    modes: Mapping[str, str] = field(default_factory=dict)
    unavailable: Mapping[str, str] = field(default_factory=dict)
    closed_loop: Mapping[str, ClosedLoopCheck] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``output_error`` of ``sosml fit --json``."""
        return {
            'joints': {
                joint: {
                    'mode': self.modes[joint],
                    'parameters': fit.parameters,
                    'position_error': fit.position_error,
                    'effort_error': fit.effort_error,
                }
                for joint, fit in self.joints.items()
            },
            'unavailable': self.unavailable,
            'closed_loop': self.closed_loop,
        }


def closed_loop_checks(
    log: JointLog,
    robot: Robot,
    controlled: Mapping[str, ControlledJoint],
    inverse: InverseFits,
    smoothing_velocity: Mapping[str, float],
) -> dict[str, ClosedLoopCheck]:
    """
    Simulate each joint under its controller with the parameters of the inverse model.

    Only a robot of one joint that gravity does not move; others have no entry.

    :param smoothing_velocity: v0 of each joint, 0 where it is not known [rad/s or m/s].
    """
    checks: dict[str, ClosedLoopCheck] = {}
    for name, loop in controlled.items():
        fit = inverse.joints.get(name, {}).get('symmetric')
        if fit is None or not is_alone(robot, log):
            continue
        parameters = {key: float(fit.parameters[key].value) for key in PARAMETERS}
        i = log.names.index(name)
        q, effort, time = log.q[:, i], log.tau[:, i], log.time
        known = np.isfinite(q) & np.isfinite(effort) & np.isfinite(loop.reference)
        steps = np.diff(time)
        if not known.all() or not np.isfinite(list(parameters.values())).all():
            continue
        step = float(np.median(steps))
        if not np.allclose(steps, step, rtol=0.05, atol=0.0):
            continue
        width = smoothing_velocity.get(name, 0.0) or sharp_sign(q, step)
        run = simulate_closed_loop(
            loop.reference, step, loop.controller, parameters, float(q[0]), width
        )
        checks[name] = ClosedLoopCheck(
            'inverse_model.symmetric',
            parameters,
            relative_error(run.q, q),
            relative_error(run.effort, effort),
        )
    return checks


def fit_controlled(
    log: JointLog,
    robot: Robot,
    joint: str,
    loop: ControlledJoint,
    start: Mapping[str, float],
    smoothing_velocity: float,
) -> OutputErrorFit:
    """
    Fit a joint so that it moves under its controller as it was measured.

    :param start: first guess, by :data:`~sosml_friction.simulation.cascade_loop.PARAMETERS`.
    :raises DataError: if the robot is not one joint without gravity, or as of
        :func:`~.controlled.fit_output_error`.
    """
    if not is_alone(robot, log):
        raise DataError(
            'the simulation under the controller is of one joint that gravity does not move'
        )
    i = log.names.index(joint)
    steps = np.diff(log.time)
    width = smoothing_velocity or sharp_sign(log.q[:, i], float(np.median(steps)))
    try:
        return fit_output_error(
            log.time,
            log.q[:, i],
            log.tau[:, i],
            loop.reference,
            loop.controller,
            robot.effort_units[i],
            start,
            width,
        )
    except ConfigurationError as error:
        raise DataError(str(error)) from error


def first_guess(
    robot: Robot, i: int, parameters: Mapping[str, Parameter] | None
) -> dict[str, float]:
    """Return inertia of the model and friction of another fit, 0 where it does not say."""
    inertia = float(robot.inertia(np.zeros(robot.n))[i, i])
    guess = {'inertia': inertia}
    for name in PARAMETERS[1:]:
        p = (parameters or {}).get(name)
        guess[name] = float(p.value) if p is not None and np.isfinite(p.value) else 0.0
    return guess


def is_alone(robot: Robot, log: JointLog) -> bool:
    """Return whether a robot is one joint that gravity does not move."""
    if robot.n != 1:
        return False
    ends = np.nanquantile(log.q[:, 0], [0.0, 0.5, 1.0])
    return not any(np.abs(robot.gravity(np.array([q]))).max() > 0.0 for q in ends)


def sharp_sign(q: FloatArray, step: float) -> float:
    """Return a smoothing velocity that is small beside the motion [rad/s or m/s]."""
    speed = np.abs(q[50:] - q[:-50]) / (50 * step) if len(q) > 50 else np.abs(np.diff(q)) / step
    return _SHARPNESS * max(float(np.nanmax(speed, initial=0.0)), 1e-9)
